#include "app/import/kinds/log_frames.h"

#include <fmt/ranges.h>

#include <algorithm>
#include <map>

#include "app/import/draft/walk_draft.h"
#include "app/import/kinds/log_scene.h"
#include "app/logs/replay_match.h"
#include "app/simulator.h"
#include "effects/stages/geometry.h"
#include "scheduler/replay/frame_maker.h"
#include "sim_core/base/error.h"
#include "sim_core/base/image.h"

namespace seam::app {
namespace {

// Holding a model against whole images costs a rendering each.
constexpr size_t kMostFramesOfSet = 60;

struct Taken {
  uint64_t index = 0;
  SimTime stamp;
  uint64_t fingerprint = 0;
};

std::vector<Taken> frames_of(const scheduler::Log& log, size_t robot) {
  std::vector<Taken> taken;
  scheduler::LogCursor cursor(log, {scheduler::Topic::frame});
  while (const auto record = cursor.next()) {
    const auto* frame = std::get_if<scheduler::FrameRecord>(&*record);
    if (frame != nullptr && frame->robot == static_cast<int>(robot))
      taken.push_back({frame->index, frame->stamp, frame->fingerprint});
  }
  std::sort(taken.begin(), taken.end(),
            [](const Taken& a, const Taken& b) { return a.index < b.index; });
  return taken;
}

// The bases of the model alone: what a data sheet says of a camera.
std::string base_effects(const effects::Model& model) {
  std::string text;
  for (const effects::ModelEffect& effect : model.effects()) {
    const effects::EffectDefinition& definition = *effect.definition;
    if (definition.base != effects::Base::projection &&
        definition.replaces_base != effects::Base::projection)
      continue;
    std::vector<std::string> values;
    for (size_t i = 0; i < effect.parameters.size(); ++i)
      values.push_back(
          fmt::format("{}: {}", definition.parameters[i].name, exact(effect.parameters[i].value)));
    text += fmt::format("  {}: {{{}}}\n", definition.name, fmt::join(values, ", "));
  }
  return text;
}

class FramesDraft {
 public:
  FramesDraft(const scheduler::Log& log, size_t robot, SetDraft& draft)
      : log_(log), robot_(robot), draft_(draft), match_(log) {}

  void fill() {
    const auto all = frames_of(log_, robot_);
    if (all.empty())
      throw InputError(
          fmt::format("{}: the camera of {} took no frame (every_frame: true in the "
                      "scenario, or a behaviour that asks for them)",
                      log_.name(), log_.header().robots[robot_]));
    const size_t stride = (all.size() + kMostFramesOfSet - 1) / kMostFramesOfSet;
    for (size_t i = 0; i < all.size(); i += stride) chosen_.push_back(all[i]);
    add_poses();
    add_scene();
    const size_t made = add_pictures(stride == 1);
    draft_.kind = "frames";
    draft_.group = "frame";
    draft_.rig = "{poses: poses.csv}";
    draft_.effects = base_effects(models_of(match_.scenario())[robot_]);
    draft_.did(
        fmt::format("{} of {} frames that were taken, made again from the log", made, all.size()));
    draft_.did(
        "the camera's true poses in poses.csv, as if it sat straight in its head: a camera that "
        "is mounted askew shows");
    draft_.did("the nominal model is the camera's projection, without lens, rows, light and noise");
  }

 private:
  // Frames are exposed around their stamps.
  static constexpr SimDuration margin() { return SimDuration::from_ns(120'000'000); }

  void add_poses() {
    const SimDuration step = match_.scenario().step;
    constexpr int64_t kFine_ns = 2'000'000;
    const int64_t parts = std::max<int64_t>(1, step.ns() / kFine_ns);
    const Pose axes = effects::mount_of(effects::Model());
    const SimTime from = std::max(SimTime(), chosen_.front().stamp - margin());
    const SimTime to = std::min(log_.end_time(), chosen_.back().stamp + margin());
    measurement::CsvWriter table({"time_s", "x_m", "y_m", "z_m", "qw", "qx", "qy", "qz"});
    for (int64_t k = from.ns() / step.ns() * parts;; ++k) {
      const SimTime time = SimTime::from_ns(k / parts * step.ns() + k % parts * step.ns() / parts);
      if (time > to || match_.rewinder().to(time) != time) break;
      const Pose X_WC = match_.world().camera_link_pose(robot_, time) * axes;
      const auto q = quaternion_of(X_WC.R);
      table.row({seconds_text(time.ns()), fmt::format("{:.9f}", X_WC.p.x),
                 fmt::format("{:.9f}", X_WC.p.y), fmt::format("{:.9f}", X_WC.p.z),
                 fmt::format("{:.12f}", q[0]), fmt::format("{:.12f}", q[1]),
                 fmt::format("{:.12f}", q[2]), fmt::format("{:.12f}", q[3])});
    }
    draft_.add_table("poses", table);
  }

  void add_scene() {
    std::vector<SceneAt> instants;
    for (const size_t i : {size_t{0}, chosen_.size() / 2, chosen_.size() - 1}) {
      if (!instants.empty() && instants.back().time == chosen_[i].stamp) continue;
      SceneAt at{.time = chosen_[i].stamp, .primitives = {}};
      match_.rewinder().to(at.time);
      match_.world().primitives_at(at.time, at.primitives);
      // The robot whose camera it is sees nothing of itself as long as it looks ahead.
      const Label body = Label::robot_body;
      std::erase_if(at.primitives, [&](const Primitive& part) {
        const bool limb =
            part.label == body || part.label == Label::robot_red || part.label == Label::robot_blue;
        return limb && part.object_id == kFirstRobotId + robot_;
      });
      instants.push_back(std::move(at));
    }
    draft_.scene = "scene.yaml";
    draft_.add_file("scene.yaml", scene_yaml(instants, match_.world().background(),
                                             match_.world().lighting(), draft_));
  }

  // How many came out; those whose rows end behind the log's end do not.
  size_t add_pictures(bool in_one) {
    std::map<uint64_t, uint64_t> expected;
    for (const Taken& frame : chosen_) expected[frame.index] = frame.fingerprint;
    measurement::CsvWriter table({"frame", "file", "time_s"});
    size_t made = 0, other = 0;
    const auto take = [&](const scheduler::FinishedFrame& finished) {
      const Frame& frame = *finished.frame;
      const auto wanted = expected.find(frame.frame_index);
      if (wanted == expected.end()) return;
      other += wanted->second != frame.fingerprint ? 1 : 0;
      Image image{.width_px = frame.width_px, .height_px = frame.height_px, .channels = 3};
      image.samples.assign(frame.rgb.begin(), frame.rgb.end());
      const std::string file = fmt::format("frames/{:06}.png", frame.frame_index);
      draft_.add_file(file, encode_png(image));
      table.row({fmt::format("{}", frame.frame_index), file, seconds_text(frame.stamp.ns())});
      draft_.camera = {.width_px = frame.width_px, .height_px = frame.height_px, .channels = "rgb"};
      ++made;
    };
    const auto make = [&](SimTime from, SimTime to) {
      scheduler::make_frames(match_.rewinder(), match_.renderer(), static_cast<int>(robot_), from,
                             to, take);
    };
    if (in_one) {
      make(chosen_.front().stamp, chosen_.back().stamp);
    } else {
      for (const Taken& frame : chosen_) make(frame.stamp, frame.stamp);
    }
    if (made == 0)
      throw InputError(fmt::format("{}: ends before its first frame does", log_.name()));
    draft_.add_table("frames", table);
    if (chosen_.size() > 1)
      draft_.camera.frame_period_s = match_.scenario().robots[robot_].camera.clock.period.s();
    if (other > 0)
      draft_.warn(fmt::format(
          "{} of {} pictures are not to the last bit those of the run{}", other, made,
          match_.why_other_pixels().empty() ? std::string() : ": " + match_.why_other_pixels()));
    return made;
  }

  static constexpr uint16_t kFirstRobotId = 2;  // Of World's primitives.

  const scheduler::Log& log_;
  size_t robot_;
  SetDraft& draft_;
  ReplayMatch match_;
  std::vector<Taken> chosen_;
};

}  // namespace

void draft_frames(const scheduler::Log& log, size_t robot, SetDraft& draft) {
  FramesDraft(log, robot, draft).fill();
}

}  // namespace seam::app
