#include "measurement/kinds/frames/frame_data.h"

#include "effects/questions.h"
#include "effects/stages/row_schedule.h"
#include "effects/stages/timing.h"
#include "measurement/numerics/parallel_for.h"
#include "sim_core/base/error.h"
#include "sim_core/scene/scene_file.h"

namespace seam::measurement {

FrameProtocol::FrameProtocol(const MeasurementSet& set, const CsvTable& table,
                             const Instruments& instruments)
    : width_px_(set.camera.width_px), height_px_(set.camera.height_px), rig_(Rig::from_set(set)) {
  if (!instruments.render)
    throw InputError("sets of kind frames need a renderer, which this program does not have");
  if (width_px_ == 0)
    set.root.fail("camera: is missing: a set of frames needs width_px and height_px");
  if (rig_.type() == Rig::Type::unknown) {
    set.root.at("rig").fail(
        "found an unknown pose, expected a chain or measured poses: frames are rendered from known "
        "poses");
  }
  if (table.rows() == 0)
    throw InputError(fmt::format("{}: no frames, expected at least one", table.file()));
  scene_ = read_scene(set.inside(set.root.at("scene")));
  make_predictor_ = instruments.render(scene_->files());
  for (const int64_t ns : table.times_ns("time_s")) stamps_.push_back(SimTime::from_ns(ns));
}

FrameJob FrameProtocol::job(size_t frame, const Model& model, const Rig::Motion& motion) const {
  FrameJob job;
  job.frame_index = frame;
  job.stamp = stamps_[frame];
  const effects::RowScheduleOptions options{.instants_per_row = 12, .reference = reference()};
  job.schedule =
      effects::make_row_schedule(effects::timing_of(model), job.stamp, height_px_, options);
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

std::vector<LightImage> FrameProtocol::render(const Model& whole, const std::vector<size_t>& frames,
                                              Detail detail) const {
  const Model model = effects::without_points_own(whole);
  const auto frame_predictor = predictor(model, detail);
  const Rig::Motion motion = rig_.motion(model);
  std::vector<LightImage> light(frames.size());
  parallel_for(frames.size(), [&](size_t k) {
    light[k] = std::make_shared<const std::vector<float>>(
        frame_predictor->light(job(frames[k], model, motion)));
  });
  return light;
}

}  // namespace seam::measurement
