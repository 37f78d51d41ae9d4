#include "scheduler/clients/client_hub.h"

#include <poll.h>

#include <algorithm>
#include <tuple>
#include <utility>

#include "scheduler/loop/command_notes.h"
#include "scheduler/wire/token.h"
#include "sim_core/base/error.h"
#include "sim_core/input/shown_text.h"

namespace seam::scheduler {

namespace {

// Faults that are kept until the loop takes them; a flooding client cannot fill the memory.
constexpr size_t kMaxFaults = 1000;
// A line of the log in so much simulated time says how many came with a wrong token.
constexpr SimDuration kHellosTold = SimDuration::from_ns(1'000'000'000);

}  // namespace

ClientHub::ClientHub(std::vector<HubRobot> robots, RunControl& control) : control_(control) {
  for (HubRobot& robot : robots) {
    slots_.emplace_back();
    slots_.back().frozen = !robot.expected;
    slots_.back().robot = std::move(robot);
  }
  control_.set_waker([this] { changed_.ring(); });
}

int ClientHub::robot_number(const std::string& id) const {
  for (size_t i = 0; i < slots_.size(); ++i)
    if (slots_[i].robot.id == id) return static_cast<int>(i);
  return -1;
}

ClientHub::Attached ClientHub::attach(const std::string& robot, const std::string& token,
                                      const std::string& client,
                                      std::shared_ptr<ClientConnection> connection) {
  const int number = robot_number(robot);
  if (number < 0) return {Attachment::unknown_robot};
  std::shared_ptr<ClientConnection> previous;
  Attached attached{Attachment::accepted, number};
  {
    const std::lock_guard lock(mutex_);
    Slot& slot = slots_[number];
    if (!same_token(token, slot.robot.token)) return {Attachment::wrong_token};
    if (ended_) return {Attachment::ended};
    previous = std::exchange(slot.connection, std::move(connection));
    slot.client = shown(client);
    slot.active = false;
    slot.ever_connected = true;
    slot.returning = true;
    slot.gone = false;
    attached.next_sequence = slot.last_sequence + (slot.owes ? 0 : 1);
  }
  // A half-open connection that nobody noticed yet must not keep the robot's client out.
  if (previous) previous->drop("another connection with this robot's token took over");
  return attached;
}

void ClientHub::activate(int robot, const ClientConnection& connection) {
  const std::lock_guard lock(mutex_);
  Slot& slot = slots_[robot];
  if (slot.connection.get() != &connection) return;
  slot.active = true;
  if (slot.owes) slot.connection->send(slot.pending, asked_);
  if (slot.connection->descriptor() >= 0) changed_.ring();  // The loop is to read it from now on.
}

void ClientHub::detach(int robot, const ClientConnection& connection) {
  const std::lock_guard lock(mutex_);
  Slot& slot = slots_[robot];
  if (slot.connection.get() != &connection) return;
  slot.connection.reset();
  slot.client.clear();
  slot.active = false;
}

Acceptance ClientHub::answer(int robot, const ClientConnection& connection, uint64_t sequence,
                             Decision decision, const DecisionDoubts& doubts) {
  const std::lock_guard lock(mutex_);
  Slot& slot = slots_[robot];
  if (slot.connection.get() != &connection) return Acceptance::stale;
  slot.returning = true;
  if (sequence > slot.last_sequence) return Acceptance::future;
  if (sequence < slot.last_sequence) return Acceptance::stale;
  if (!slot.owes) return Acceptance::duplicate;
  const bool logs_too_much = !slot.budget.spend(now_, decision.debug);
  // Before the loop goes on and time with it.
  add_doubts(robot, logs_too_much ? DecisionDoubts{.refused = "debug: beyond the budget"} : doubts);
  slot.decision = logs_too_much ? Decision{} : std::move(decision);
  slot.owes = false;
  if (--owed_ == 0 && std::this_thread::get_id() != loop_) changed_.ring();
  return logs_too_much ? Acceptance::logs_too_much : Acceptance::accepted;
}

void ClientHub::note_fault(int robot, const std::string& name, const std::string& detail) {
  const std::lock_guard lock(mutex_);
  add_fault(robot, name, detail);
}

void ClientHub::add_fault(int robot, const std::string& name, const std::string& detail) {
  if (faults_.size() >= kMaxFaults) return;
  faults_.push_back(
      {now_, EventKind::fault, robot < 0 ? "" : slots_[robot].robot.id, name, detail});
}

void ClientHub::add_doubts(int robot, const DecisionDoubts& doubts) {
  if (!doubts.refused.empty()) add_fault(robot, kRefusedFault, doubts.refused);
  for (const auto& [joint, text] : doubts.clamped) {
    if (slots_[robot].clamped.test(joint)) continue;
    slots_[robot].clamped.set(joint);
    add_fault(robot, kClampedFault, text);
  }
}

void ClientHub::note_wrong_hello(int robot) {
  const std::lock_guard lock(mutex_);
  ++slots_[robot].wrong_hellos;
}

void ClientHub::give_up(const std::string& robot, const std::string& reason) {
  const int number = robot_number(robot);
  if (number < 0) return;
  const std::lock_guard lock(mutex_);
  slots_[number].gone = true;
  slots_[number].gone_reason = reason;
  changed_.ring();
}

void ClientHub::act(std::vector<SupervisorAction> actions) {
  const std::lock_guard lock(mutex_);
  actions_.insert(actions_.end(), actions.begin(), actions.end());
}

std::vector<HubRobotStatus> ClientHub::status() const {
  const std::lock_guard lock(mutex_);
  std::vector<HubRobotStatus> all;
  for (const Slot& slot : slots_)
    all.push_back({slot.robot.id, slot.connection != nullptr, slot.frozen, slot.owes, slot.client});
  return all;
}

std::vector<std::string> ClientHub::waiting_for(double& since_s) const {
  const std::lock_guard lock(mutex_);
  std::vector<std::string> ids;
  since_s = 0;
  for (const Slot& slot : slots_)
    if (slot.owes) ids.push_back(slot.robot.id);
  if (!ids.empty()) since_s = std::chrono::duration<double>(WallClock::now() - asked_at_).count();
  return ids;
}

double ClientHub::wall_waiting_s() const {
  const std::lock_guard lock(mutex_);
  return waited_s_;
}

uint64_t ClientHub::decisions() const {
  const std::lock_guard lock(mutex_);
  return decisions_;
}

std::vector<ClientHub::Letter> ClientHub::letters_for(
    SimTime now, std::span<const std::shared_ptr<const Observation>> observations) {
  std::vector<Letter> letters;
  const std::lock_guard lock(mutex_);
  now_ = now;
  loop_ = std::this_thread::get_id();
  applied_.clear();
  asked_.clear();
  for (const auto& observation : observations) {
    Slot& slot = slots_[observation->robot];
    slot.pending = observation;
    slot.last_sequence = observation->sequence;
    slot.decision.reset();
    const bool takes_part = !slot.frozen || (slot.returning && slot.active);
    slot.returning = false;
    if (!takes_part) continue;
    slot.owes = true;
    ++owed_;
    asked_.push_back(observation->robot);
    if (slot.active) letters.emplace_back(slot.connection, observation);
  }
  asked_at_ = WallClock::now();
  return letters;
}

ClientHub::WallClock::time_point ClientHub::deadline_of(const Slot& slot) const {
  if (slot.gone) return asked_at_;
  if (slot.robot.policy == SilencePolicy::wait) return WallClock::time_point::max();
  const double limit_s = slot.ever_connected ? slot.robot.limit_s : slot.robot.connect_limit_s;
  if (limit_s > 1e6) return WallClock::time_point::max();
  return asked_at_ +
         std::chrono::duration_cast<WallClock::duration>(std::chrono::duration<double>(limit_s));
}

void ClientHub::apply_policies(WallClock::time_point now) {
  for (size_t i = 0; i < slots_.size(); ++i) {
    Slot& slot = slots_[i];
    if (!slot.owes || now < deadline_of(slot)) continue;
    slot.owes = false;
    --owed_;
    applied_.emplace_back(
        static_cast<int>(i),
        slot.gone
            ? slot.gone_reason
            : fmt::format("no answer within {} s of wall time",
                          slot.ever_connected ? slot.robot.limit_s : slot.robot.connect_limit_s));
  }
}

std::optional<ClientHub::WallClock::time_point> ClientHub::next_deadline() const {
  auto earliest = WallClock::time_point::max();
  for (const Slot& slot : slots_)
    if (slot.owes) earliest = std::min(earliest, deadline_of(slot));
  if (earliest == WallClock::time_point::max()) return std::nullopt;
  return earliest;
}

Answer ClientHub::answer_of(Slot& slot) {
  const int number = static_cast<int>(&slot - slots_.data());
  Answer answer{number, slot.pending->sequence, Outcome::absent, {}, {}};
  const auto applied = std::find_if(applied_.begin(), applied_.end(),
                                    [&](const auto& entry) { return entry.first == number; });
  if (slot.decision) {
    answer.outcome = slot.frozen ? Outcome::resumed : Outcome::decided;
    answer.decision = std::move(*slot.decision);
    slot.decision.reset();
    slot.frozen = false;
    ++decisions_;
  } else if (applied != applied_.end()) {
    answer.reason = applied->second;
    if (slot.robot.policy != SilencePolicy::freeze) {
      answer.outcome = Outcome::abort;
    } else {
      answer.outcome = slot.frozen ? Outcome::absent : Outcome::frozen;
      slot.frozen = true;
    }
  }
  slot.pending.reset();
  return answer;
}

// Sleeps until something has changed; serves the connections that are read here.
void ClientHub::wait(std::unique_lock<std::mutex>& lock,
                     std::optional<WallClock::time_point> until) {
  std::vector<std::shared_ptr<ClientConnection>> served;
  std::vector<pollfd> all{{changed_.descriptor(), POLLIN, 0}};
  for (const Slot& slot : slots_) {
    if (!slot.owes || !slot.active || slot.connection->descriptor() < 0) continue;
    served.push_back(slot.connection);
    const short writes = slot.connection->wants_to_write() ? POLLOUT : 0;
    all.push_back({slot.connection->descriptor(), static_cast<short>(POLLIN | writes), 0});
  }
  lock.unlock();
  timespec rest{};
  if (until) {
    const auto left = std::max(*until - WallClock::now(), WallClock::duration::zero());
    rest = {std::chrono::floor<std::chrono::seconds>(left).count(),
            (left % std::chrono::seconds(1)).count()};
  }
  ::ppoll(all.data(), all.size(), until ? &rest : nullptr, nullptr);
  if (all[0].revents != 0) changed_.clear();
  for (size_t i = 0; i < served.size(); ++i)
    if (all[i + 1].revents != 0) served[i]->serve();
  lock.lock();
}

// Sending happens outside the lock, so that early answers do not wait for late observations.
void ClientHub::ask(SimTime now, std::span<const std::shared_ptr<const Observation>> observations) {
  for (const auto& [connection, observation] : letters_for(now, observations))
    connection->send(observation, asked_);
}

std::optional<Turn> ClientHub::decide(
    SimTime now, std::span<const std::shared_ptr<const Observation>> observations) {
  const std::vector<Letter> letters = letters_for(now, observations);
  // Several clients are asked side by side, on as many cores as there are.
  core_.begin(slots_.size() == 1 && !letters.empty() ? letters.front().first->process() : 0);
  for (const auto& [connection, observation] : letters) connection->send(observation, asked_);
  std::optional<Turn> turn = answers(observations);
  core_.end(WallClock::now() - asked_at_);
  return turn;
}

std::optional<Turn> ClientHub::answers(
    std::span<const std::shared_ptr<const Observation>> observations) {
  std::unique_lock lock(mutex_);
  while (owed_ > 0) {
    if (control_.wanted()) {
      lock.unlock();
      control_.serve();
      lock.lock();
      if (control_.stop_requested()) {
        for (Slot& slot : slots_) slot.owes = false;
        owed_ = 0;
        return std::nullopt;
      }
    }
    apply_policies(WallClock::now());
    if (owed_ == 0) break;
    const auto deadline = next_deadline();
    // While something stays wanted (a pause that begins after this instant), look every 10 ms.
    if (control_.wanted())
      wait(lock, WallClock::now() + std::chrono::milliseconds(10));
    else
      wait(lock, deadline);
  }
  waited_s_ += std::chrono::duration<double>(WallClock::now() - asked_at_).count();
  Turn turn;
  for (const auto& observation : observations)
    turn.answers.push_back(answer_of(slots_[observation->robot]));
  turn.actions = std::exchange(actions_, {});
  return turn;
}

std::vector<SimulationEvent> ClientHub::take_faults() {
  const std::lock_guard lock(mutex_);
  for (Slot& slot : slots_) {
    if (slot.wrong_hellos == 0) continue;
    if (slot.hellos_told && now_ - *slot.hellos_told < kHellosTold) continue;
    faults_.push_back({now_, EventKind::fault, slot.robot.id, "wrong_token",
                       slot.wrong_hellos == 1
                           ? "a client was refused"
                           : fmt::format("{} clients were refused", slot.wrong_hellos)});
    slot.wrong_hellos = 0;
    slot.hellos_told = now_;
  }
  // Robots answer in any order of the wall's time; logs of equal runs are equal.
  std::stable_sort(faults_.begin(), faults_.end(),
                   [](const SimulationEvent& a, const SimulationEvent& b) {
                     return std::tie(a.time, a.robot) < std::tie(b.time, b.robot);
                   });
  return std::exchange(faults_, {});
}

void ClientHub::finish(SimTime time, const std::string& reason) {
  std::vector<std::shared_ptr<ClientConnection>> connections;
  {
    const std::lock_guard lock(mutex_);
    ended_ = true;
    for (Slot& slot : slots_)
      if (slot.connection) connections.push_back(slot.connection);
  }
  for (const auto& connection : connections) connection->say_goodbye(time, reason);
}

}  // namespace seam::scheduler
