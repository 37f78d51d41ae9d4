// Frames rendered by other processes: the same bits, whoever makes them and whatever goes wrong.
#include "scheduler/remote_render/remote_renderer.h"

#include <gtest/gtest.h>

#include <atomic>
#include <thread>

#include "scheduler/remote_render/render_client.h"
#include "scheduler/server/live_testing.h"
#include "seam/v1/render.grpc.pb.h"
#include "sim_core/base/error.h"

namespace seam::scheduler {
namespace {

constexpr int kSize_px = 8;

void develop_test_frame(Frame& frame) {
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
    for (const SceneInstant& instant : job.instants) add(instant, common);
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

std::string two_robots() {
  std::string yaml = testing::scenario_text(SEAM_SOURCE_DIR, 2, 0.4);
  return yaml.replace(yaml.find("seed: 7"), 7, "seed: 7\nrender_token: picture");
}

// A run with renderers behind a server, its decisions made in this process.
class RemoteRun {
 public:
  explicit RemoteRun(RemoteRendererOptions options = {})
      : scenario(Scenario::from_text(two_robots(), "test.yaml")),
        world(scenario),
        hub(testing::LiveRun::hub_robots(scenario), control),
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
    FunctionSource source = testing::function_source(testing::busy);
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

TEST(RemoteRenderer, OneAndTwoRenderersGiveTheFingerprintOfTheRunInTheServer) {
  const uint64_t reference = RemoteRun::reference();
  for (const int count : {1, 2}) {
    PixelRenderer renderers[2];
    RemoteRun run({.check_every = 7});
    for (int i = 0; i < count; ++i) run.add_client(renderers[i]);
    EXPECT_EQ(run.run(), reference) << count;
    EXPECT_GT(run.frames, 10u);
    EXPECT_EQ(run.remote->rendered_remotely(), run.frames);
    for (int i = 0; i < count; ++i) EXPECT_GT(renderers[i].frames, 0) << i;
    EXPECT_GE(run.local.frames, count);  // Checked at least once each.
    EXPECT_LT(static_cast<uint64_t>(run.local.frames), run.frames);
    EXPECT_EQ(run.faults(), "");
  }
}

TEST(RemoteRenderer, ARendererOfOneRobotMakesItsFramesAloneAndTheServerTheOthers) {
  PixelRenderer renderer;
  RemoteRun run({.check_every = 0});
  run.add_client(renderer, {"r1"});
  EXPECT_EQ(run.run(), RemoteRun::reference());
  EXPECT_EQ(run.remote->rendered_remotely(), static_cast<uint64_t>(renderer.frames));
  EXPECT_EQ(renderer.frames + run.local.frames, static_cast<int>(run.frames));
  EXPECT_GT(renderer.frames, 0);
  EXPECT_GT(run.local.frames, 0);
  EXPECT_NE(run.faults().find("of r0 on the server renders itself"), std::string::npos)
      << run.faults();
}

TEST(RemoteRenderer, OtherBitsEndTheRunAndNameThePixel) {
  PixelRenderer wrong(1, 1);
  RemoteRun run;
  run.add_client(wrong);
  try {
    run.run();
    FAIL() << "wrong pixels were taken";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("pixel (7, 7)"), std::string::npos) << error.what();
    EXPECT_NE(std::string(error.what()).find("tester"), std::string::npos) << error.what();
  }
}

TEST(RemoteRenderer, PolicyAbortEndsTheRunWhereNoRendererIs) {
  RemoteRun run({.policy = RendererPolicy::abort});
  try {
    run.run();
    FAIL() << "a frame came from nowhere";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("no renderer for frame"), std::string::npos)
        << error.what();
  }
}

// ---- Renderers that fail, each in its own way ----

// A stream that is read and written step by step.
class RawRenderer {
 public:
  explicit RawRenderer(const RemoteRun& run)
      : stub_(v1::Rendering::NewStub(testing::open_channel(run.address))),
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

struct Failing {
  const char* name;
  std::function<bool(const v1::RenderJob&, v1::RendererMessage&)> answer;
  const char* expected;  // In the status and in the faults.
};

TEST(RemoteRenderer, AFailingRendererIsDroppedWithItsReasonAndChangesNoBit) {
  const auto rows = [](const v1::RenderJob& job, v1::RendererMessage& message, int bytes,
                       int first = 0) {
    message.mutable_rows()->set_number(job.number());
    message.mutable_rows()->set_first_row(static_cast<uint32_t>(first));
    message.mutable_rows()->set_rgb(std::string(static_cast<size_t>(bytes), 'x'));
    return true;
  };
  constexpr int kFrameBytes = 3 * kSize_px * kSize_px;
  const Failing failures[] = {
      {"too many bytes", [&](auto& job, auto& m) { return rows(job, m, kFrameBytes + 24); },
       "rgb: found 216"},
      {"half a row", [&](auto& job, auto& m) { return rows(job, m, 12); }, "rgb: found 12"},
      {"a row left out", [&](auto& job, auto& m) { return rows(job, m, 24, 1); },
       "first_row: found 1"},
      {"not the pixels' fingerprint", [&](auto& job, auto& m) { return rows(job, m, kFrameBytes); },
       "fingerprint"},
      {"a frame that nobody asked for",
       [&](auto&, auto& m) {
         v1::RenderJob other;
         other.set_number(1'000'000);
         return rows(other, m, 24);
       },
       "number: no frame 1000000"},
      {"an empty message", [](auto&, auto&) { return true; }, "kind"},
      {"a second hello",
       [](auto&, auto& m) {
         m.mutable_hello();
         return true;
       },
       "kind"},
      {"its own failure",
       [](auto& job, auto& m) {
         m.mutable_failure()->set_number(job.number());
         m.mutable_failure()->set_message("out of paint");
         return true;
       },
       "out of paint"},
      {"silence", [](auto&, auto&) { return false; }, "took longer than 0.2 s"},
  };
  const uint64_t reference = RemoteRun::reference();
  for (const Failing& failure : failures) {
    SCOPED_TRACE(failure.name);
    RemoteRun run({.limit_s = 0.2});
    RawRenderer renderer(run);
    ASSERT_TRUE(renderer.hello(RawRenderer::good_hello()).ok());
    ASSERT_TRUE(run.remote->wait_for(1, 10, [] { return false; }));
    grpc::Status status;
    std::thread thread([&] { status = renderer.serve(failure.answer); });
    EXPECT_EQ(run.run(), reference);
    thread.join();
    EXPECT_FALSE(status.ok());
    EXPECT_NE(status.error_message().find(failure.expected), std::string::npos)
        << status.error_message();
    EXPECT_NE(run.faults().find(failure.expected), std::string::npos) << run.faults();
    EXPECT_NE(run.faults().find("the server renders itself"), std::string::npos) << run.faults();
    EXPECT_EQ(run.remote->rendered_remotely(), 0u);
  }
}

TEST(RemoteRenderer, AnotherTakesTheFramesOfARendererThatBreaksOff) {
  const uint64_t reference = RemoteRun::reference();
  PixelRenderer good;
  RemoteRun run({.check_every = 0});
  RawRenderer renderer(run);
  ASSERT_TRUE(renderer.hello(RawRenderer::good_hello()).ok());
  ASSERT_TRUE(run.remote->wait_for(1, 10, [] { return false; }));
  run.add_client(good);
  std::thread thread([&] {
    renderer.serve([&](auto&, auto&) {
      renderer.cancel();
      return false;
    });
  });
  EXPECT_EQ(run.run(), reference);
  thread.join();
  EXPECT_EQ(run.remote->rendered_remotely(), run.frames);
  EXPECT_EQ(run.local.frames, 0);
  EXPECT_NE(run.faults().find("renderer 'raw' is lost"), std::string::npos) << run.faults();
}

// ---- Who may see the scene ----

TEST(RemoteRenderer, TheRenderTokenAloneOpensTheSceneAndOpensNothingElse) {
  RemoteRun run;
  for (const char* token : {"", "guess", "token-r0", "boss"}) {
    v1::RendererHello hello = RawRenderer::good_hello();
    hello.set_token(token);
    const grpc::Status status = RawRenderer(run).hello(hello);
    EXPECT_EQ(status.error_code(), grpc::StatusCode::UNAUTHENTICATED) << token;
    EXPECT_EQ(status.error_message(), "token: not the render token");
  }
  EXPECT_EQ(run.remote->renderers(), 0u);

  testing::RawClient robot(run.address);
  robot.hello("r0", "picture");
  v1::ServerMessage message;
  EXPECT_FALSE(robot.read(message));
  EXPECT_EQ(robot.finish().error_code(), grpc::StatusCode::UNAUTHENTICATED);

  const auto supervisor = v1::Supervisor::NewStub(testing::open_channel(run.address));
  grpc::ClientContext context;
  v1::SupervisorRequest request;
  request.set_token("picture");
  v1::GroundTruth truth;
  EXPECT_EQ(supervisor->GetGroundTruth(&context, request, &truth).error_code(),
            grpc::StatusCode::UNAUTHENTICATED);
}

TEST(RemoteRenderer, AHelloThatDoesNotFitIsRefusedWithTheField) {
  RemoteRun run;
  const auto refusal = [&](auto change) {
    v1::RendererHello hello = RawRenderer::good_hello();
    change(hello);
    return RawRenderer(run).hello(hello);
  };
  const grpc::Status version = refusal([](auto& hello) { hello.set_version("2"); });
  EXPECT_EQ(version.error_code(), grpc::StatusCode::FAILED_PRECONDITION);
  EXPECT_EQ(version.error_message(), "version: found 2, expected the server's, 1");
  EXPECT_EQ(refusal([](auto& hello) { hello.add_robots("r9"); }).error_message(),
            "robots: no robot 'r9' here");
  EXPECT_EQ(refusal([](auto& hello) { hello.set_frames_at_once(0); }).error_message(),
            "frames_at_once: found 0, expected 1 to 64");
  EXPECT_EQ(refusal([](auto& hello) { hello.set_name(std::string(300, 'n')); }).error_message(),
            "name: found 300 bytes, expected at most 200");
}

TEST(RemoteRenderer, AServerThatRendersItselfSaysSo) {
  testing::LiveRun run(testing::scenario_text(SEAM_SOURCE_DIR, 1, 0.1));
  const auto stub = v1::Rendering::NewStub(testing::open_channel(run.address));
  grpc::ClientContext context;
  const auto stream = stub->Render(&context);
  v1::RendererMessage message;
  *message.mutable_hello() = RawRenderer::good_hello();
  stream->Write(message);
  v1::RenderOrder order;
  EXPECT_FALSE(stream->Read(&order));
  const grpc::Status status = stream->Finish();
  EXPECT_EQ(status.error_code(), grpc::StatusCode::FAILED_PRECONDITION);
  EXPECT_NE(status.error_message().find("--renderers"), std::string::npos);
}

// ---- The wire ----

TEST(RenderWire, WhatIsNoWholeJobIsRefusedWithTheField) {
  RemoteRun run;
  const RenderSetup& setup = run.remote->setup();
  FrameJob job{.schedule = run.local.schedule(0, 0, SimTime())};
  for (const SimTime time : job.schedule.instants) job.instants.push_back({time, {}, setup.scene});
  v1::RenderJob good;
  job_to_wire(setup, 1, 0, job, good);
  EXPECT_EQ(good.instants(0).replaced_size() + good.instants(0).moved_size(),
            0);  // The scene travels once.
  EXPECT_NO_THROW(job_from_wire(setup, good));
  const auto error = [&](auto change) -> std::string {
    v1::RenderJob bad = good;
    change(bad);
    try {
      job_from_wire(setup, bad);
    } catch (const InputError& found) {
      return std::string(found.what()).substr(0, std::string(found.what()).find(':'));
    }
    return "";
  };
  EXPECT_EQ(error([](auto& j) { j.set_robot(2); }), "robot");
  EXPECT_EQ(error([](auto& j) { j.mutable_row_end_ns()->RemoveLast(); }), "row_end_ns");
  EXPECT_EQ(error([](auto& j) { j.set_first_instant(3, 8); }), "first_instant");
  EXPECT_EQ(error([](auto& j) { j.set_weight_count(0, 1u << 31); }), "first_instant");
  EXPECT_EQ(error([](auto& j) { j.mutable_weights()->RemoveLast(); }), "weights");
  EXPECT_EQ(error([](auto& j) { j.mutable_noise()->RemoveLast(); }), "noise");
  EXPECT_EQ(error([](auto& j) { j.mutable_instants(0)->mutable_camera()->RemoveLast(); }),
            "camera");
  EXPECT_EQ(error([](auto& j) { j.mutable_instants(0)->set_primitives(1u << 30); }), "primitives");
  EXPECT_EQ(error([](auto& j) { j.mutable_instants(0)->add_moved(0); }), "poses");
  EXPECT_EQ(error([](auto& j) { j.mutable_instants(0)->add_replaced(0); }), "with");
  EXPECT_EQ(error([](auto& j) {
              auto& instant = *j.mutable_instants(0);
              instant.add_moved(1u << 20);
              for (int i = 0; i < 12; ++i) instant.add_poses(0);
            }),
            "moved");
}

}  // namespace
}  // namespace seam::scheduler
