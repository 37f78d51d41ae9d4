#include "scheduler/replay/rewinder.h"

#include "scheduler/loop/world_actions.h"
#include "sim_core/base/error.h"

namespace seam::scheduler {
namespace {

// A run that goes forward by less than this is not worth a restart from a snapshot.
constexpr SimDuration kForwardWithoutSnapshot = SimDuration::from_ns(2'000'000'000);

}  // namespace

Rewinder::Rewinder(const Log& log, World& world, bool use_snapshots)
    : log_(log),
      world_(world),
      use_snapshots_(use_snapshots),
      initial_state_(world.snapshot()),
      last_time_(log.end_time()) {
  restart(SimTime());
}

void Rewinder::restart(SimTime time) {
  const std::optional<SnapshotRecord> snapshot =
      use_snapshots_ ? log_.snapshot_before(time) : std::nullopt;
  due_.clear();
  next_turn_.reset();
  SimDuration longest_latency = world_.scenario().step;
  for (const RobotSpec& robot : world_.scenario().robots) {
    longest_latency = std::max(longest_latency, robot.behaviour.decision_latency);
  }
  if (!snapshot) {
    world_.restore(initial_state_);
    now_ = SimTime();
    step_ = 0;
    turns_.emplace(log_, TopicSet{Topic::turn});
    if (world_.end() == SimTime()) {
      world_.step();
      step_ = 1;
    }
    return;
  }
  world_.restore(snapshot->state);
  now_ = snapshot->time;
  step_ = snapshot->step;
  // A log may be wrong behind right check sums.
  if (now_ < world_.start() || now_ > world_.end()) {
    throw InputError(fmt::format("{}: the snapshot at {} ns holds a world from {} to {} ns",
                                 log_.name(), now_.ns(), world_.start().ns(), world_.end().ns()));
  }
  // Decisions from before the snapshot may act after it; those that acted are in its state.
  turns_.emplace(log_, TopicSet{Topic::turn}, now_ - longest_latency);
  read_turns_until(now_);
  std::erase_if(due_, [&](const auto& entry) { return std::get<0>(entry.first) <= now_; });
}

SimTime Rewinder::to(SimTime time) {
  time = std::clamp(time, SimTime(), last_time_);
  if (time < now_ || time - now_ > kForwardWithoutSnapshot) restart(time);
  while (world_.end() <= time) {
    read_turns_until(world_.end());
    apply_due(world_.end());
    world_.step();
    ++step_;
  }
  read_turns_until(time);
  apply_due(time);
  now_ = time;
  return time;
}

// Reads the turns of all instants up to this time, and notes when their decisions act.
void Rewinder::read_turns_until(SimTime time) {
  while (true) {
    if (!next_turn_) {
      std::optional<LogRecord> record = turns_->next();
      if (!record) return;
      next_turn_ = std::get<TurnRecord>(std::move(*record));
    }
    if (next_turn_->time > time) return;
    for (Answer& answer : next_turn_->turn.answers) {
      const RobotSpec& robot = world_.scenario().robots[static_cast<size_t>(answer.robot)];
      const SimDuration latency = robot.behaviour.decision_latency;
      // Without a latency a decision acts at the next step of the world.
      const SimDuration step = world_.scenario().step;
      const SimTime next_step = SimTime() + step * (next_turn_->time.ns() / step.ns() + 1);
      const SimTime acts = latency.ns() > 0 ? next_turn_->time + latency : next_step;
      const int who = answer.robot + 1;
      due_[{acts, who, arrivals_++}] = {std::move(answer), std::nullopt};
    }
    for (const SupervisorAction& action : next_turn_->turn.actions) {
      due_[{next_turn_->time + SimDuration::from_ns(1), 0, arrivals_++}] = {std::nullopt, action};
    }
    next_turn_.reset();
  }
}

void Rewinder::apply_due(SimTime until) {
  while (!due_.empty() && std::get<0>(due_.begin()->first) <= until) {
    const auto node = due_.extract(due_.begin());
    if (std::get<0>(node.key()) < world_.start()) {
      throw InputError(fmt::format("{}: a turn before {} ns stands behind later ones", log_.name(),
                                   world_.start().ns()));
    }
    apply(node.mapped(), std::get<0>(node.key()));
  }
}

void Rewinder::apply(const Due& due, SimTime time) {
  if (due.action) {
    act_on_world(world_, *due.action);
    return;
  }
  const Answer& answer = *due.answer;
  const auto robot = static_cast<size_t>(answer.robot);
  if (answer.outcome == Outcome::frozen) {
    world_.freeze(robot, time);
  } else if (answer.outcome == Outcome::decided || answer.outcome == Outcome::resumed) {
    act_on_world(world_, robot, answer.decision, time);
  }
}

}  // namespace seam::scheduler
