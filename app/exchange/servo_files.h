// Servos in the files of simulators: attributes of a joint and its actuator.
#pragma once

#include <string>
#include <vector>

#include "app/exchange/exchange.h"
#include "effects/stages/servo.h"

namespace seam::app {

// Elements of MuJoCo's MJCF, and of a URDF.
std::string mjcf_text(const effects::Model& model, const effects::ServoModel& servo,
                      const ServoGains& gains);
std::string urdf_text(const effects::Model& model, const effects::ServoModel& servo,
                      const ServoGains& gains);
// Whether the format has a place for all that stands in a servo.
bool mjcf_holds(const effects::ServoModel& servo);
bool urdf_holds(const effects::ServoModel& servo);

// Throws InputError for names in `drop` that the model does not have or cannot be without.
void check_drops(const effects::Model& model, const ExportOptions& options);

// As export_model, of formats that hold servos.
Exported export_servo(const effects::Model& model, const ExchangeFormat& format,
                      const ExportOptions& options);

}  // namespace seam::app
