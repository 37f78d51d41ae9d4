// Models in the files of other programs (`seam export`). A format holds some of what a model says:
// a lens, the time of rows, a shift of the clock. What it cannot hold is refused with the effect's
// name, or dropped where the user says so, and then its cost is reported.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "app/exchange/lens.h"
#include "effects/model.h"
#include "effects/stages/servo.h"
#include "effects/stages/timing.h"
#include "sim_core/base/pose.h"

namespace seam::effects {
struct Inertial;  // stages/noise.h
}

namespace seam::app {

// A camera as formats hold it.
struct PlainCamera {
  std::string name;
  int width_px = 0, height_px = 0;
  Lens lens;
  double line_delay_s = 0;
  // What is added to a frame's stamp for the middle of its first row's exposure, by the clock of
  // the joints' log.
  double time_shift_s = 0;
  // Where it stands in the first camera's frame, of a rig; none: not known.
  std::optional<Pose> X_FC = std::nullopt;
  // Standard errors of fx, fy, cx and cy; none: the file states none.
  std::optional<std::array<double, 4>> sigma_px = std::nullopt;
};

// The controller's gains (column kp) of the servo's log, each once.
struct ServoGains {
  bool known = false;          // A log was named; without a column kp its gain counts as 1.
  std::vector<double> values;  // Ascending.
};

struct PlainImu;  // imu_files.h

struct ExchangeFormat {
  std::string name;  // Of `--to`.
  std::string help;
  std::string ending = ".yaml";    // Of its files' names.
  std::vector<LensFamily> lenses;  // Simplest first.
  bool holds_line_delay = false;
  bool holds_time_shift = false;
  std::string (*text)(const PlainCamera& camera) = nullptr;
  // Of one that holds a lens of splines as it is.
  std::string (*text_of_splines)(const PlainCamera& camera,
                                 const effects::ModelEffect& splines) = nullptr;
  // Of a format that holds whatever a model says; then it has no `text`.
  std::string (*text_of_all)(const effects::Model& model) = nullptr;
  // Of a format that holds a servo instead of a camera.
  std::string (*text_of_servo)(const effects::Model& model, const effects::ServoModel& servo,
                               const ServoGains& gains) = nullptr;
  bool (*holds_servo)(const effects::ServoModel& servo) = nullptr;
  bool holds_gain = false;
  // Of a format that holds the noise of inertial sensors.
  std::string (*text_of_imu)(const PlainImu& imu) = nullptr;
  // Of one that holds how a camera and an inertial sensor stand to each other.
  std::string (*text_of_rig)(const effects::Inertial& inertial) = nullptr;
};

const std::vector<ExchangeFormat>& exchange_formats();
// Throws UsageError, which begins with the `option` that gave the name.
const ExchangeFormat& exchange_format_named(const std::string& name, const std::string& option);

struct ExportOptions {
  int width_px = 0, height_px = 0;  // Of the image; 0: twice the principal point.
  std::vector<std::string> drop;    // Names of effects, or "all".
  std::string form;                 // Of the lens, by name_of; empty: whichever fits.
  ServoGains gains;
  double rate_hz = 0;  // Of inertial sensors; 0: not known.
};

struct Exported {
  std::string text;
  std::string form;                // Of the lens, in words; empty: no lens.
  std::vector<std::string> notes;  // Sentences: what was assumed, approximated, dropped at a cost.
};

// Throws InputError with the name of the first effect that the format does not hold and that is not
// to be dropped.
Exported export_model(const effects::Model& model, const ExchangeFormat& format,
                      const ExportOptions& options);

}  // namespace seam::app
