// The supervisor's calls over real gRPC: who may make them, and what they do to a run.
#include <gmock/gmock.h>

#include <limits>

#include "scheduler/server/live_testing.h"

namespace seam::scheduler {
namespace {

using ::testing::HasSubstr;
using namespace seam::scheduler::testing;  // NOLINT: helpers of this folder's tests.

class Supervised : public ::testing::Test {
 protected:
  Supervised()
      : run_(scenario_text(SEAM_SOURCE_DIR, 2, 2.0)),
        stub_(v1::Supervisor::NewStub(open_channel(run_.address))) {}

  template <class Request, class Reply>
  grpc::Status call(grpc::Status (v1::Supervisor::Stub::*method)(grpc::ClientContext*,
                                                                 const Request&, Reply*),
                    Request request, Reply& reply, const std::string& token = "boss") {
    grpc::ClientContext context;
    context.set_deadline(std::chrono::system_clock::now() + std::chrono::seconds(20));
    request.set_token(token);
    return (stub_.get()->*method)(&context, request, &reply);
  }
  v1::Status status_;
  LiveRun run_;
  std::unique_ptr<v1::Supervisor::Stub> stub_;
};

TEST_F(Supervised, EveryCallNeedsTheSupervisorsToken) {
  using Stub = v1::Supervisor::Stub;
  run_.start();
  v1::GroundTruth truth;
  for (const char* token : {"", "token-r0", "Boss"}) {
    const auto refused = grpc::StatusCode::UNAUTHENTICATED;
    EXPECT_EQ(call(&Stub::GetGroundTruth, v1::SupervisorRequest(), truth, token).error_code(),
              refused);
    EXPECT_EQ(call(&Stub::GetStatus, v1::SupervisorRequest(), status_, token).error_code(),
              refused);
    EXPECT_EQ(call(&Stub::Pause, v1::SupervisorRequest(), status_, token).error_code(), refused);
    EXPECT_EQ(call(&Stub::Resume, v1::SupervisorRequest(), status_, token).error_code(), refused);
    EXPECT_EQ(call(&Stub::Stop, v1::SupervisorRequest(), status_, token).error_code(), refused);
    EXPECT_EQ(call(&Stub::Step, v1::StepRequest(), status_, token).error_code(), refused);
    EXPECT_EQ(call(&Stub::Act, v1::ActRequest(), status_, token).error_code(), refused);
  }
  EXPECT_EQ(truth.robots_size(), 0);
}

TEST_F(Supervised, PausesStepsActsAndStops) {
  using Stub = v1::Supervisor::Stub;
  run_.control.pause();
  std::thread a = good_client(run_, 0, busy), b = good_client(run_, 1, busy);
  run_.start();
  ASSERT_TRUE(call(&Stub::Pause, v1::SupervisorRequest(), status_).ok());
  EXPECT_TRUE(status_.paused());
  v1::StepRequest step;
  EXPECT_EQ(call(&Stub::Step, step, status_).error_code(), grpc::StatusCode::INVALID_ARGUMENT);
  step.set_duration_ns(100'000'000);
  ASSERT_TRUE(call(&Stub::Step, step, status_).ok());
  const int64_t after_one_ns = status_.time_ns();
  EXPECT_GT(after_one_ns, 80'000'000);
  EXPECT_LE(after_one_ns, 100'000'000);

  v1::ActRequest act;
  v1::PlaceBall& ball = *act.add_actions()->mutable_place_ball();
  ball.mutable_position_m()->set_x(std::numeric_limits<double>::quiet_NaN());
  const grpc::Status refused = call(&Stub::Act, act, status_);
  EXPECT_EQ(refused.error_code(), grpc::StatusCode::INVALID_ARGUMENT);
  EXPECT_THAT(refused.error_message(), HasSubstr("place_ball.position_m"));
  ball.mutable_position_m()->set_x(-1.25);
  ASSERT_TRUE(call(&Stub::Act, act, status_).ok());
  ASSERT_TRUE(call(&Stub::Step, step, status_).ok());
  v1::GroundTruth truth;
  ASSERT_TRUE(call(&Stub::GetGroundTruth, v1::SupervisorRequest(), truth).ok());
  EXPECT_NEAR(truth.ball_position_m().x(), -1.25, 1e-6);
  EXPECT_EQ(truth.robots_size(), 2);

  ASSERT_TRUE(call(&Stub::Resume, v1::SupervisorRequest(), status_).ok());
  ASSERT_TRUE(call(&Stub::Stop, v1::SupervisorRequest(), status_).ok());
  run_.wait();
  a.join();
  b.join();
  EXPECT_EQ(call(&Stub::GetGroundTruth, v1::SupervisorRequest(), truth).error_code(),
            grpc::StatusCode::FAILED_PRECONDITION);
}

TEST_F(Supervised, AnswersWhileTheClockWaitsForAClient) {
  run_.start();  // Nobody connects.
  ASSERT_TRUE(call(&v1::Supervisor::Stub::GetStatus, v1::SupervisorRequest(), status_).ok());
  ASSERT_EQ(status_.robots_size(), 2);
  EXPECT_FALSE(status_.robots(0).connected());
}

TEST_F(Supervised, StatusTellsFramesAndWhoIsConnected) {
  using Stub = v1::Supervisor::Stub;
  run_.control.pause();
  std::thread a = good_client(run_, 0, busy);
  RawClient named(run_.address);
  v1::ServerMessage message;
  named.hello("r1", "token-r1", "watcher 2 \x1b[2J");
  ASSERT_TRUE(named.read_until(v1::ServerMessage::kWelcome, message));
  run_.start();
  ASSERT_TRUE(call(&Stub::GetStatus, v1::SupervisorRequest(), status_).ok());
  EXPECT_EQ(status_.frames(), 0u);
  ASSERT_EQ(status_.robots_size(), 2);
  EXPECT_EQ(status_.robots(1).client(), "watcher 2 \\x1b[2J");
  ASSERT_TRUE(call(&Stub::Resume, v1::SupervisorRequest(), status_).ok());
  for (int turn = 0; turn < 30; ++turn) {
    ASSERT_TRUE(named.read_until(v1::ServerMessage::kObservation, message));
    ASSERT_TRUE(named.decide(busy(1, message.observation())));
  }
  named.cancel();
  named.finish();
  for (int tries = 0; status_.robots(1).connected() && tries < 500; ++tries) {
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
    ASSERT_TRUE(call(&Stub::GetStatus, v1::SupervisorRequest(), status_).ok());
  }
  EXPECT_FALSE(status_.robots(1).connected());
  EXPECT_EQ(status_.robots(1).client(), "");
  ASSERT_TRUE(call(&Stub::Stop, v1::SupervisorRequest(), status_).ok());
  run_.wait();
  a.join();
  ASSERT_TRUE(call(&Stub::GetStatus, v1::SupervisorRequest(), status_).ok());
  EXPECT_GT(status_.frames(), 0u);
  EXPECT_EQ(status_.frames(), run_.simulation->frames());
}

}  // namespace
}  // namespace seam::scheduler
