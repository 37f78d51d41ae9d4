#include "app/signals/signal_expression.h"

#include <gtest/gtest.h>

#include <cmath>

#include "app/signals/record_signals.h"
#include "sim_core/base/error.h"

namespace seam::app {
namespace {

TEST(SignalExpression, HasNoValueUntilAllThatItReadsHasOne) {
  std::vector<std::string> names;
  const SignalExpression sum("red1.a + red1.b * time_s", "reward", names);
  EXPECT_EQ(names, (std::vector<std::string>{"red1.a", "red1.b", "time_s"}));
  SignalValues values(names);
  EXPECT_EQ(sum.value(SimTime::from_s(1), values), std::nullopt);
  values.set(0, SimTime::from_s(1), 5);
  EXPECT_EQ(sum.value(SimTime::from_s(1), values), std::nullopt);
  values.set(1, SimTime::from_s(1), 2);
  EXPECT_EQ(sum.value(SimTime::from_s(3), values), 11);
  EXPECT_TRUE(sum.grows());
  const SignalExpression constant("1 + red1.a", "reward", names);
  EXPECT_FALSE(constant.grows());
  EXPECT_EQ(constant.value(SimTime::from_s(3), values), 6);
  const SignalExpression none("0 / 0", "reward", names);
  EXPECT_TRUE(std::isnan(none.value(SimTime::from_s(3), values).value_or(0)));
}

TEST(SignalExpression, AnAgeIsTheTimeSinceTheLastValueOrTheStart) {
  std::vector<std::string> names;
  const SignalExpression age("red1.a.age_s", "reward", names);
  EXPECT_EQ(names, std::vector<std::string>{"red1.a"});
  SignalValues values(names);
  EXPECT_EQ(age.value(SimTime::from_s(2), values), 2);
  values.set(0, SimTime::from_s(2), 7);
  EXPECT_EQ(age.value(SimTime::from_s(3.5), values), 1.5);
}

TEST(SignalExpression, AnEventIsZeroButAtItsInstant) {
  std::vector<std::string> names;
  const SignalExpression goals("10 * event.goal + red1.event.kick", "reward", names);
  SignalValues values(names);
  EXPECT_EQ(goals.value(SimTime::from_s(1), values), 0);
  values.set(0, SimTime::from_s(1), 1);
  EXPECT_EQ(goals.value(SimTime::from_s(1), values), 10);
  values.end_instant();
  EXPECT_EQ(goals.value(SimTime::from_s(1), values), 0);
}

TEST(SignalExpression, MistakesNameTheExpression) {
  std::vector<std::string> names;
  for (const char* text : {"1 +", "1 2", "a $ b", "foo(1)", "(1", ""}) {
    try {
      SignalExpression(text, "watch.expressions[3]", names);
      ADD_FAILURE() << text;
    } catch (const UsageError& error) {
      EXPECT_TRUE(std::string(error.what()).starts_with("watch.expressions[3]: ")) << error.what();
    }
  }
}

TEST(RecordSignals, NamesCannotHoldAllCharacters) {
  EXPECT_EQ(plain_name("red-1.ball area"), "red_1.ball_area");
  EXPECT_TRUE(is_event("event.goal") && is_event("red1.event.kick"));
  EXPECT_FALSE(is_event("red1.events"));
}

TEST(RecordSignals, GivesWhatIsWantedByItsPlace) {
  std::vector<std::pair<int, double>> given;
  RecordSignals signals({{"r-0", true, [](int) { return std::string("pan"); }}},
                        {"truth.r_0.ball_distance_m", "r_0.area", "r_0.command.pan_rad"},
                        [&](int name, SimTime, double value) { given.emplace_back(name, value); });
  // x, y, heading and the head's three joints, then the ball.
  signals.take_poses(SimTime::from_s(0), std::vector<double>{1, 2, 0, 0, 0, 0, 4, 6, 0});
  signals.take_poses(SimTime::from_s(0), std::vector<double>{1, 2});  // Of another world.
  scheduler::Turn turn;
  scheduler::Answer& answer = turn.answers.emplace_back();
  answer.robot = 0;
  scheduler::DebugItem& item = answer.decision.debug.emplace_back();
  item.kind = scheduler::DebugItem::Kind::value;
  item.name = "area";
  item.value = 7;
  answer.decision.command.joints.push_back(
      {.offset = {}, .targets = {{.joint = 1, .angle_rad = 0.5}}});
  signals.take_turn(SimTime::from_s(0), turn);
  EXPECT_EQ(given, (std::vector<std::pair<int, double>>{{0, 5}, {2, 0.5}, {1, 7}}));
  EXPECT_EQ(signals.names().near("truth.r_0.x"), ", did you mean 'truth.r_0.x_m'?");
}

}  // namespace
}  // namespace seam::app
