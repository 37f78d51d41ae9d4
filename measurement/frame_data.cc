#include "measurement/frame_data.h"

#include <algorithm>

#include "effects/row_schedule.h"
#include "effects/timing.h"
#include "sim_core/error.h"
#include "sim_core/scene_file.h"

namespace seam::measurement {
namespace {

MakeFramePredictor& supplied() {
  static MakeFramePredictor make = nullptr;
  return make;
}

// What the light depends on: every effect before the sensor, with its exact values.
std::string light_key(const Model& model) {
  std::string key;
  for (const effects::ModelEffect& effect : model.effects()) {
    if (effect.definition->stage == effects::Stage::sensor) continue;
    key += effect.definition->name;
    for (const double value : effect.values()) key += fmt::format(",{:a}", value);
    key += ';';
  }
  return key;
}

}  // namespace

void supply_frame_predictor(MakeFramePredictor make) { supplied() = make; }

std::unique_ptr<FramePredictor> make_frame_predictor(const Model& model, int width_px, int height_px, SimTime reference) {
  if (!supplied()) throw InputError("sets of kind frames need a renderer, which this program does not have");
  return supplied()(model, width_px, height_px, reference);
}

FrameProtocol::FrameProtocol(const MeasurementSet& set, const CsvTable& table)
    : width_px_(set.camera.width_px), height_px_(set.camera.height_px), rig_(Rig::from_set(set)) {
  if (width_px_ == 0) set.root.fail("camera: is missing: a set of frames needs width_px and height_px");
  if (rig_.type() == Rig::Type::unknown) {
    set.root.at("rig").fail("found an unknown pose, expected a chain or measured poses: frames are rendered from known poses");
  }
  if (table.rows() == 0) throw InputError(fmt::format("{}: no frames, expected at least one", table.file()));
  scene_ = read_scene(set.folder / set.root.at("scene").text());
  for (const int64_t ns : table.times_ns("time_s")) stamps_.push_back(SimTime::from_ns(ns));
}

FrameJob FrameProtocol::job(size_t frame, const Model& model, const Rig::Motion& motion) const {
  FrameJob job;
  job.frame_index = frame;
  job.stamp = stamps_[frame];
  const effects::RowScheduleOptions options{.instants_per_row = 12, .reference = reference()};
  job.schedule = effects::make_row_schedule(effects::timing_of(model), job.stamp, height_px_, options);
  job.background = scene_->background();
  job.lighting = scene_->lighting();
  for (const SimTime time : job.schedule.instants) {
    SceneInstant instant{.time = time};
    instant.X_WC = motion.X_WC((time - reference()).s());
    scene_->primitives_at(time, instant.primitives);
    job.instants.push_back(std::move(instant));
  }
  return job;
}

LightStore::LightStore(const FrameProtocol& protocol) : protocol_(protocol) {
  const size_t bytes = static_cast<size_t>(protocol.width_px()) * protocol.height_px() * 3 * sizeof(float) * protocol.frames();
  capacity_ = std::clamp<size_t>(200'000'000 / std::max<size_t>(bytes, 1), 4, 64);
}

std::vector<LightImage> LightStore::light(const Model& model, const std::vector<size_t>& frames) const {
  const std::string key = light_key(model);
  std::vector<LightImage> out(frames.size());
  const auto find_entry = [&]() -> Entry& {
    const auto found = std::find_if(entries_.begin(), entries_.end(), [&](const Entry& entry) { return entry.key == key; });
    if (found == entries_.end()) {
      entries_.push_front({key, std::vector<LightImage>(protocol_.frames())});
      if (entries_.size() > capacity_) entries_.pop_back();
    } else {
      entries_.splice(entries_.begin(), entries_, found);
    }
    return entries_.front();
  };
  bool complete = true;
  {
    const std::scoped_lock lock(mutex_);
    const Entry& entry = find_entry();
    for (size_t i = 0; i < frames.size(); ++i) {
      out[i] = entry.frames[frames[i]];
      complete = complete && out[i];
    }
  }
  if (complete) return out;
  const auto predictor = make_frame_predictor(model, protocol_.width_px(), protocol_.height_px(), protocol_.reference());
  const Rig::Motion motion = protocol_.rig().motion(model);
  for (size_t i = 0; i < frames.size(); ++i) {
    if (!out[i]) out[i] = std::make_shared<const std::vector<float>>(predictor->light(protocol_.job(frames[i], model, motion)));
  }
  const std::scoped_lock lock(mutex_);
  Entry& entry = find_entry();
  for (size_t i = 0; i < frames.size(); ++i) entry.frames[frames[i]] = out[i];
  return out;
}

}  // namespace seam::measurement
