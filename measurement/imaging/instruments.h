// What some kinds of measurement need beyond the effects: a renderer, detectors, whole runs. They
// come in as arguments, from whoever puts the program together (app/), so that measurement/ knows
// none of them.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "sim_core/base/time.h"

namespace seam {
struct SceneFiles;
}
namespace seam::effects {
class Model;
}

namespace seam::measurement {

class FramePredictor;  // frame_predictor.h
enum class Detail;
class RangeDetector;  // range_detector.h
struct RangeDetectorSpec;
class RunMaker;  // run_maker.h
struct RunSpec;

// `reference` is the time from which drift, flicker and formulas of time count. Throws InputError
// for a model that gives no image.
using MakeFramePredictor = std::function<std::unique_ptr<FramePredictor>(
    const effects::Model& model, int width_px, int height_px, SimTime reference, Detail detail)>;

// For a scene whose objects name these files, which are read once. Throws InputError for files that
// cannot be had.
using OpenFrameRenderer = std::function<MakeFramePredictor(const SceneFiles& files)>;

// Nothing for a name that is none of `Instruments::detectors`; throws InputError for a colour table
// that cannot be read.
using MakeRangeDetector =
    std::function<std::unique_ptr<RangeDetector>(const RangeDetectorSpec& spec)>;

// Reads the plans; throws InputError naming file, line and key.
using OpenRuns = std::function<std::unique_ptr<RunMaker>(const RunSpec& spec)>;

// Parts may be missing: sets that need them are then refused with the reason.
struct Instruments {
  OpenFrameRenderer render;
  MakeRangeDetector detect;
  std::vector<std::string> detectors;  // The behaviours that `detect` knows.
  OpenRuns runs;
};

}  // namespace seam::measurement
