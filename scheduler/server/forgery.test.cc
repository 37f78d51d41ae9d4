// A robot that lies to the server learns nothing and changes nothing: forged names, tokens, numbers
// and unknown fields on its own stream and in its messages to team mates.
#include <gmock/gmock.h>
#include <google/protobuf/unknown_field_set.h>

#include "scheduler/server/live_testing.h"

namespace seam::scheduler {
namespace {

using namespace seam::scheduler::testing;  // NOLINT: helpers of this folder's tests.
namespace pb = google::protobuf;

constexpr int kSpy = 1;

std::string forged_scenario(int robots) {
  return scenario_text(SEAM_SOURCE_DIR, robots, 0.4);
}

// What the spy got, as its stream brought it.
struct Got {
  std::vector<std::string> observations;
  std::vector<v1::Refusal> refusals;
  uint64_t fingerprint = 0;
};

v1::Decision secretive(int robot, const v1::Observation& seen) {
  v1::Decision decision = busy(robot, seen);
  decision.add_messages("secret of r" + std::to_string(robot));
  return decision;
}

// A live run of three in which r1 is the spy; `trick` comes before its decision and may change it.
using Trick = std::function<void(RawClient&, const v1::Observation&, v1::Decision&)>;

Got spy_with(const Trick& trick) {
  LiveRun run(forged_scenario(3));
  std::vector<std::thread> clients;
  for (const int robot : {0, 2}) clients.push_back(good_client(run, robot, secretive));
  Got got;
  clients.emplace_back([&] {
    RawClient client(run.address);
    client.hello("r1", "token-r1");
    v1::ServerMessage message;
    while (client.read(message) && !message.has_goodbye()) {
      EXPECT_EQ(message.SerializeAsString().find("secret"), std::string::npos)
          << message.ShortDebugString();
      if (message.has_refusal()) got.refusals.push_back(message.refusal());
      if (message.has_welcome()) {
        EXPECT_EQ(message.welcome().robot(), "r1");
      }
      if (!message.has_observation()) continue;
      got.observations.push_back(message.observation().SerializeAsString());
      v1::Decision decision = busy(kSpy, message.observation());
      trick(client, message.observation(), decision);
      client.decide(decision);
    }
  });
  run.start();
  got.fingerprint = run.fingerprint();
  for (std::thread& client : clients) client.join();
  return got;
}

Got honest() {
  return spy_with([](RawClient&, const v1::Observation&, v1::Decision&) {});
}

// In every field number that nobody defined: another robot's number and name, and the secret words.
void stuff(pb::Message& message, int first) {
  pb::UnknownFieldSet& unknown = *message.GetReflection()->MutableUnknownFields(&message);
  for (int number = first; number < 40; ++number) {
    unknown.AddVarint(number, 0);
    for (const char* text : {"r0", "token-r0", "boss"}) unknown.AddLengthDelimited(number, text);
  }
}

TEST(Forgery, FalseMessagesOnARobotsOwnStreamAreRefusedAndTellItNothingNew) {
  const Got reference = honest();
  ASSERT_GT(reference.observations.size(), 5u);
  EXPECT_TRUE(reference.refusals.empty());
  const std::vector<std::pair<const char*, std::function<void(RawClient&, uint64_t)>>> tricks = {
      {"a second hello as another robot, with its own token",
       [](RawClient& client, uint64_t) { client.hello("r0", "token-r1"); }},
      {"a second hello as another robot, with that one's token",
       [](RawClient& client, uint64_t) { client.hello("r0", "token-r0"); }},
      {"a second hello with the supervisor's token",
       [](RawClient& client, uint64_t) { client.hello("r0", "boss"); }},
      {"an empty message", [](RawClient& client, uint64_t) { client.write({}); }},
      {"a message of unknown kinds",
       [](RawClient& client, uint64_t) {
         v1::ClientMessage message;
         stuff(message, 3);
         client.write(message);
       }},
      {"the number of an observation to come",
       [](RawClient& client, uint64_t sequence) { client.decide(sequence + 1); }},
      {"the number of an observation that was",
       [](RawClient& client, uint64_t sequence) { client.decide(sequence - 1); }},
  };
  for (const auto& [name, trick] : tricks) {
    const Got forged =
        spy_with([trick = trick](RawClient& client, const v1::Observation& seen, v1::Decision&) {
          if (seen.sequence() % 3 == 1) trick(client, seen.sequence());
        });
    EXPECT_EQ(forged.observations, reference.observations) << name;
    EXPECT_EQ(forged.fingerprint, reference.fingerprint) << name;
    EXPECT_GE(forged.refusals.size(), 3u) << name;
  }
}

TEST(Forgery, UnknownFieldsInsideADecisionAreNotRead) {
  const Got forged = spy_with([](RawClient&, const v1::Observation&, v1::Decision& decision) {
    stuff(decision, 9);
    stuff(*decision.mutable_head(), 5);
    for (v1::FrameRequest& request : *decision.mutable_frame_requests()) stuff(request, 4);
  });
  const Got reference = honest();
  EXPECT_EQ(forged.observations, reference.observations);
  EXPECT_EQ(forged.fingerprint, reference.fingerprint);
}

TEST(Forgery, NotesInAnothersNameStayTheWritersOwn) {
  struct Notes final : SimulationObserver {
    std::vector<std::string> of;
    void on_event(const SimulationEvent& event) override {
      if (event.kind == EventKind::debug) of.push_back(event.robot + ":" + event.name);
    }
  } notes;
  LiveRun run(forged_scenario(2), {&notes});
  std::thread other = good_client(run, 0, busy);
  std::thread spy = good_client(run, kSpy, [](int robot, const v1::Observation& seen) {
    v1::Decision decision = busy(robot, seen);
    v1::DebugItem& note = *decision.add_debug();
    note.set_name("r0");
    note.set_value(1);
    stuff(note, 5);
    return decision;
  });
  run.start();
  run.wait();
  other.join();
  spy.join();
  ASSERT_FALSE(notes.of.empty());
  for (const std::string& note : notes.of) EXPECT_EQ(note, "r1:value/r0");
}

TEST(Forgery, TheRadioNamesTheTrueSenderAndStaysInTheTeam) {
  // r0, r2 and r4 are one team, r1 and r3 the other.
  struct Ears final : SimulationObserver {
    std::vector<std::vector<RadioMessage>> heard = std::vector<std::vector<RadioMessage>>(5);
    void on_observation(const Observation& seen) override {
      auto& all = heard[static_cast<size_t>(seen.robot)];
      all.insert(all.end(), seen.messages.begin(), seen.messages.end());
    }
  } ears;
  v1::RadioMessage forged;
  forged.set_from("r2");
  forged.set_payload("go home");
  LiveRun run(forged_scenario(5), {&ears});
  std::vector<std::thread> clients;
  for (int robot = 0; robot < 5; ++robot)
    clients.push_back(good_client(run, robot, [&](int r, const v1::Observation& seen) {
      v1::Decision decision = busy(r, seen);
      if (r == 0 || r == 1) decision.add_messages(forged.SerializeAsString());
      return decision;
    }));
  run.start();
  run.wait();
  for (std::thread& client : clients) client.join();
  for (const int robot : {2, 4}) {
    ASSERT_FALSE(ears.heard[static_cast<size_t>(robot)].empty());
    for (const RadioMessage& message : ears.heard[static_cast<size_t>(robot)])
      EXPECT_EQ(message.from, "r0");
  }
  ASSERT_FALSE(ears.heard[3].empty());
  for (const RadioMessage& message : ears.heard[3]) EXPECT_EQ(message.from, "r1");
  EXPECT_TRUE(ears.heard[0].empty());  // The sender does not hear itself, nor the other team.
  EXPECT_TRUE(ears.heard[1].empty());
}

}  // namespace
}  // namespace seam::scheduler
