// A robot learns nothing but what its own observations hold: whatever it calls, with whatever
// token, and whatever it forges inside messages. Calls and fields are taken from the descriptors of
// the wire, so that one that is added later fails here until somebody has thought about it.
#include <gmock/gmock.h>
#include <google/protobuf/dynamic_message.h>
#include <google/protobuf/unknown_field_set.h>

#include <mutex>
#include <set>

#include "scheduler/server/live_testing.h"
#include "seam/v1/render.grpc.pb.h"
#include "sim_core/base/hash.h"

namespace seam::scheduler {
namespace {

using ::testing::IsEmpty;
using ::testing::UnorderedElementsAre;
using namespace seam::scheduler::testing;  // NOLINT: helpers of this folder's tests.
namespace pb = google::protobuf;

std::string separate_scenario(int robots, double duration_s = 0.4) {
  return scenario_text(SEAM_SOURCE_DIR, robots, duration_s);
}

// Whoever is no supervisor: nobody, robots, the renderer, and who knows nearly the right word.
std::vector<std::string> wrong_tokens() {
  return {"",         "token-r0",
          "token-r1", "picture",
          "guess",    "bos",
          "boss ",    "boss" + std::string(1, '\0'),
          "Boss",     std::string(10'000, 'b')};
}

// ---- Calls ----

// Any call, with the supervisor's token also in the places where other services look for one.
Reply call(const std::string& address, const std::string& method, const std::string& request) {
  return call_by_name(address, method, request,
                      {{"authorization", "Bearer boss"}, {"token", "boss"}});
}

std::vector<const pb::MethodDescriptor*> methods_of(const pb::FileDescriptor* file) {
  std::vector<const pb::MethodDescriptor*> methods;
  for (int s = 0; s < file->service_count(); ++s)
    for (int m = 0; m < file->service(s)->method_count(); ++m)
      methods.push_back(file->service(s)->method(m));
  return methods;
}

std::string path_of(const pb::MethodDescriptor& method) {
  return "/" + method.service()->full_name() + "/" + method.name();
}

TEST(Separation, TheServerOffersTheCallsThatAreTestedHereAndNoOthers) {
  std::vector<std::string> names;
  for (const auto* file :
       {v1::Hello::descriptor()->file(), v1::RendererHello::descriptor()->file()})
    for (const auto* method : methods_of(file)) names.push_back(path_of(*method));
  EXPECT_THAT(
      names, UnorderedElementsAre("/seam.v1.Simulation/Drive", "/seam.v1.Rendering/Render",
                                  "/seam.v1.Supervisor/GetStatus",
                                  "/seam.v1.Supervisor/GetGroundTruth", "/seam.v1.Supervisor/Pause",
                                  "/seam.v1.Supervisor/Resume", "/seam.v1.Supervisor/Step",
                                  "/seam.v1.Supervisor/Act", "/seam.v1.Supervisor/Stop"));
  // Reflection, asked for its list, names these services and health and itself.
  const LiveRun run(separate_scenario(1));
  const Reply services =
      call(run.address, "/grpc.reflection.v1alpha.ServerReflection/ServerReflectionInfo",
           std::string("\x3a\x00", 2));
  ASSERT_EQ(services.messages.size(), 1u);
  std::set<std::string> found;
  for (size_t at = 0; (at = services.messages[0].find("\x0a", at)) != std::string::npos; ++at) {
    const auto length = static_cast<unsigned char>(services.messages[0][at + 1]);
    const std::string name = services.messages[0].substr(at + 2, length);
    if (name.find('.') != std::string::npos &&
        name.find_first_not_of("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ.1") ==
            std::string::npos)
      found.insert(name);
  }
  EXPECT_THAT(found, UnorderedElementsAre(
                         "grpc.health.v1.Health", "grpc.reflection.v1alpha.ServerReflection",
                         "seam.v1.Rendering", "seam.v1.Simulation", "seam.v1.Supervisor"));
  // What it does not offer is refused, also under names that some services have.
  for (const char* method : {"/seam.v1.Supervisor/GetScenario", "/seam.v1.Simulation/Watch",
                             "/seam.v1.Debug/Dump", "/grpc.channelz.v1.Channelz/GetServers", "/"})
    EXPECT_EQ(call(run.address, method, "").status.error_code(), grpc::StatusCode::UNIMPLEMENTED)
        << method;
}

TEST(Separation, EveryCallOfTheSupervisorRefusesEveryOtherToken) {
  LiveRun run(separate_scenario(2));
  run.control.pause();  // So that a call that got through would show.
  run.start();
  pb::DynamicMessageFactory factory;
  for (const auto* method : methods_of(v1::Hello::descriptor()->file())) {
    if (method->service()->name() != "Supervisor") continue;
    for (const std::string& token : wrong_tokens()) {
      const std::unique_ptr<pb::Message> request(factory.GetPrototype(method->input_type())->New());
      const pb::FieldDescriptor* field = method->input_type()->FindFieldByName("token");
      ASSERT_NE(field, nullptr) << path_of(*method) << " has no token";
      // The right word in a field that nobody defined, and instead of another message's token.
      request->GetReflection()->MutableUnknownFields(request.get())->AddLengthDelimited(99, "boss");
      request->GetReflection()->MutableUnknownFields(request.get())->AddLengthDelimited(3, "boss");
      request->GetReflection()->SetString(request.get(), field, token);
      if (const auto* duration = method->input_type()->FindFieldByName("duration_ns"))
        request->GetReflection()->SetInt64(request.get(), duration, 1'000'000);
      const Reply reply = call(run.address, path_of(*method), request->SerializeAsString());
      EXPECT_EQ(reply.status.error_code(), grpc::StatusCode::UNAUTHENTICATED)
          << path_of(*method) << " " << token;
      EXPECT_EQ(reply.status.error_message(), "token: not the supervisor's token");
      EXPECT_THAT(reply.messages, IsEmpty()) << path_of(*method);
    }
  }
  EXPECT_TRUE(run.control.paused());
  EXPECT_FALSE(run.control.stop_requested());
  EXPECT_EQ(run.control.time().ns(), 0);
}

TEST(Separation, NobodyDrivesARobotWithAnythingButItsToken) {
  LiveRun run(separate_scenario(3));
  run.start();
  const std::vector<std::string> robots = {"r0", "r1", "r2"};
  for (const std::string& robot : robots) {
    std::vector<std::string> tokens = wrong_tokens();
    for (const std::string& other : robots) tokens.push_back("token-" + other);
    tokens.push_back("boss");
    for (const std::string& token : tokens) {
      if (token == "token-" + robot) continue;
      RawClient client(run.address);
      client.hello(robot, token);
      v1::ServerMessage message;
      EXPECT_FALSE(client.read(message))
          << robot << " with " << token << ": " << message.ShortDebugString();
      EXPECT_EQ(client.finish().error_code(), grpc::StatusCode::UNAUTHENTICATED)
          << robot << " with " << token;
    }
  }
  // Names that are nearly a robot's, with its token.
  for (const std::string& name :
       {std::string("R1"), std::string("r1 "), std::string("r1\0", 3), std::string("../r1"),
        std::string(), std::string("r1,r0"), std::string("*")}) {
    RawClient client(run.address);
    client.hello(name, "token-r1");
    v1::ServerMessage message;
    EXPECT_FALSE(client.read(message)) << name;
    EXPECT_EQ(client.finish().error_code(), grpc::StatusCode::NOT_FOUND) << name;
  }
  // A client that was not greeted gets nothing, whatever comes first.
  for (const auto& change : std::vector<std::function<void(v1::ClientMessage&)>>{
           [](v1::ClientMessage&) {},
           [](v1::ClientMessage& m) { m.mutable_decision()->set_sequence(1); }}) {
    RawClient client(run.address);
    v1::ClientMessage first;
    change(first);
    client.write(first);
    v1::ServerMessage message;
    EXPECT_FALSE(client.read(message));
    EXPECT_EQ(client.finish().error_code(), grpc::StatusCode::FAILED_PRECONDITION);
  }
}

TEST(Separation, OnlyTheSupervisorWatches) {
  LiveRun run(separate_scenario(2));
  run.start();
  v1::ClientMessage first;
  first.mutable_hello()->set_robot("r0");
  first.mutable_hello()->set_token("token-r0");
  first.mutable_hello()->mutable_watch()->add_expressions("truth.r1.x_m");
  std::vector<std::string> tokens = wrong_tokens();
  tokens.push_back("boss");  // Right, but no robot of this run is driven by a script.
  for (const std::string& token : tokens) {
    first.mutable_hello()->mutable_watch()->set_token(token);
    RawClient client(run.address);
    client.write(first);
    v1::ServerMessage message;
    EXPECT_FALSE(client.read(message)) << token << ": " << message.ShortDebugString();
    EXPECT_EQ(client.finish().error_code(), token == "boss" ? grpc::StatusCode::FAILED_PRECONDITION
                                                            : grpc::StatusCode::UNAUTHENTICATED)
        << token;
  }
}

TEST(Separation, TheSceneIsNotForRobotsNorForTheSupervisor) {
  LiveRun run(separate_scenario(2));
  for (const std::string& token : {std::string(), std::string("token-r0"), std::string("boss")}) {
    v1::RendererMessage hello;
    hello.mutable_hello()->set_token(token);
    hello.mutable_hello()->set_frames_at_once(1);
    const Reply reply = call(run.address, "/seam.v1.Rendering/Render", hello.SerializeAsString());
    EXPECT_THAT(reply.messages, IsEmpty());  // With a renderer's token: remote_renderer.test.cc.
    EXPECT_FALSE(reply.status.ok());
  }
}

// ---- What an observation holds ----

// All fields that a message of this type can hold, by name: "sensors.joints.tilt_rad".
void list_fields(const pb::Descriptor& type, const std::string& before,
                 std::set<std::string>& out) {
  for (int i = 0; i < type.field_count(); ++i) {
    const pb::FieldDescriptor& field = *type.field(i);
    const std::string name = before + field.name();
    if (field.message_type() != nullptr)
      list_fields(*field.message_type(), name + ".", out);
    else
      out.insert(name);
  }
}

TEST(Separation, WhatARobotIsToldIsAClosedList) {
  std::set<std::string> sent;
  list_fields(*v1::ServerMessage::descriptor(), "", sent);
  std::set<std::string> expected = {
      "welcome.robot", "welcome.robot_number", "welcome.decision_latency_ns",
      "welcome.decision_period_ns", "welcome.image_width_px", "welcome.image_height_px",
      "welcome.team", "welcome.next_sequence", "welcome.joint_names", "observation.sequence",
      "observation.time_ns", "observation.sensors.acceleration_m_s2.x",
      "observation.sensors.acceleration_m_s2.y", "observation.sensors.acceleration_m_s2.z",
      "observation.sensors.angular_velocity_rad_s.x",
      "observation.sensors.angular_velocity_rad_s.y",
      "observation.sensors.angular_velocity_rad_s.z", "observation.sensors.odometry.x_m",
      "observation.sensors.odometry.y_m", "observation.sensors.odometry.heading_rad",
      "observation.sensors.paw_contact", "observation.frames.index", "observation.frames.stamp_ns",
      "observation.frames.width_px", "observation.frames.height_px", "observation.frames.rgb",
      "observation.frames.ycrcb", "observation.frames.row_start_ns",
      "observation.frames.row_end_ns", "observation.frames.fingerprint",
      "observation.frames.colours", "observation.frames.colours_width_px",
      "observation.frames.colours_height_px", "observation.messages.from",
      "observation.messages.sent_ns", "observation.messages.arrived_ns",
      "observation.messages.payload", "observation.game.state", "observation.game.first_half",
      "observation.game.kick_off_team", "observation.game.own_score",
      "observation.game.opponent_score", "observation.game.remaining_ns",
      "observation.game.penalty", "observation.game.penalty_remaining_ns", "refusal.sequence",
      "refusal.field", "refusal.message", "refusal.decision_owed", "goodbye.reason",
      "goodbye.time_ns",
      // With the supervisor's token alone: OnlyTheSupervisorWatches.
      "watched.time_ns", "watched.values", "watched.robots"};
  for (const char* joints : {"joints", "joint_log"})
    for (const char* value :
         {"time_ns", "tilt_rad", "pan_rad", "roll_rad", "legs_rad", "angles_rad"})
      expected.insert(std::string("observation.sensors.") + joints + "." + value);
  EXPECT_EQ(sent, expected) << "a robot gets something new: is it the robot's own?";
}

// What r0 got, all but its frames, in a run in which what another robot decides is changed.
std::vector<std::string> told_to_r0(const std::function<void(v1::Decision&)>& change, int who = 1) {
  struct Ear final : SimulationObserver {
    std::vector<std::string> sent;
    void on_observation(const Observation& seen) override {
      if (seen.robot != 0) return;
      Observation own = seen;
      own.frames.clear();  // r1 may stand in its sight.
      v1::Observation wire;
      observation_to_wire(own, wire);
      sent.push_back(wire.SerializeAsString());
    }
  } ear;
  const Scenario scenario = Scenario::from_text(separate_scenario(3, 1.0), "test.yaml");
  World world(scenario);
  RunControl control;
  HashRenderer renderer(scenario, 1);
  FunctionSource source = function_source([&](int robot, const v1::Observation& seen) {
    v1::Decision decision = busy(robot, seen);
    if (robot == who) change(decision);
    return decision;
  });
  Simulation simulation({scenario, world, source, control, &renderer, {&ear}, {}});
  simulation.run();
  return ear.sent;
}

TEST(Separation, NothingThatAnOpponentDoesOutOfTouchReachesARobotsSenses) {
  const std::vector<std::string> reference = told_to_r0([](v1::Decision&) {});
  ASSERT_GT(reference.size(), 25u);
  const std::vector<std::pair<const char*, std::function<void(v1::Decision&)>>> ways = {
      {"head", [](v1::Decision& d) { d.mutable_head()->set_pan_rad(1.2); }},
      {"legs",
       [](v1::Decision& d) {
         auto& target = *d.add_joints()->add_targets();
         target.set_joint(5), target.set_angle_rad(0.4);
       }},
      {"walk", [](v1::Decision& d) { d.mutable_walk()->set_vy_m_s(-0.1); }},
      {"kick", [](v1::Decision& d) { d.set_kick(v1::KICK_LEG_FORWARD); }},
      {"radio", [](v1::Decision& d) { d.add_messages("to r3 and nobody else"); }},
      {"frames",
       [](v1::Decision& d) { d.add_frame_requests()->set_which(v1::FrameRequest::NONE); }},
      {"notes",
       [](v1::Decision& d) {
         d.add_debug()->set_name("r0");
         d.mutable_debug(0)->set_text("read me");
       }},
  };
  for (const auto& [name, way] : ways) EXPECT_EQ(told_to_r0(way), reference) << name;
  // So the comparison would show it: what a team mate says does reach it.
  EXPECT_NE(told_to_r0([](v1::Decision& d) { d.add_messages("to my team"); }, 2), reference);
}

}  // namespace
}  // namespace seam::scheduler
