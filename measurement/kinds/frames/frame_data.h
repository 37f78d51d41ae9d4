// A set of whole images with its rig and scene, and the light that a model puts on them.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "measurement/imaging/frame_predictor.h"
#include "measurement/imaging/instruments.h"
#include "measurement/imaging/light_store.h"
#include "measurement/problem/problem.h"
#include "measurement/sets/rig.h"
#include "measurement/sets/set.h"
#include "sim_core/scene/scene_file.h"

namespace seam::measurement {

// What was done: camera, rig, scene and stamps.
class FrameProtocol {
 public:
  FrameProtocol(const MeasurementSet& set, const CsvTable& table, const Instruments& instruments);

  int width_px() const { return width_px_; }
  int height_px() const { return height_px_; }
  size_t frames() const { return stamps_.size(); }
  SimTime stamp(size_t frame) const { return stamps_[frame]; }
  SimTime reference() const { return SimTime::from_ns(rig_.reference_ns()); }
  const Rig& rig() const { return rig_; }
  const SceneFiles& scene_files() const { return scene_->files(); }

  FrameJob job(size_t frame, const Model& model, const Rig::Motion& motion) const;
  std::unique_ptr<FramePredictor> predictor(const Model& model,
                                            Detail detail = Detail::fine) const {
    return make_predictor_(model, width_px_, height_px_, reference(), detail);
  }
  // Light on the sensor in these frames.
  std::vector<LightImage> render(const Model& model, const std::vector<size_t>& frames,
                                 Detail detail) const;

 private:
  MakeFramePredictor make_predictor_;
  int width_px_, height_px_;
  Rig rig_;
  std::unique_ptr<FileScene> scene_;
  std::vector<SimTime> stamps_;
};

}  // namespace seam::measurement
