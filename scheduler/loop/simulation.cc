#include "scheduler/loop/simulation.h"

#include <algorithm>
#include <map>

#include "scheduler/loop/clock.h"
#include "scheduler/loop/event_queue.h"
#include "scheduler/loop/frame_pipeline.h"
#include "scheduler/loop/run_fingerprint.h"
#include "scheduler/loop/world_actions.h"
#include "sim_core/base/error.h"

namespace seam::scheduler {

class Simulation::Loop {
 public:
  Loop(SimulationParts parts, const SimulationOptions& options);

  EndReason run();
  bool run_to(SimTime time);

  SimTime now() const { return now_; }
  uint64_t fingerprint() const { return fingerprint_.value(); }
  uint64_t steps() const { return steps_; }
  uint64_t frames() const { return frames_; }
  uint64_t decisions() const { return decisions_; }

 private:
  // What acts at one time for one robot.
  struct Action {
    Answer answer;
    bool freeze = false;
  };
  struct RobotState {
    Clock behaviour;
    int64_t next_tick = 0;
    uint64_t observations = 0;
    uint64_t actions = 0;
    std::map<uint64_t, Action> pending;                // By the sequence number of their event.
    std::vector<std::shared_ptr<const Frame>> frames;  // Finished, not yet delivered.
    SimTime told_until = SimTime::from_ns(-1);         // Of the last observation.
  };

  void start();
  bool advance(SimTime until);
  void finish(EndReason reason);
  void dispatch(const EventKey& key);
  void apply_decision(int robot, uint64_t sequence);
  void apply_supervisor();
  void step_world();
  void deliver(int robot);
  void wait_for_decisions();
  void take(const Answer& answer);
  void tell_policy(const Answer& answer);
  void tell_debug(const Answer& answer);
  void report(SimulationEvent event);
  bool is_told(const WorldEvent& event) const;
  SimTime acts_at(int robot) const;
  void push_tick(int robot);
  const std::string& id(int robot) const { return parts_.scenario.robots[robot].id; }

  SimulationParts parts_;
  SimTime until_;
  const bool has_contacts_, hashes_states_;
  EventQueue queue_;
  std::vector<RobotState> robots_;
  std::unique_ptr<FramePipeline> pipeline_;
  std::vector<std::shared_ptr<const Observation>> due_;
  std::map<SimTime, std::vector<SupervisorAction>> supervisor_;
  SimTime now_;
  bool started_ = false;
  std::optional<EndReason> ended_;
  RunFingerprint fingerprint_;
  uint64_t steps_ = 0;
  StateDigest state_;  // After the last step.
  uint64_t frames_ = 0;
  uint64_t decisions_ = 0;
};

Simulation::Loop::Loop(SimulationParts parts, const SimulationOptions& options)
    : parts_(std::move(parts)),
      until_(options.until.value_or(SimTime() + parts_.scenario.duration)),
      has_contacts_(std::find(parts_.header.versions.begin(), parts_.header.versions.end(),
                              std::pair<std::string, std::string>(kEventsKey, kEventsVersion)) !=
                    parts_.header.versions.end()),
      hashes_states_(options.state_hashes) {
  const RandomStream root{static_cast<uint64_t>(parts_.scenario.seed), 0};
  if (options.permutation_seed) queue_.permute_insertions({*options.permutation_seed, 0});
  for (const RobotSpec& robot : parts_.scenario.robots) {
    robots_.emplace_back();
    robots_.back().behaviour = Clock(clock_settings(robot.behaviour.clock),
                                     root.child("behaviour").child(robot.id).child("clock"));
  }
  if (parts_.renderer != nullptr)
    pipeline_ = std::make_unique<FramePipeline>(
        parts_.world, *parts_.renderer, queue_, options.camera_at_rows, [this](FinishedFrame done) {
          fingerprint_.add({&done.frame->fingerprint, 1});
          ++frames_;
          parts_.control.count_frame();
          for (SimulationObserver* observer : parts_.observers)
            observer->on_frame(done.time, *done.job, *done.frame);
          robots_[done.robot].frames.push_back(std::move(done.frame));
        });
}

void Simulation::Loop::report(SimulationEvent event) {
  for (SimulationObserver* observer : parts_.observers) observer->on_event(event);
}

// Runs of an earlier log have its events.
bool Simulation::Loop::is_told(const WorldEvent& event) const {
  if (has_contacts_) return event.kind != kOldTouch;
  return event.kind != kContact && event.kind != kContactEnd;
}

void Simulation::Loop::push_tick(int robot) {
  RobotState& state = robots_[robot];
  const SimTime tick = state.behaviour.tick(state.next_tick);
  queue_.push({tick, Phase::deliver_observations, static_cast<uint32_t>(robot + 1),
               static_cast<uint64_t>(state.next_tick++)});
}

void Simulation::Loop::start() {
  started_ = true;
  for (SimulationObserver* observer : parts_.observers) observer->on_start(parts_.header);
  queue_.push({SimTime(), Phase::step_world, 0, 0});
  for (size_t i = 0; i < robots_.size(); ++i) {
    push_tick(static_cast<int>(i));
    if (pipeline_ && parts_.scenario.robots[i].camera.every_frame)
      pipeline_->request(static_cast<int>(i), {.which = FrameRequest::Which::all}, SimTime());
  }
}

EndReason Simulation::Loop::run() {
  if (advance(until_)) finish(EndReason::finished);
  return *ended_;
}

bool Simulation::Loop::run_to(SimTime time) {
  return advance(std::min(time, until_));
}

bool Simulation::Loop::advance(SimTime until) {
  if (ended_) return false;
  if (!started_) start();
  while (queue_.top().time <= until) {
    if (!parts_.control.poll(now_, queue_.top().time)) {
      finish(EndReason::stopped);
      return false;
    }
    const EventKey key = queue_.pop();
    now_ = key.time;
    dispatch(key);
    if (ended_) return false;
  }
  now_ = std::max(now_, until);
  return true;
}

void Simulation::Loop::finish(EndReason reason) {
  if (pipeline_) pipeline_->collect_all();
  ended_ = reason;
  for (SimulationObserver* observer : parts_.observers)
    observer->on_end(now_, reason, fingerprint());
  const char* words[] = {"the run is over", "the run was stopped", "the run was aborted"};
  parts_.decisions.finish(now_, words[static_cast<size_t>(reason)]);
  parts_.control.close();
}

void Simulation::Loop::dispatch(const EventKey& key) {
  const int robot = static_cast<int>(key.source) - 1;
  switch (key.phase) {
    case Phase::apply_commands:
      if (robot < 0)
        apply_supervisor();
      else
        apply_decision(robot, key.sequence);
      break;
    case Phase::step_world:
      step_world();
      break;
    case Phase::sample_light:
      pipeline_->sample(robot, key);
      break;
    case Phase::finish_frames:
      pipeline_->finish(robot, key);
      break;
    case Phase::deliver_observations:
      deliver(robot);
      break;
    case Phase::wait_for_decisions:
      wait_for_decisions();
      break;
  }
}

void Simulation::Loop::apply_decision(int robot, uint64_t sequence) {
  RobotState& state = robots_[robot];
  const auto found = state.pending.find(sequence);
  SEAM_CHECK(found != state.pending.end(), "robot {} number {}", robot, sequence);
  const Action action = std::move(found->second);
  state.pending.erase(found);
  if (action.freeze) {
    parts_.world.freeze(static_cast<size_t>(robot), now_);
    return;
  }
  const Decision& decision = action.answer.decision;
  act_on_world(parts_.world, static_cast<size_t>(robot), decision, now_);
  if (pipeline_)
    for (const FrameRequest& request : decision.frame_requests)
      pipeline_->request(robot, request, now_);
}

void Simulation::Loop::apply_supervisor() {
  const auto node = supervisor_.extract(now_);
  for (const SupervisorAction& action : node.mapped()) act_on_world(parts_.world, action);
}

void Simulation::Loop::step_world() {
  parts_.world.step();
  ++steps_;
  queue_.push({parts_.world.end(), Phase::step_world, 0, steps_});
  if (hashes_states_) {
    state_ = parts_.world.digest(std::move(state_));
    fingerprint_.add(state_.section_hashes);
    for (SimulationObserver* observer : parts_.observers) observer->on_step(now_, steps_, state_);
  }
  for (const WorldEvent& event : parts_.world.take_events())
    if (is_told(event))
      report({event.time, kind_of(event), event.robot < 0 ? "" : id(event.robot), event.kind,
              event.detail});
}

void Simulation::Loop::deliver(int robot) {
  if (pipeline_) pipeline_->collect(robot);
  RobotState& state = robots_[robot];
  auto observation = std::make_shared<Observation>();
  observation->robot = robot;
  observation->sequence = ++state.observations;
  observation->time = now_;
  const auto index = static_cast<size_t>(robot);
  observation->sensors = parts_.world.sensors(index, now_, state.told_until);
  observation->messages = parts_.world.radio_received(index, now_, state.told_until);
  observation->game = parts_.world.game_state(index, now_);
  state.told_until = now_;
  observation->frames = std::exchange(state.frames, {});
  for (SimulationObserver* observer : parts_.observers) observer->on_observation(*observation);
  if (due_.empty()) queue_.push({now_, Phase::wait_for_decisions, 0, state.observations});
  due_.push_back(std::move(observation));
  push_tick(robot);
}

SimTime Simulation::Loop::acts_at(int robot) const {
  const SimDuration latency = parts_.scenario.robots[robot].behaviour.decision_latency;
  return latency.ns() > 0 ? now_ + latency : parts_.world.end();
}

void Simulation::Loop::wait_for_decisions() {
  const std::optional<Turn> turn = parts_.decisions.decide(now_, due_);
  for (SimulationEvent& fault : parts_.decisions.take_faults()) report(std::move(fault));
  if (!turn) {
    finish(EndReason::stopped);
    return;
  }
  SEAM_CHECK(turn->answers.size() == due_.size(), "{} answers to {} observations",
             turn->answers.size(), due_.size());
  due_.clear();
  for (SimulationObserver* observer : parts_.observers) observer->on_turn(now_, *turn);
  bool aborted = false;
  for (const Answer& answer : turn->answers) {
    take(answer);
    aborted |= answer.outcome == Outcome::abort;
  }
  if (!turn->actions.empty()) {
    const SimTime time = now_ + SimDuration::from_ns(1);
    supervisor_[time] = turn->actions;
    queue_.push({time, Phase::apply_commands, 0, steps_});
  }
  if (aborted) finish(EndReason::aborted);
}

void Simulation::Loop::take(const Answer& answer) {
  tell_policy(answer);
  tell_debug(answer);
  RobotState& state = robots_[answer.robot];
  const bool decided = answer.outcome == Outcome::decided || answer.outcome == Outcome::resumed;
  if (decided) ++decisions_;
  if (!decided && answer.outcome != Outcome::frozen) return;
  const uint64_t number = state.actions++;
  state.pending[number] = {answer, !decided};
  queue_.push({acts_at(answer.robot), Phase::apply_commands,
               static_cast<uint32_t>(answer.robot + 1), number});
}

void Simulation::Loop::tell_policy(const Answer& answer) {
  const char* name = nullptr;
  if (answer.outcome == Outcome::frozen) name = "freeze";
  if (answer.outcome == Outcome::resumed) name = "resume";
  if (answer.outcome == Outcome::abort) name = "abort";
  if (name != nullptr) report({now_, EventKind::policy, id(answer.robot), name, answer.reason});
}

void Simulation::Loop::tell_debug(const Answer& answer) {
  for (const DebugItem& item : answer.decision.debug) {
    SimulationEvent event{now_, EventKind::debug, id(answer.robot), {}, {}};
    switch (item.kind) {
      case DebugItem::Kind::value:
        event.name = "value/" + item.name;
        event.detail = fmt::format("{}", item.value);
        break;
      case DebugItem::Kind::text:
        event.name = "text/" + item.name;
        event.detail = item.text;
        break;
      case DebugItem::Kind::drawing:
        event.name = (item.in_image ? "image/" : "field/") + item.name;
        event.detail = fmt::format("{}", fmt::join(item.points, " "));
        break;
    }
    report(std::move(event));
  }
}

Simulation::Simulation(SimulationParts parts, SimulationOptions options)
    : loop_(std::make_unique<Loop>(std::move(parts), options)) {}
Simulation::~Simulation() = default;
EndReason Simulation::run() {
  return loop_->run();
}
bool Simulation::run_to(SimTime time) {
  return loop_->run_to(time);
}
SimTime Simulation::now() const {
  return loop_->now();
}
uint64_t Simulation::fingerprint() const {
  return loop_->fingerprint();
}
uint64_t Simulation::steps() const {
  return loop_->steps();
}
uint64_t Simulation::frames() const {
  return loop_->frames();
}
uint64_t Simulation::decisions() const {
  return loop_->decisions();
}

}  // namespace seam::scheduler
