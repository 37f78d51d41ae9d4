// Frames rendered by other processes: the same bits, whoever makes them and whatever goes wrong.
#include "scheduler/remote_render/remote_renderer.h"

#include <gtest/gtest.h>

#include <thread>

#include "scheduler/remote_render/remote_renderer_testing.h"
#include "sim_core/base/error.h"

namespace seam::scheduler {
namespace {

using namespace seam::scheduler::testing;  // NOLINT: helpers of this folder's tests.

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

  RawClient robot(run.address);
  robot.hello("r0", "picture");
  v1::ServerMessage message;
  EXPECT_FALSE(robot.read(message));
  EXPECT_EQ(robot.finish().error_code(), grpc::StatusCode::UNAUTHENTICATED);

  const auto supervisor = v1::Supervisor::NewStub(open_channel(run.address));
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
  LiveRun run(scenario_text(SEAM_SOURCE_DIR, 1, 0.1));
  const auto stub = v1::Rendering::NewStub(open_channel(run.address));
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
  for (const SimTime time : job.schedule.instants)
    job.instants.push_back({time, {}, setup.scene, {}});
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
