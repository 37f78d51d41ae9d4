// From wire messages to the SDK's plain structs.
#pragma once

#include "robot_sdk/robot.h"

namespace seam::v1 {
class Observation;
}

namespace seam::sdk {

Observation from_wire(const v1::Observation& message);

}  // namespace seam::sdk
