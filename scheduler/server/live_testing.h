// Live runs in tests: a server with its loop on a thread, and clients that speak the wire without
// the SDK, so that they can also speak it badly.
#pragma once

#include <grpcpp/generic/generic_stub.h>
#include <grpcpp/grpcpp.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <atomic>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "scheduler/clients/client_hub.h"
#include "scheduler/loop/simulation.h"
#include "scheduler/loop/testing.h"
#include "scheduler/server/server.h"
#include "scheduler/wire/wire.h"
#include "seam/v1/simulation.grpc.pb.h"

namespace seam::scheduler::testing {

inline std::shared_ptr<grpc::Channel> open_channel(const std::string& address) {
  grpc::ChannelArguments arguments;
  arguments.SetInt(GRPC_ARG_USE_LOCAL_SUBCHANNEL_POOL, 1);
  return grpc::CreateCustomChannel(address, grpc::InsecureChannelCredentials(), arguments);
}

// What a call by its name brought.
struct Reply {
  grpc::Status status;
  std::vector<std::string> messages;
};

// Sends one message's bytes to a method ("/package.Service/Method") and reads until the stream
// ends.
inline Reply call_by_name(const std::string& address, const std::string& method,
                          const std::string& request,
                          const std::map<std::string, std::string>& metadata = {}) {
  grpc::GenericStub stub(open_channel(address));
  grpc::ClientContext context;
  context.set_deadline(std::chrono::system_clock::now() + std::chrono::seconds(20));
  for (const auto& [name, value] : metadata) context.AddMetadata(name, value);
  grpc::CompletionQueue queue;
  const auto stream = stub.PrepareCall(&context, method, &queue);
  const auto wait = [&queue] {
    void* tag = nullptr;
    bool ok = false;
    return queue.Next(&tag, &ok) && ok;
  };
  stream->StartCall(nullptr);
  wait();
  const grpc::Slice slice(request);
  stream->WriteLast(grpc::ByteBuffer(&slice, 1), {}, nullptr);
  wait();
  Reply reply;
  while (true) {
    grpc::ByteBuffer bytes;
    stream->Read(&bytes, nullptr);
    if (!wait()) break;
    grpc::Slice flat;
    if (bytes.Valid()) bytes.DumpToSingleSlice(&flat);
    reply.messages.emplace_back(reinterpret_cast<const char*>(flat.begin()), flat.size());
  }
  stream->Finish(&reply.status, nullptr);
  wait();
  return reply;
}

// One stream, read and written step by step.
class RawClient {
 public:
  explicit RawClient(const std::string& address)
      : stub_(v1::Simulation::NewStub(open_channel(address))), stream_(stub_->Drive(&context_)) {}
  ~RawClient() {
    if (!ended_) context_.TryCancel();
    finish();
  }

  bool hello(const std::string& robot, const std::string& token, const std::string& client = {}) {
    v1::ClientMessage message;
    message.mutable_hello()->set_client(client);
    message.mutable_hello()->set_robot(robot);
    message.mutable_hello()->set_token(token);
    return stream_->Write(message);
  }
  bool decide(const v1::Decision& decision) {
    v1::ClientMessage message;
    *message.mutable_decision() = decision;
    return stream_->Write(message);
  }
  bool decide(uint64_t sequence) {
    v1::Decision decision;
    decision.set_sequence(sequence);
    return decide(decision);
  }
  bool write(const v1::ClientMessage& message) { return stream_->Write(message); }
  bool read(v1::ServerMessage& message) { return stream_->Read(&message); }
  // Reads on to a message of this kind; false when the stream ends before.
  bool read_until(v1::ServerMessage::KindCase kind, v1::ServerMessage& message) {
    while (read(message))
      if (message.kind_case() == kind) return true;
    return false;
  }
  void cancel() { context_.TryCancel(); }
  grpc::Status finish() {
    if (!ended_) {
      ended_ = true;
      status_ = stream_->Finish();
    }
    return status_;
  }

 private:
  grpc::ClientContext context_;
  std::unique_ptr<v1::Simulation::Stub> stub_;
  std::unique_ptr<grpc::ClientReaderWriter<v1::ClientMessage, v1::ServerMessage>> stream_;
  bool ended_ = false;
  grpc::Status status_;
};

// What a robot decides, from what the wire brings it: the same function drives live clients and
// reference runs in this process.
using WireBehaviour = std::function<v1::Decision(int robot, const v1::Observation&)>;

inline v1::Decision busy(int robot, const v1::Observation& seen) {
  v1::Decision decision;
  decision.set_sequence(seen.sequence());
  decision.mutable_head()->set_pan_rad(0.4 * static_cast<double>((seen.sequence() + robot) % 3) -
                                       0.4);
  decision.mutable_head()->set_max_speed_rad_s(3);
  if (seen.sequence() % 4 == 1) {
    decision.mutable_walk()->set_vx_m_s(0.1);
    decision.mutable_walk()->set_omega_rad_s(0.2 * seen.sensors().joints().pan_rad());
  }
  if (seen.sequence() == 1 && !seen.sensors().joints().legs_rad().empty())
    decision.add_frame_requests()->set_which(v1::FrameRequest::ALL);
  return decision;
}

inline FunctionSource function_source(WireBehaviour behaviour) {
  return FunctionSource([behaviour](const Observation& seen) {
    v1::Observation wire;
    observation_to_wire(seen, wire);
    return std::get<Decision>(decision_from_wire(behaviour(seen.robot, wire), 1024));
  });
}

// A scenario behind a server on a Unix socket, its loop on a thread of its own.
class LiveRun {
 public:
  LiveRun(const std::string& yaml, std::vector<SimulationObserver*> observers = {},
          bool frames = true)
      : scenario(Scenario::from_text(yaml, "test.yaml")),
        world(scenario),
        renderer(scenario, 2),
        hub(hub_robots(scenario), control),
        observers_(std::move(observers)),
        frames_(frames) {
    std::string pattern = (std::filesystem::temp_directory_path() / "seam-test-XXXXXX").string();
    EXPECT_NE(mkdtemp(pattern.data()), nullptr);
    folder_ = pattern;
    address = "unix:" + folder_.string() + "/s";
    lines = (folder_ / "l").string();
    server_.emplace(
        ServerOptions{.addresses = {address}, .supervisor_token = "boss", .lines = lines}, scenario,
        world, hub, control);
  }
  ~LiveRun() {
    control.stop();
    wait();
    server_.reset();
    std::filesystem::remove_all(folder_);
  }

  static std::vector<HubRobot> hub_robots(const Scenario& scenario) {
    std::vector<HubRobot> robots;
    for (const RobotSpec& robot : scenario.robots)
      robots.push_back(
          {robot.id, "token-" + robot.id, robot.behaviour.silence, robot.behaviour.wall_limit.s()});
    return robots;
  }

  // One more observer, before the start.
  void observe(SimulationObserver& observer) { observers_.push_back(&observer); }
  void start(RunHeader header = {}) {
    if (header.robots.empty())
      for (const RobotSpec& robot : scenario.robots) header.robots.push_back(robot.id);
    simulation.emplace(SimulationParts{scenario, world, hub, control, frames_ ? &renderer : nullptr,
                                       observers_, header});
    loop_ = std::thread([this] { end = simulation->run(); });
  }
  void wait() {
    if (loop_.joinable()) loop_.join();
  }
  uint64_t fingerprint() {
    wait();
    return simulation->fingerprint();
  }

  Scenario scenario;
  World world;
  HashRenderer renderer;
  RunControl control;
  ClientHub hub;
  std::string address;
  std::string lines;  // Path of the socket for direct lines.
  std::optional<Simulation> simulation;
  EndReason end = EndReason::finished;

 private:
  std::vector<SimulationObserver*> observers_;
  bool frames_;
  std::filesystem::path folder_;
  std::optional<Server> server_;
  std::thread loop_;
};

// A well-behaved client on a thread: answers until the goodbye.
inline std::thread good_client(const LiveRun& run, int robot, WireBehaviour behaviour) {
  const std::string id = run.scenario.robots[static_cast<size_t>(robot)].id;
  return std::thread([address = run.address, id, robot, behaviour] {
    RawClient client(address);
    client.hello(id, "token-" + id);
    v1::ServerMessage message;
    while (client.read(message) && !message.has_goodbye())
      if (message.has_observation()) client.decide(behaviour(robot, message.observation()));
  });
}

inline uint64_t reference_fingerprint(const std::string& yaml, WireBehaviour behaviour) {
  const Scenario scenario = Scenario::from_text(yaml, "test.yaml");
  World world(scenario);
  RunControl control;
  HashRenderer renderer(scenario, 1);
  FunctionSource source = function_source(std::move(behaviour));
  Simulation simulation({scenario, world, source, control, &renderer, {}, {}});
  simulation.run();
  return simulation.fingerprint();
}

}  // namespace seam::scheduler::testing
