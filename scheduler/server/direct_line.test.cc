// Direct lines: the same run to the bit as by gRPC, the same refusals, and clients that speak them
// badly.
#include <gmock/gmock.h>
#include <sys/socket.h>
#include <sys/un.h>

#include <chrono>
#include <thread>

#include "proto/line.h"
#include "proto/line_stream.h"
#include "scheduler/server/live_testing.h"

namespace seam::scheduler {
namespace {

using ::testing::HasSubstr;
using namespace seam::scheduler::testing;  // NOLINT: helpers of this folder's tests.

std::string scenario_of(int robots, double duration_s = 0.4) {
  return scenario_text(SEAM_SOURCE_DIR, robots, duration_s);
}

v1::ClientMessage hello_of(const std::string& robot, const std::string& token) {
  v1::ClientMessage message;
  message.mutable_hello()->set_robot(robot);
  message.mutable_hello()->set_token(token);
  return message;
}

std::thread line_client(const LiveRun& run, int robot, WireBehaviour behaviour) {
  const std::string id = run.scenario.robots[static_cast<size_t>(robot)].id;
  return std::thread([path = run.lines, id, robot, behaviour] {
    LineStream line(path);
    line.Write(hello_of(id, "token-" + id));
    v1::ServerMessage message;
    while (line.Read(&message) && !message.has_goodbye()) {
      if (!message.has_observation()) continue;
      v1::ClientMessage answer;
      *answer.mutable_decision() = behaviour(robot, message.observation());
      line.Write(answer);
    }
  });
}

// How the server ends a line on which this was written.
grpc::Status end_after(const LiveRun& run, const v1::ClientMessage& first) {
  LineStream line(run.lines);
  line.Write(first);
  v1::ServerMessage message;
  while (line.Read(&message)) {
  }
  return line.Finish();
}

// A line on which any bytes can be written.
class RawLine {
 public:
  explicit RawLine(const std::string& path) : socket_(::socket(AF_UNIX, SOCK_STREAM, 0)) {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    path.copy(address.sun_path, path.size());
    EXPECT_EQ(::connect(socket_, reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
  }
  ~RawLine() { ::close(socket_); }
  void write(const std::string& bytes) const {
    EXPECT_EQ(::send(socket_, bytes.data(), bytes.size(), MSG_NOSIGNAL),
              static_cast<ssize_t>(bytes.size()));
  }
  // The end that the server makes; its text.
  std::string end() {
    try {
      while (true) {
        while (const auto frame = frames_.next())
          if (frame->is_end) return std::string(frame->bytes);
        if (frames_.receive(socket_, 0) != LineFrames::Received::bytes) return "closed";
      }
    } catch (const std::length_error& error) {
      return error.what();
    }
  }

 private:
  int socket_;
  LineFrames frames_{1 << 20};
};

TEST(DirectLine, ARunIsThatOfGrpcToTheBit) {
  const std::string yaml = scenario_of(3);
  LiveRun run(yaml);
  std::vector<std::thread> clients;
  clients.push_back(line_client(run, 0, busy));
  clients.push_back(good_client(run, 1, busy));
  clients.push_back(line_client(run, 2, busy));
  run.start();
  EXPECT_EQ(run.fingerprint(), reference_fingerprint(yaml, busy));
  for (std::thread& client : clients) client.join();
}

TEST(DirectLine, ARefusalIsThatOfGrpc) {
  LiveRun run(scenario_of(1));
  grpc::Status status = end_after(run, hello_of("r0", "guess"));
  EXPECT_EQ(status.error_code(), grpc::StatusCode::UNAUTHENTICATED);
  EXPECT_THAT(status.error_message(), HasSubstr("not the token of robot 'r0'"));
  status = end_after(run, hello_of("nobody", ""));
  EXPECT_EQ(status.error_code(), grpc::StatusCode::NOT_FOUND);
  status = end_after(run, v1::ClientMessage());
  EXPECT_EQ(status.error_code(), grpc::StatusCode::FAILED_PRECONDITION);
}

TEST(DirectLine, BytesThatAreNoMessagesEndALine) {
  LiveRun run(scenario_of(1));
  RawLine garbage(run.lines);
  garbage.write({3, 0, 0, 0, '\xff', '\xff', '\xff'});
  EXPECT_THAT(garbage.end(), HasSubstr("no message"));
  RawLine long_one(run.lines);
  long_one.write({0, 0, 16, 0, 'x'});  // A megabyte is announced.
  EXPECT_THAT(long_one.end(), HasSubstr("found a message of 1048576 bytes, expected at most"));
  RawLine end(run.lines);
  end.write(line_end(0, "me first"));
  EXPECT_THAT(end.end(), HasSubstr("no message"));
}

TEST(DirectLine, ADecisionThatIsTooLongIsRefusedAndTheRunGoesOn) {
  LiveRun run(scenario_of(1));
  std::vector<std::string> refusals;
  std::thread client([&] {
    LineStream line(run.lines);
    line.Write(hello_of("r0", "token-r0"));
    v1::ServerMessage message;
    while (line.Read(&message) && !message.has_goodbye()) {
      if (message.has_refusal())
        refusals.push_back(message.refusal().field() + ": " + message.refusal().message());
      if (!message.has_observation()) continue;
      v1::ClientMessage answer;
      answer.mutable_decision()->set_sequence(message.observation().sequence());
      if (message.observation().sequence() == 2)
        answer.mutable_decision()->add_debug()->set_text(std::string(3 << 20, 'x'));
      line.Write(answer);
    }
  });
  run.start();
  client.join();
  ASSERT_EQ(refusals.size(), 1u);
  EXPECT_THAT(refusals[0],
              ::testing::MatchesRegex("decision: found 31457.. bytes, expected at most 262144 .*"));
}

TEST(DirectLine, MessagesMayComeInPieces) {
  const std::string yaml = scenario_of(1, 0.1);
  LiveRun run(yaml);
  run.start();
  RawLine line(run.lines);
  for (const char byte : line_frame(hello_of("r0", "token-r0"))) line.write({byte});
  for (int i = 0; i < 1000 && !run.hub.status()[0].connected; ++i)
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  EXPECT_TRUE(run.hub.status()[0].connected);
}

TEST(DirectLine, AClientThatHangsUpIsNoticedAndMayComeAgain) {
  const std::string yaml = scenario_of(1);
  LiveRun run(yaml);
  run.start();
  {
    LineStream line(run.lines);
    line.Write(hello_of("r0", "token-r0"));
    v1::ServerMessage message;
    while (line.Read(&message) && !message.has_observation()) {
    }
    EXPECT_TRUE(run.hub.status()[0].connected);
  }
  for (int i = 0; i < 1000 && run.hub.status()[0].connected; ++i)
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  EXPECT_FALSE(run.hub.status()[0].connected);
  std::thread again = line_client(run, 0, busy);
  EXPECT_EQ(run.fingerprint(), reference_fingerprint(yaml, busy));
  again.join();
}

TEST(DirectLine, AnotherWithTheTokenTakesOver) {
  const std::string yaml = scenario_of(1);
  LiveRun run(yaml);
  LineStream first(run.lines);
  first.Write(hello_of("r0", "token-r0"));
  v1::ServerMessage message;
  ASSERT_TRUE(first.Read(&message));
  std::thread second = line_client(run, 0, busy);
  while (first.Read(&message)) {
  }
  EXPECT_EQ(first.Finish().error_code(), grpc::StatusCode::ABORTED);
  run.start();
  EXPECT_EQ(run.fingerprint(), reference_fingerprint(yaml, busy));
  second.join();
}

// ---- Frames ----

TEST(LineFrames, AreFoundWhereverTheyAreCut) {
  int ends[2];
  ASSERT_EQ(::socketpair(AF_UNIX, SOCK_STREAM, 0, ends), 0);
  std::vector<v1::ClientMessage> sent;
  std::string bytes;
  for (const int size : {0, 1, 3, 1000, 70'000, 200'000}) {
    sent.push_back(hello_of(std::string(static_cast<size_t>(size), 'r'), ""));
    bytes += line_frame(sent.back());
  }
  bytes += line_end(14, "later");
  for (const size_t piece : {size_t{7}, size_t{4096}, size_t{65'537}, bytes.size()}) {
    LineFrames frames(300'000);
    std::thread writer([&] {
      for (size_t at = 0; at < bytes.size(); at += piece)
        ::send(ends[0], bytes.data() + at, std::min(piece, bytes.size() - at), 0);
    });
    size_t found = 0;
    bool ended = false;
    while (!ended) {
      ASSERT_EQ(frames.receive(ends[1], 0), LineFrames::Received::bytes);
      while (const auto frame = frames.next()) {
        if (frame->is_end) {
          EXPECT_EQ(frame->code, 14);
          EXPECT_EQ(frame->bytes, "later");
          ended = true;
          continue;
        }
        v1::ClientMessage got;
        ASSERT_TRUE(got.ParseFromString(std::string(frame->bytes)));
        ASSERT_LT(found, sent.size());
        EXPECT_EQ(got.hello().robot(), sent[found++].hello().robot());
      }
    }
    EXPECT_EQ(found, sent.size());
    writer.join();
  }
  // A frame that is skipped leaves the next one whole, wherever it is cut.
  for (const size_t piece : {size_t{7}, size_t{4096}, bytes.size()}) {
    LineFrames frames(100'000, 300'000);
    std::thread writer([&] {
      for (size_t at = 0; at < bytes.size(); at += piece)
        ::send(ends[0], bytes.data() + at, std::min(piece, bytes.size() - at), 0);
    });
    std::vector<size_t> skipped;
    size_t whole = 0;
    bool ended = false;
    while (!ended) {
      ASSERT_EQ(frames.receive(ends[1], 0), LineFrames::Received::bytes);
      while (const auto frame = frames.next()) {
        if (frame->skipped_bytes > 0) skipped.push_back(frame->skipped_bytes);
        if (frame->is_end) {
          EXPECT_EQ(frame->bytes, "later");
        }
        ended = frame->is_end;
        whole += !frame->is_end && frame->skipped_bytes == 0;
      }
    }
    ASSERT_EQ(skipped.size(), 1u);
    EXPECT_GT(skipped[0], 200'000u);
    EXPECT_EQ(whole, sent.size() - 1);
    writer.join();
  }
  ::close(ends[0]);
  LineFrames frames(10);
  EXPECT_EQ(frames.receive(ends[1], 0), LineFrames::Received::closed);
  ::close(ends[1]);
}

}  // namespace
}  // namespace seam::scheduler
