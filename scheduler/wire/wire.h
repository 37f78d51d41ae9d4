// Between the loop's structs and the messages of proto/seam/v1, without their headers: bytes in and
// out. The gRPC service and the log use the same conversions, so that they cannot drift apart.
#pragma once

#include <string>
#include <string_view>
#include <variant>

#include "scheduler/loop/exchange.h"

namespace seam::v1 {
class Decision;
class Observation;
class SupervisorAction;
class Turn;
}  // namespace seam::v1

namespace seam::scheduler {

// A field that a message must not have like this.
struct FieldError {
  std::string field;    // "walk.vx_m_s"
  std::string message;  // "found nan, expected a number from -10 to 10"
};

// What a client may send beyond the limits of sim_core/body/command.h.
struct WireLimits {
  static constexpr int kMaxMessageBytes = 256 << 10;  // A whole decision; a longer one is refused.
  static constexpr int kMaxReceivedBytes = 4 << 20;   // What gRPC takes in at all.
  static constexpr int kMaxRowsBytes = 192 << 10;     // Of a renderer's pixels in one message.
  static constexpr int kMaxFrameRequests = 8;
  static constexpr uint32_t kMaxFramesARequest = 1000;
  static constexpr int kMaxRadioMessages = 8;
  static constexpr int kMaxDebugItems = 64;
  static constexpr size_t kMaxNameBytes = 64;
  static constexpr size_t kMaxTextBytes = 1024;
  static constexpr int kMaxDrawingPoints = 256;
  static constexpr int kMaxSupervisorActions = 64;
};

// `body` refuses what this body cannot do, such as joints that it has not; without it, as in a log,
// any body's decision is read.
std::variant<Decision, FieldError> decision_from_wire(const v1::Decision& wire,
                                                      int64_t max_radio_bytes,
                                                      const RobotBody* body = nullptr);
void decision_to_wire(const Decision& decision, uint64_t sequence, v1::Decision& wire);
void observation_to_wire(const Observation& observation, v1::Observation& wire);
std::variant<SupervisorAction, FieldError> action_from_wire(const v1::SupervisorAction& wire,
                                                            const std::vector<std::string>& robots);

// A time as a log states it. Throws InputError, with the field, where sums of such times could
// overflow: beyond 73 years, a quarter of what fits.
SimTime time_from_log(int64_t time_ns, std::string_view field);

// `robots`: the ids in the scenario's order, by which a turn names them. `turn_from_wire` throws
// InputError for a message that is no valid turn.
void turn_to_wire(SimTime time, const Turn& turn, const std::vector<std::string>& robots,
                  v1::Turn& wire);
std::pair<SimTime, Turn> turn_from_wire(const v1::Turn& wire,
                                        const std::vector<std::string>& robots);
// The same as bytes.
std::string encode_turn(SimTime time, const Turn& turn, const std::vector<std::string>& robots);
std::pair<SimTime, Turn> decode_turn(std::string_view bytes,
                                     const std::vector<std::string>& robots);

}  // namespace seam::scheduler
