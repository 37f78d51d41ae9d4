#include "app/signals/live_watches.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "app/signals/record_signals.h"
#include "app/signals/signal_expression.h"
#include "sim_core/base/error.h"

namespace seam::app {
namespace {

std::vector<SignalRobot> robots_of(const World& world) {
  std::vector<SignalRobot> robots;
  for (const RobotSpec& robot : world.scenario().robots)
    robots.push_back({robot.id, !robot.body.tree.present(), [&robot](int joint) {
                        return robot.body.joint_name(static_cast<size_t>(joint));
                      }});
  return robots;
}

}  // namespace

class LiveWatch final : public scheduler::Watch {
 public:
  LiveWatch(const World& world, const std::vector<std::string>& texts)
      : world_(world),
        read_(texts),
        values_(read_.names),
        signals_(robots_of(world), read_.names, [this](int name, SimTime time, double value) {
          coming_.push_back({time, static_cast<size_t>(name), value});
        }) {
    for (size_t i = 0; i < world.scenario().robots.size(); ++i) {
      const RobotBody& body = world.scenario().robots[i].body;
      for (size_t joint = 0; joint < body.joint_count(); ++joint)
        joints_.push_back({i, joint, signals_.add_joint(i, body.joint_name(joint))});
    }
    for (const std::string& name : read_.names) check(name);
  }

  std::vector<double> values(SimTime now) override {
    const std::lock_guard lock(mutex_);
    take_truth(std::clamp(now, world_.start(), world_.end()));
    // Targets of joints may lie ahead.
    std::ranges::stable_sort(coming_, {}, &Sample::time);
    const auto ahead =
        std::ranges::find_if(coming_, [now](const Sample& one) { return one.time > now; });
    for (auto one = coming_.begin(); one != ahead; ++one)
      values_.set(one->name, one->time, one->value);
    coming_.erase(coming_.begin(), ahead);
    std::vector<double> values;
    for (const SignalExpression& expression : read_.expressions)
      values.push_back(
          expression.value(now, values_).value_or(std::numeric_limits<double>::quiet_NaN()));
    values_.end_instant();
    return values;
  }

  void take(const auto& action) {
    const std::lock_guard lock(mutex_);
    action(signals_);
  }

 private:
  // The names that the expressions read.
  struct Read {
    std::vector<SignalExpression> expressions;
    std::vector<std::string> names;

    explicit Read(const std::vector<std::string>& texts) {
      for (size_t i = 0; i < texts.size(); ++i)
        expressions.emplace_back(texts[i], fmt::format("watch.expressions[{}]", i), names);
    }
  };
  struct Sample {
    SimTime time;
    size_t name = 0;
    double value = 0;
  };
  struct Joint {
    size_t robot, joint;
    int name;
  };

  // A name that may still come is one of a robot or an event; all others are known.
  void check(const std::string& name) {
    if (signals_.names().knows(name)) return;
    const bool of_a_robot = std::ranges::any_of(
        world_.scenario().robots,
        [&](const RobotSpec& robot) { return name.starts_with(plain_name(robot.id) + "."); });
    if (of_a_robot || name.starts_with("event.")) return;
    throw UsageError(fmt::format("watch: no '{}' here{}", name, signals_.names().near(name)));
  }

  void take_truth(SimTime time) {
    if (!signals_.names().wants_part("truth.")) return;
    std::vector<double> poses;
    for (size_t i = 0; i < signals_.robots(); ++i) {
      const RobotTruth robot = world_.robot(i, time);
      const bool has_head = !world_.scenario().robots[i].body.tree.present();
      const JointAngles head = has_head ? robot.joints_rad : JointAngles{};
      poses.insert(poses.end(), {robot.pose.x_m, robot.pose.y_m, robot.pose.theta_rad, head[kTilt],
                                 head[kPan], head[kRoll]});
      for (const Joint& joint : joints_)
        if (joint.robot == i) signals_.give(joint.name, time, robot.joints_rad[joint.joint]);
    }
    const Vec3 ball = world_.ball(time).p_W;
    poses.insert(poses.end(), {ball.x, ball.y, ball.z});
    signals_.take_poses(time, poses);
  }

  const World& world_;
  std::mutex mutex_;
  const Read read_;
  SignalValues values_;
  std::vector<Sample> coming_;
  RecordSignals signals_;
  std::vector<Joint> joints_;
};

std::shared_ptr<scheduler::Watch> LiveWatches::watch(const std::string& robot,
                                                     const std::vector<std::string>& expressions) {
  if (!is_driven_(robot))
    throw UsageError(fmt::format("watch: robot '{}' is not driven by a script (--drive)", robot));
  auto watch = std::make_shared<LiveWatch>(world_, expressions);
  const std::lock_guard lock(mutex_);
  watches_.push_back(watch);
  return watch;
}

template <class Action>
void LiveWatches::for_each(Action action) {
  const std::lock_guard lock(mutex_);
  std::erase_if(watches_, [](const std::weak_ptr<LiveWatch>& watch) { return watch.expired(); });
  for (const std::weak_ptr<LiveWatch>& weak : watches_)
    if (const auto watch = weak.lock()) watch->take(action);
}

void LiveWatches::on_turn(SimTime time, const scheduler::Turn& turn) {
  for_each([&](RecordSignals& signals) { signals.take_turn(time, turn); });
}

void LiveWatches::on_frame(SimTime time, const FrameJob& /*job*/, const Frame& frame) {
  const auto& robots = world_.scenario().robots;
  const auto robot = std::ranges::find(robots, frame.robot, &RobotSpec::id) - robots.begin();
  for_each([&](RecordSignals& signals) { signals.take_frame(static_cast<int>(robot), time); });
}

void LiveWatches::on_event(const scheduler::SimulationEvent& event) {
  for_each([&](RecordSignals& signals) { signals.take_event(event); });
}

}  // namespace seam::app
