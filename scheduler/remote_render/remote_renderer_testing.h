// Runs in tests whose frames other processes render: a renderer of few pixels, a server with
// clients that render for it, and a client that speaks the wire itself, so that it can fail.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <bit>
#include <filesystem>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "scheduler/remote_render/remote_renderer.h"
#include "scheduler/remote_render/render_client.h"
#include "scheduler/server/live_testing.h"
#include "seam/v1/render.grpc.pb.h"
#include "sim_core/base/error.h"
#include "sim_core/base/hash.h"

namespace seam::scheduler::testing {

inline constexpr int kSize_px = 8;

inline void develop_test_frame(Frame& frame) {
  Hasher hasher;
  hasher.add(frame.stamp.ns());
  hasher.add_bytes(frame.rgb);
  frame.fingerprint = hasher.digest();
}

// Its pixels change whenever anything that a renderer may look at changes.
class PixelRenderer final : public FrameRenderer {
 public:
  explicit PixelRenderer(int workers = 2, uint8_t error = 0) : workers_(workers), error_(error) {}

  int workers() const override { return workers_; }
  Pose mount(int) const override { return rotation(link_to_camera_axes()); }
  RowSchedule schedule(int, uint64_t, SimTime stamp) override {
    RowSchedule schedule;
    for (int row = 0; row < kSize_px; ++row) {
      const SimTime start = stamp + SimDuration::from_ns(row * 1'000'000);
      schedule.rows.push_back({start, start + SimDuration::from_ns(2'000'000)});
      schedule.instants.push_back(start);
      schedule.first_instant.push_back(std::max(0, row - 1));
      schedule.weights.push_back(row == 0 ? std::vector<double>{1} : std::vector<double>{0.3, 0.7});
    }
    return schedule;
  }
  Frame render(int, const FrameJob& job, int) override {
    ++frames;
    Hasher common;
    for (const RandomStream& noise : {job.camera_noise, job.frame_noise})
      common.add(noise.seed), common.add(noise.stream);
    for (const SceneInstant& instant : with_all_primitives(job).instants) add(instant, common);
    add_doubles(&job.background[0], 3, common);
    Frame frame{.robot = job.robot,
                .frame_index = job.frame_index,
                .stamp = job.stamp,
                .width_px = kSize_px,
                .height_px = kSize_px,
                .rows = job.schedule.rows};
    for (int i = 0; i < 3 * kSize_px * kSize_px; ++i) {
      Hasher hasher;
      hasher.add(common.digest() + static_cast<uint64_t>(i));
      const size_t row = static_cast<size_t>(i) / (3 * kSize_px);
      hasher.add(static_cast<int64_t>(job.schedule.first_instant[row]));
      add_doubles(job.schedule.weights[row].data(), job.schedule.weights[row].size(), hasher);
      frame.rgb.push_back(static_cast<uint8_t>(hasher.digest()));
    }
    frame.rgb.back() = static_cast<uint8_t>(frame.rgb.back() + error_);
    develop_test_frame(frame);
    return frame;
  }

  std::atomic<int> frames = 0;

 private:
  static void add_doubles(const double* values, size_t count, Hasher& hasher) {
    for (size_t i = 0; i < count; ++i) hasher.add(std::bit_cast<uint64_t>(values[i]));
  }
  static void add(const SceneInstant& instant, Hasher& hasher) {
    hasher.add(instant.time.ns());
    add_doubles(&instant.X_WC.R[0][0], 12, hasher);
    for (const Primitive& primitive : instant.primitives) {
      hasher.add(static_cast<int64_t>(primitive.shape) * 1000 +
                 static_cast<int64_t>(primitive.label));
      hasher.add(static_cast<int64_t>(primitive.object_id));
      add_doubles(&primitive.X_WO.R[0][0], 12, hasher);
      add_doubles(&primitive.size[0], 3, hasher);
      add_doubles(&primitive.rgb[0], 3, hasher);
    }
  }

  int workers_;
  uint8_t error_;
};

inline std::string two_robots() {
  std::string yaml = scenario_text(SEAM_SOURCE_DIR, 2, 0.4);
  return yaml.replace(yaml.find("seed: 7"), 7, "seed: 7\nrender_token: picture");
}

// A run with renderers behind a server, its decisions made in this process.
class RemoteRun {
 public:
  explicit RemoteRun(RemoteRendererOptions options = {})
      : scenario(Scenario::from_text(two_robots(), "test.yaml")),
        world(scenario),
        hub(LiveRun::hub_robots(scenario), control),
        options_(std::move(options)) {
    if (options_.token.empty()) options_.token = "picture";
    RenderSetup setup{
        .version = "1", .background = world.background(), .lighting = world.lighting()};
    world.primitives_at(SimTime(), setup.scene);
    for (const RobotSpec& robot : scenario.robots)
      setup.cameras.push_back({robot.id, kSize_px, kSize_px, "", ""});
    remote.emplace(
        local, setup, options_, [](int, Frame& frame) { develop_test_frame(frame); },
        [this](int, const std::string& what) {
          const std::lock_guard lock(mutex_);
          faults_ += what + "\n";
        });
    std::string pattern = (std::filesystem::temp_directory_path() / "seam-test-XXXXXX").string();
    EXPECT_NE(mkdtemp(pattern.data()), nullptr);
    folder_ = pattern;
    address = "unix:" + pattern + "/s";
    server_.emplace(ServerOptions{{address}, {}, "boss", &*remote}, scenario, world, hub, control);
  }
  ~RemoteRun() {
    remote->finish("the run is over");
    control.close();
    for (std::thread& thread : clients_) thread.join();
    server_.reset();
    std::filesystem::remove_all(folder_);
  }

  RenderClientOptions client_options() const {
    return {
        .address = address, .token = "picture", .version = "1", .name = "tester", .give_up_s = 5};
  }
  void add_client(FrameRenderer& renderer, std::vector<std::string> robots = {}) {
    RenderClientOptions options = client_options();
    options.robots = std::move(robots);
    options.threads = renderer.workers();
    const size_t before = remote->renderers();
    clients_.emplace_back([this, options, &renderer] {
      try {
        render_for_server(options,
                          [&](const RenderSetup&) { return std::make_unique<Borrowed>(renderer); });
      } catch (const InputError& error) {
        const std::lock_guard lock(mutex_);
        faults_ += std::string("client: ") + error.what() + "\n";
      }
    });
    EXPECT_TRUE(remote->wait_for(before + 1, 10, [] { return false; }));
  }
  uint64_t run(FrameRenderer* renderer = nullptr) {
    FunctionSource source = function_source(busy);
    Simulation simulation(
        {scenario, world, source, control, renderer ? renderer : &*remote, {}, {}});
    const struct Finisher {
      RemoteRenderer& remote;
      ~Finisher() { remote.finish("the run is over"); }
    } finisher{*remote};
    simulation.run();
    frames = simulation.frames();
    return simulation.fingerprint();
  }
  std::string faults() {
    const std::lock_guard lock(mutex_);
    return faults_;
  }
  static uint64_t reference() {
    RemoteRun run;
    return run.run(&run.local);
  }

  Scenario scenario;
  World world;
  RunControl control;
  ClientHub hub;
  PixelRenderer local;
  std::optional<RemoteRenderer> remote;
  std::string address;
  uint64_t frames = 0;

 private:
  // A client owns its renderer; tests look at it from outside.
  class Borrowed final : public FrameRenderer {
   public:
    explicit Borrowed(FrameRenderer& renderer) : renderer_(renderer) {}
    int workers() const override { return renderer_.workers(); }
    RowSchedule schedule(int robot, uint64_t index, SimTime stamp) override {
      return renderer_.schedule(robot, index, stamp);
    }
    Pose mount(int robot) const override { return renderer_.mount(robot); }
    Frame render(int robot, const FrameJob& job, int worker) override {
      return renderer_.render(robot, job, worker);
    }

   private:
    FrameRenderer& renderer_;
  };

  RemoteRendererOptions options_;
  std::mutex mutex_;
  std::string faults_;
  std::filesystem::path folder_;
  std::optional<Server> server_;
  std::vector<std::thread> clients_;
};

// A stream that is read and written step by step.
class RawRenderer {
 public:
  explicit RawRenderer(const RemoteRun& run)
      : stub_(v1::Rendering::NewStub(open_channel(run.address))),
        stream_(stub_->Render(&context_)) {}
  grpc::Status hello(const v1::RendererHello& hello) {
    v1::RendererMessage message;
    *message.mutable_hello() = hello;
    stream_->Write(message);
    v1::RenderOrder order;
    if (stream_->Read(&order) && order.has_setup()) return grpc::Status::OK;
    return stream_->Finish();
  }
  static v1::RendererHello good_hello() {
    v1::RendererHello hello;
    hello.set_token("picture");
    hello.set_version("1");
    hello.set_name("raw");
    hello.set_frames_at_once(2);
    return hello;
  }
  // Answers each job with what `answer` makes of it, until the server ends the stream.
  grpc::Status serve(
      const std::function<bool(const v1::RenderJob&, v1::RendererMessage&)>& answer) {
    v1::RenderOrder order;
    while (stream_->Read(&order)) {
      v1::RendererMessage message;
      if (order.has_job() && answer(order.job(), message)) stream_->Write(message);
    }
    return stream_->Finish();
  }
  void cancel() { context_.TryCancel(); }

 private:
  grpc::ClientContext context_;
  std::unique_ptr<v1::Rendering::Stub> stub_;
  std::unique_ptr<grpc::ClientReaderWriter<v1::RendererMessage, v1::RenderOrder>> stream_;
};

}  // namespace seam::scheduler::testing
