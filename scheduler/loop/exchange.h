// What the loop and the robots' clients say to each other, free of gRPC. The wire (proto/seam/v1)
// and the log carry the same things; conversions: wire.h.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "sim_core/base/time.h"
#include "sim_core/body/command.h"
#include "sim_core/scene/frame.h"
#include "sim_core/world/radio.h"
#include "sim_core/world/referee.h"
#include "sim_core/world/sensors.h"

namespace seam::scheduler {

// Which frames of its camera a robot wants.
struct FrameRequest {
  enum class Which : uint8_t { next, all, none };
  Which which = Which::next;  // `all` holds until `none`.
  uint32_t count = 1;         // For `next`: this many frames in a row.
  SimTime after;              // For `next`: the first whose stamp is not before this time.
};

// Something a client wants to see in the log; never part of the state.
struct DebugItem {
  enum class Kind : uint8_t { value, text, drawing };
  Kind kind = Kind::text;
  std::string name;
  double value = 0;            // For `value`.
  std::string text;            // For `text`.
  std::vector<double> points;  // For `drawing`: x, y pairs, metres in W or pixels by `in_image`.
  bool in_image = false;
  // Of a drawing in the image: its frame. None: the newest that the robot had when it decided.
  std::optional<uint64_t> frame_index;
};

// A client's answer to one observation; acts at the observation's time + the decision latency.
struct Decision {
  RobotCommand command;
  std::vector<FrameRequest> frame_requests;
  std::vector<std::string> messages;  // To team mates over the radio, sent when the decision acts.
  std::vector<DebugItem> debug;
};

// What became of a robot's turn.
enum class Outcome : uint8_t {
  decided,  // It decided.
  frozen,   // The policy froze it now: it stops walking and holds its joints.
  absent,   // It is frozen since earlier, or has no client.
  resumed,  // It was frozen, is back, and decided.
  abort,    // The policy ends the run.
};

struct Answer {
  int robot = 0;          // Its number in the scenario.
  uint64_t sequence = 0;  // Of the observation.
  Outcome outcome = Outcome::decided;
  Decision decision;   // Of `decided` and `resumed`; else empty.
  std::string reason;  // For people: why it was frozen or the run aborted.
};

// What the supervisor does to the world; acts 1 ns after the instant at which it was taken up.
struct SupervisorAction {
  enum class Kind : uint8_t { place_ball, place_robot, set_game_state };
  Kind kind = Kind::place_ball;
  int robot = -1;           // For place_robot.
  Vec3 position_m{0.0};     // W; of a robot's body x and y count.
  Vec3 velocity_m_s{0.0};   // Of the ball.
  double heading_rad = 0;   // Of a robot.
  uint32_t game_state = 0;  // As the wire numbers them.
};

enum class EventKind : uint8_t {
  referee,  // Kick-off, goal, penalty, ...: part of the state, the same in a re-run.
  radio,    // Sent, delivered, lost: part of the state.
  world,    // A kick, a grab, ...: part of the state.
  policy,   // A client was frozen, resumed, or the run aborted: comes from outside, and a re-run
            // repeats it from the log.
  fault,    // A refused message, a lost connection: information only, depends on wall time.
  debug,    // A client's log_value, log_text, log_drawing.
};

struct SimulationEvent {
  SimTime time;
  EventKind kind = EventKind::referee;
  std::string robot;   // Empty where no robot is concerned.
  std::string name;    // "goal", "freeze", "log_value/pan", ...
  std::string detail;  // For people; for debug items the value, text or drawing.
};

// All that reaches the run from outside at one instant at which decisions were owed.
struct Turn {
  std::vector<Answer> answers;  // One for each observation, in the same order.
  std::vector<SupervisorAction> actions;
};

// What one robot gets at one instant: its own sensors, its own frames, its team's messages, and
// what the referee announces.
struct Observation {
  int robot = 0;
  uint64_t sequence = 0;  // 1, 2, ... for each robot.
  SimTime time;
  RobotSensors sensors;  // Its joint log: encoders since the last observation.
  std::vector<std::shared_ptr<const Frame>> frames;  // Finished since the last observation.
  std::vector<RadioMessage> messages;                // Arrived since the last observation.
  GameState game;
};

}  // namespace seam::scheduler
