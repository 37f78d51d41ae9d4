#include "tools/dm_env_rpc/world.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <chrono>
#include <utility>

#include "sim_core/base/error.h"
#include "sim_core/system/thread.h"
#include "tools/dm_env_rpc/request_error.h"

namespace seam::tools::dm {

namespace {

using grpc::StatusCode;

// How long a sequence waits for robots that nobody has joined as.
constexpr std::chrono::seconds kJoining{20};
constexpr std::chrono::milliseconds kLook{100};  // Whether who waits is still there.

}  // namespace

World::World(std::string name, const std::vector<RobotInterface>& robots, const RunCommand& command,
             int64_t seed)
    : name_(std::move(name)), command_(command), places_(robots.size()), next_seed_(seed) {
  for (size_t i = 0; i < robots.size(); ++i) places_[i].robot = &robots[i];
}

World::~World() {
  run_.reset();  // Before the stand-ins, which wait for it.
}

size_t World::join(const std::string& robot) {
  const std::lock_guard lock(mutex_);
  std::vector<std::string> names, free;
  for (size_t i = 0; i < places_.size(); ++i) {
    const Place& place = places_[i];
    names.push_back(place.robot->robot());
    const bool meant = robot.empty() || robot == place.robot->robot();
    if (meant && place.state == State::vacant) {
      places_[i].state = State::idle;
      return i;
    }
  }
  if (robot.empty() || std::find(names.begin(), names.end(), robot) != names.end())
    throw RequestError(StatusCode::ALREADY_EXISTS,
                       fmt::format("world '{}': another agent has joined as {}", name_,
                                   robot.empty() ? "each of its robots" : "'" + robot + "'"));
  throw RequestError(StatusCode::NOT_FOUND,
                     fmt::format("setting 'robot': found '{}', expected one of: {}",
                                 robot.substr(0, 64), fmt::join(names, ", ")));
}

void World::leave(size_t place) {
  reset(place);
  const std::lock_guard lock(mutex_);
  places_[place].state = State::vacant;
  changed_.notify_all();
}

rpc::StepResponse World::step(size_t number, const rpc::StepRequest& request,
                              const Cancelled& cancelled) {
  Place& place = places_[number];
  const auto& asked = request.requested_observations();
  place.robot->check_observations(asked);
  // Only its own agent's calls let a place play or stop.
  if (place.state == State::playing)
    answer(place, request);
  else
    begin(place, cancelled);
  rpc::StepResponse response;
  const bool goes_on = sense(place);
  place.robot->observe(place.sensed, asked, *response.mutable_observations());
  if (!goes_on) {
    stop_playing(place, true);
    response.set_state(rpc::TERMINATED);
  } else if (take_interruption(place)) {
    stop_playing(place, false);
    response.set_state(rpc::INTERRUPTED);
  } else {
    response.set_state(rpc::RUNNING);
    if (const std::string& refused = place.line->refused(); !refused.empty())
      throw RequestError(StatusCode::INVALID_ARGUMENT,
                         "the actions were refused, and the robot went on as before: " + refused);
  }
  return response;
}

void World::answer(Place& place, const rpc::StepRequest& request) {
  v1::Decision decision = place.robot->decide(request.actions(), place.walk);
  const bool frames = place.robot->asks_for_frames(request.requested_observations());
  if (frames != std::exchange(place.frames_on, frames))
    decision.add_frame_requests()->set_which(frames ? v1::FrameRequest::ALL
                                                    : v1::FrameRequest::NONE);
  place.line->answer(std::move(decision));
}

bool World::sense(Place& place) {
  try {
    auto now = place.line->next();
    if (!now) return false;
    place.sensed.now = std::move(*now);
  } catch (const RequestError& error) {
    std::string why = error.what();
    {
      const std::lock_guard lock(mutex_);
      if (closed_)
        why = "the server ends";
      else if (run_)
        why += ": " + run_->last_words();
    }
    stop_playing(place, false);
    throw RequestError(error.code(), why);
  }
  auto& frames = *place.sensed.now.mutable_frames();
  if (!frames.empty()) place.sensed.frame = std::move(frames[frames.size() - 1]);
  frames.Clear();
  return true;
}

bool World::take_interruption(Place& place) {
  const std::lock_guard lock(mutex_);
  return place.interrupted;
}

void World::reset(size_t place) {
  if (places_[place].state == State::playing) stop_playing(places_[place], false);
}

void World::begin(Place& place, const Cancelled& cancelled) {
  const auto since = std::chrono::steady_clock::now();
  std::unique_lock lock(mutex_);
  place.ready = true;
  while (place.state != State::playing) {
    if (!place.ready) throw RequestError(StatusCode::FAILED_PRECONDITION, failure_);
    if (starting_) {  // Nobody leaves a sequence that is being made.
      changed_.wait_for(lock, kLook);
      continue;
    }
    if (closed_) give_up_waiting(place, "the server ends", StatusCode::UNAVAILABLE);
    if (cancelled()) give_up_waiting(place, "cancelled", StatusCode::CANCELLED);
    if (can_start()) {
      start(lock);
      continue;
    }
    std::vector<std::string> missing;
    for (const Place& other : places_)
      if (other.state == State::vacant) missing.push_back(other.robot->robot());
    if (!missing.empty() && std::chrono::steady_clock::now() - since > kJoining)
      give_up_waiting(place,
                      fmt::format("world '{}' waits for agents that join as {}: they do so on "
                                  "streams of their own; `seam serve --drive ROBOT` drives fewer",
                                  name_, fmt::join(missing, ", ")),
                      StatusCode::DEADLINE_EXCEEDED);
    changed_.wait_for(lock, kLook);
  }
}

void World::give_up_waiting(Place& place, const std::string& why, StatusCode code) {
  place.ready = false;
  throw RequestError(code, why);
}

bool World::can_start() const {
  return !starting_ && !run_ && std::all_of(places_.begin(), places_.end(), [](const Place& place) {
    return place.ready;
  });
}

void World::start(std::unique_lock<std::mutex>& lock) {
  starting_ = true;
  const int64_t seed = next_seed_;
  const std::string log = log_of(sequences_ + 1);
  // A process takes its time; those who look whether they wait in vain go on meanwhile.
  lock.unlock();
  std::unique_ptr<Run> run;
  std::vector<std::unique_ptr<RobotLine>> lines;
  std::string failure;
  try {
    run = std::make_unique<Run>(command_, seed, log);
    for (const Place& place : places_) lines.push_back(run->line_of(place.robot->robot()));
  } catch (const std::exception& error) {
    failure = error.what();
  }
  lock.lock();
  starting_ = false;
  failure_ = failure;
  for (size_t i = 0; i < places_.size(); ++i) {
    Place& place = places_[i];
    place.ready = false;
    if (!failure.empty()) continue;
    place.state = State::playing;
    place.interrupted = place.frames_on = false;
    place.sensed = {};
    place.walk.Clear();
    place.line = std::move(lines[i]);
  }
  if (failure.empty()) {
    run_ = std::move(run);
    ++sequences_;
    ++next_seed_;
  }
  changed_.notify_all();
}

bool World::anybody_plays() const {
  return std::any_of(places_.begin(), places_.end(),
                     [](const Place& place) { return place.state == State::playing; });
}

void World::stop_playing(Place& place, bool run_over) {
  std::unique_lock lock(mutex_);
  place.state = State::idle;
  place.interrupted = false;
  changed_.notify_all();
  if (anybody_plays()) {
    if (!run_over) place.stand_in = start_thread([this, &place] { stand_in(place); });
    return;
  }
  // The last one. Until `run_` is gone no other sequence begins, and nobody else comes here.
  Run& run = *run_;
  lock.unlock();
  const int code = run_over ? run.finish() : 0;
  const std::string words = run.last_words();
  std::unique_ptr<Run> ended;
  lock.lock();
  starting_ = true;
  ended = std::move(run_);
  lock.unlock();
  ended.reset();
  // The lines last: a run that still goes on would log broken connections.
  for (Place& each : places_) {
    if (each.stand_in.joinable()) each.stand_in.join();
    each.line.reset();
  }
  lock.lock();
  starting_ = false;
  changed_.notify_all();
  if (code != 0) throw RequestError(StatusCode::ABORTED, words);
}

void World::stand_in(Place& place) {
  try {
    do place.line->answer({});
    while (place.line->next());
  } catch (const RequestError&) {
    // The run has ended.
  }
}

void World::reset_all(std::optional<size_t> caller, const Cancelled& cancelled) {
  std::unique_lock lock(mutex_);
  // Before the caller's stand-in lets a step of theirs go on.
  for (Place& place : places_) place.interrupted = place.state == State::playing;
  lock.unlock();
  if (caller) reset(*caller);
  lock.lock();
  while (std::any_of(places_.begin(), places_.end(),
                     [](const Place& place) { return place.interrupted; })) {
    if (closed_) throw RequestError(StatusCode::UNAVAILABLE, "the server ends");
    if (cancelled()) throw RequestError(StatusCode::CANCELLED, "cancelled");
    changed_.wait_for(lock, kLook);
  }
}

std::vector<std::string> World::joined() const {
  const std::lock_guard lock(mutex_);
  std::vector<std::string> robots;
  for (const Place& place : places_)
    if (place.state != State::vacant) robots.push_back(place.robot->robot());
  return robots;
}

void World::seed_next(int64_t seed) {
  const std::lock_guard lock(mutex_);
  next_seed_ = seed;
}

int64_t World::next_seed() const {
  const std::lock_guard lock(mutex_);
  return next_seed_;
}

int64_t World::sequences() const {
  const std::lock_guard lock(mutex_);
  return sequences_;
}

std::string World::log_of(int64_t sequence) const {
  return fmt::format("{}-{}.mcap", name_, sequence);
}

void World::close() {
  const std::lock_guard lock(mutex_);
  closed_ = true;
  changed_.notify_all();
  if (run_) run_->stop();
}

}  // namespace seam::tools::dm
