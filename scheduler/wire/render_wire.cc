#include "scheduler/wire/render_wire.h"

#include <cstring>

#include "seam/v1/render.pb.h"
#include "sim_core/base/error.h"

namespace seam::scheduler {

namespace {

using Doubles = google::protobuf::RepeatedField<double>;
constexpr int kPoseNumbers = 12;
constexpr uint32_t kMaxPrimitives = 1 << 20;

// ---- Numbers, bit for bit ----

template <class Numbers>
void add_all(const Numbers& numbers, Doubles& wire) {
  for (int k = 0; k < 3; ++k) wire.Add(numbers[k]);
}

void add_pose(const Pose& X, Doubles& wire) {
  for (int column = 0; column < 3; ++column) add_all(X.R[column], wire);
  add_all(X.p, wire);
}

void check_count(const char* field, int found, int expected) {
  if (found != expected)
    throw InputError(fmt::format("{}: found {} values, expected {}", field, found, expected));
}

template <class Numbers>
Numbers three(const char* field, const Doubles& wire) {
  check_count(field, wire.size(), 3);
  Numbers numbers;
  for (int k = 0; k < 3; ++k) numbers[k] = wire[k];
  return numbers;
}

Pose pose_at(const Doubles& wire, int first) {
  Pose X;
  for (int column = 0; column < 3; ++column)
    for (int row = 0; row < 3; ++row) X.R[column][row] = wire[first + 3 * column + row];
  for (int k = 0; k < 3; ++k) X.p[k] = wire[first + 9 + k];
  return X;
}

template <class Value>
bool same_bits(const Value& a, const Value& b) {
  return std::memcmp(&a, &b, sizeof(Value)) == 0;  // Doubles alone: no padding.
}

bool same_part(const Primitive& a, const Primitive& b) {
  return a.shape == b.shape && a.label == b.label && a.object_id == b.object_id &&
         a.asset == b.asset && same_bits(a.size, b.size) && same_bits(a.rgb, b.rgb);
}

// ---- Primitives ----

void primitive_to_wire(const Primitive& primitive, v1::ScenePrimitive& wire) {
  wire.set_shape(static_cast<uint32_t>(primitive.shape));
  wire.set_label(static_cast<uint32_t>(primitive.label));
  wire.set_object_id(primitive.object_id);
  add_pose(primitive.X_WO, *wire.mutable_pose());
  add_all(primitive.size, *wire.mutable_size());
  add_all(primitive.rgb, *wire.mutable_rgb());
  wire.set_asset(primitive.asset);
}

Primitive primitive_from_wire(const v1::ScenePrimitive& wire) {
  if (wire.shape() > static_cast<uint32_t>(Shape::mesh))
    throw InputError(fmt::format("shape: found {}, expected a known one", wire.shape()));
  if (wire.label() > static_cast<uint32_t>(Label::other))
    throw InputError(fmt::format("label: found {}, expected a known one", wire.label()));
  check_count("pose", wire.pose_size(), kPoseNumbers);
  return {.shape = static_cast<Shape>(wire.shape()),
          .label = static_cast<Label>(wire.label()),
          .object_id = static_cast<uint16_t>(wire.object_id()),
          .X_WO = pose_at(wire.pose(), 0),
          .size = three<Vec3>("size", wire.size()),
          .rgb = three<Rgb>("rgb", wire.rgb()),
          .asset = wire.asset()};
}

void instant_to_wire(const std::vector<Primitive>& before, const std::vector<Primitive>& primitives,
                     const SceneInstant& instant, v1::RenderInstant& wire) {
  wire.set_time_ns(instant.time.ns());
  add_pose(instant.X_WC, *wire.mutable_camera());
  wire.set_primitives(static_cast<uint32_t>(primitives.size()));
  for (size_t i = 0; i < primitives.size(); ++i) {
    const Primitive& now = primitives[i];
    if (i >= before.size() || !same_part(before[i], now)) {
      wire.add_replaced(static_cast<uint32_t>(i));
      primitive_to_wire(now, *wire.add_with());
    } else if (!same_bits(before[i].X_WO, now.X_WO)) {
      wire.add_moved(static_cast<uint32_t>(i));
      add_pose(now.X_WO, *wire.mutable_poses());
    }
  }
}

SceneInstant instant_from_wire(const std::vector<Primitive>& before,
                               const v1::RenderInstant& wire) {
  check_count("camera", wire.camera_size(), kPoseNumbers);
  check_count("with", wire.with_size(), wire.replaced_size());
  check_count("poses", wire.poses_size(), kPoseNumbers * wire.moved_size());
  const uint32_t count = wire.primitives();
  if (count > kMaxPrimitives)
    throw InputError(
        fmt::format("primitives: found {}, expected at most {}", count, kMaxPrimitives));
  SceneInstant instant{SimTime::from_ns(wire.time_ns()), pose_at(wire.camera(), 0), before, {}};
  instant.primitives.resize(count);
  const auto place = [&](const char* field, uint32_t index) -> Primitive& {
    if (index >= count)
      throw InputError(fmt::format("{}: found place {} of {} primitives", field, index, count));
    return instant.primitives[index];
  };
  for (int i = 0; i < wire.replaced_size(); ++i)
    place("replaced", wire.replaced(i)) = primitive_from_wire(wire.with(i));
  for (int i = 0; i < wire.moved_size(); ++i)
    place("moved", wire.moved(i)).X_WO = pose_at(wire.poses(), kPoseNumbers * i);
  return instant;
}

// ---- Row schedules ----

void schedule_to_wire(const RowSchedule& schedule, v1::RenderJob& wire) {
  for (const RowWindow& row : schedule.rows) {
    wire.add_row_start_ns(row.start.ns());
    wire.add_row_end_ns(row.end.ns());
  }
  for (const int first : schedule.first_instant)
    wire.add_first_instant(static_cast<uint32_t>(first));
  for (const std::vector<double>& weights : schedule.weights) {
    wire.add_weight_count(static_cast<uint32_t>(weights.size()));
    for (const double weight : weights) wire.add_weights(weight);
  }
}

RowSchedule schedule_from_wire(const v1::RenderJob& wire, int height_px) {
  check_count("row_start_ns", wire.row_start_ns_size(), height_px);
  check_count("row_end_ns", wire.row_end_ns_size(), height_px);
  check_count("first_instant", wire.first_instant_size(), height_px);
  check_count("weight_count", wire.weight_count_size(), height_px);
  RowSchedule schedule;
  for (const v1::RenderInstant& instant : wire.instants())
    schedule.instants.push_back(SimTime::from_ns(instant.time_ns()));
  auto weight = wire.weights().begin();
  for (int row = 0; row < height_px; ++row) {
    schedule.rows.push_back(
        {SimTime::from_ns(wire.row_start_ns(row)), SimTime::from_ns(wire.row_end_ns(row))});
    const uint64_t first = wire.first_instant(row);
    const uint64_t count = wire.weight_count(row);
    if (count == 0 || first + count > schedule.instants.size())
      throw InputError(fmt::format("first_instant: row {} has the {} instants from {} on, of {}",
                                   row, count, first, schedule.instants.size()));
    if (static_cast<uint64_t>(wire.weights().end() - weight) < count)
      throw InputError(
          fmt::format("weights: found {}, fewer than the rows have", wire.weights_size()));
    schedule.first_instant.push_back(static_cast<int>(first));
    schedule.weights.emplace_back(weight, weight + static_cast<std::ptrdiff_t>(count));
    weight += static_cast<std::ptrdiff_t>(count);
  }
  return schedule;
}

}  // namespace

void setup_to_wire(const RenderSetup& setup, v1::RenderSetup& wire) {
  wire.set_version(setup.version);
  for (const RenderCamera& camera : setup.cameras) {
    v1::RenderCamera& out = *wire.add_cameras();
    out.set_robot(camera.robot);
    out.set_width_px(static_cast<uint32_t>(camera.width_px));
    out.set_height_px(static_cast<uint32_t>(camera.height_px));
    out.set_model_yaml(camera.model_yaml);
    out.set_model_name(camera.model_name);
  }
  for (const Primitive& primitive : setup.scene) primitive_to_wire(primitive, *wire.add_scene());
  add_all(setup.background, *wire.mutable_background_rgb());
  wire.set_lambert(setup.lighting.lambert);
  add_all(setup.lighting.direction_W, *wire.mutable_light_direction());
  wire.set_ambient(setup.lighting.ambient);
  wire.set_diffuse(setup.lighting.diffuse);
  wire.set_samples_per_pixel(static_cast<uint32_t>(setup.samples_per_pixel));
  wire.set_edge_samples_per_pixel(static_cast<uint32_t>(setup.edge_samples_per_pixel));
  wire.set_max_motion_px(setup.max_motion_px);
  wire.set_reference_ns(setup.reference.ns());
  wire.set_opengl(setup.opengl);
  wire.set_opengl_from(setup.opengl_from);
  wire.set_assets(setup.assets);
}

RenderSetup setup_from_wire(const v1::RenderSetup& wire) {
  RenderSetup setup;
  setup.version = wire.version();
  for (const v1::RenderCamera& camera : wire.cameras())
    setup.cameras.push_back({camera.robot(), static_cast<int>(camera.width_px()),
                             static_cast<int>(camera.height_px()), camera.model_yaml(),
                             camera.model_name()});
  for (const v1::ScenePrimitive& primitive : wire.scene())
    setup.scene.push_back(primitive_from_wire(primitive));
  setup.background = three<Rgb>("background_rgb", wire.background_rgb());
  setup.lighting = {.lambert = wire.lambert(),
                    .direction_W = three<Vec3>("light_direction", wire.light_direction()),
                    .ambient = wire.ambient(),
                    .diffuse = wire.diffuse()};
  setup.samples_per_pixel = static_cast<int>(wire.samples_per_pixel());
  setup.edge_samples_per_pixel = static_cast<int>(wire.edge_samples_per_pixel());
  setup.max_motion_px = wire.max_motion_px();
  setup.reference = SimTime::from_ns(wire.reference_ns());
  setup.opengl = wire.opengl();
  setup.opengl_from = wire.opengl_from();
  setup.assets = wire.assets();
  return setup;
}

void job_to_wire(const RenderSetup& setup, uint64_t number, int robot, const FrameJob& job,
                 v1::RenderJob& wire) {
  wire.set_number(number);
  wire.set_robot(static_cast<uint32_t>(robot));
  wire.set_frame_index(job.frame_index);
  wire.set_stamp_ns(job.stamp.ns());
  schedule_to_wire(job.schedule, wire);
  std::vector<Primitive> before = setup.scene;
  for (const SceneInstant& instant : job.instants) {
    std::vector<Primitive> here = all_primitives(job, instant);
    instant_to_wire(before, here, instant, *wire.add_instants());
    before = std::move(here);
  }
  for (const RandomStream& noise : {job.camera_noise, job.frame_noise}) {
    wire.add_noise(noise.seed);
    wire.add_noise(noise.stream);
  }
}

FrameJob job_from_wire(const RenderSetup& setup, const v1::RenderJob& wire) {
  if (wire.robot() >= setup.cameras.size())
    throw InputError(
        fmt::format("robot: found {} of {} cameras", wire.robot(), setup.cameras.size()));
  const RenderCamera& camera = setup.cameras[wire.robot()];
  FrameJob job;
  job.robot = camera.robot;
  job.frame_index = wire.frame_index();
  job.stamp = SimTime::from_ns(wire.stamp_ns());
  job.schedule = schedule_from_wire(wire, camera.height_px);
  job.instants.reserve(static_cast<size_t>(wire.instants_size()));
  for (const v1::RenderInstant& instant : wire.instants())
    job.instants.push_back(instant_from_wire(
        job.instants.empty() ? setup.scene : job.instants.back().primitives, instant));
  job.background = setup.background;
  job.lighting = setup.lighting;
  check_count("noise", wire.noise_size(), 4);
  job.camera_noise = {wire.noise(0), wire.noise(1)};
  job.frame_noise = {wire.noise(2), wire.noise(3)};
  return job;
}

}  // namespace seam::scheduler
