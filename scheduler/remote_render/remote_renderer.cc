#include "scheduler/remote_render/remote_renderer.h"

#include <algorithm>

#include "scheduler/wire/token.h"
#include "sim_core/base/error.h"
#include "sim_core/base/hash.h"

namespace seam::scheduler {

namespace {

constexpr size_t kMaxRenderers = 64;
constexpr uint32_t kMaxFramesAtOnce = 64;
constexpr size_t kMaxNameBytes = 200;

}  // namespace

RemoteRenderer::RemoteRenderer(FrameRenderer& local, RenderSetup setup,
                               RemoteRendererOptions options, Develop develop, TellFault tell_fault)
    : local_(local),
      setup_(std::move(setup)),
      options_(std::move(options)),
      develop_(std::move(develop)),
      tell_fault_(std::move(tell_fault)),
      last_reason_(setup_.cameras.size(), "none has connected"),
      falling_back_(setup_.cameras.size(), false) {
  for (int worker = 0; worker < local.workers(); ++worker) idle_local_workers_.push_back(worker);
}

size_t RemoteRenderer::frame_bytes(int robot) const {
  const RenderCamera& camera = setup_.cameras[static_cast<size_t>(robot)];
  return static_cast<size_t>(3) * camera.width_px * camera.height_px;
}

// ---- From connections ----

std::variant<uint64_t, RemoteRenderer::Refusal> RemoteRenderer::attach(
    const RendererGreeting& greeting, std::shared_ptr<RendererConnection> connection) {
  if (options_.token.empty() || !same_token(greeting.token, options_.token))
    return Refusal{Refused::wrong_token, "token: not the render token"};
  if (greeting.version != setup_.version)
    return Refusal{Refused::other_version,
                   fmt::format("version: found {}, expected the server's, {}",
                               greeting.version.substr(0, kMaxNameBytes), setup_.version)};
  if (greeting.name.size() > kMaxNameBytes)
    return Refusal{Refused::bad_field, fmt::format("name: found {} bytes, expected at most {}",
                                                   greeting.name.size(), kMaxNameBytes)};
  if (greeting.frames_at_once < 1 || greeting.frames_at_once > kMaxFramesAtOnce)
    return Refusal{Refused::bad_field, fmt::format("frames_at_once: found {}, expected 1 to {}",
                                                   greeting.frames_at_once, kMaxFramesAtOnce)};
  Connected renderer{.connection = std::move(connection),
                     .name = greeting.name,
                     .serves = std::vector<bool>(setup_.cameras.size(), greeting.robots.empty()),
                     .capacity = greeting.frames_at_once};
  for (const std::string& robot : greeting.robots) {
    const auto found = std::find_if(setup_.cameras.begin(), setup_.cameras.end(),
                                    [&](const RenderCamera& c) { return c.robot == robot; });
    if (found == setup_.cameras.end())
      return Refusal{Refused::bad_field,
                     fmt::format("robots: no robot '{}' here", robot.substr(0, 100))};
    renderer.serves[static_cast<size_t>(found - setup_.cameras.begin())] = true;
  }
  const std::lock_guard lock(mutex_);
  if (ended_) return Refusal{Refused::ended, "the run is over"};
  if (connected_.size() >= kMaxRenderers)
    return Refusal{Refused::ended, fmt::format("{} renderers are here already", kMaxRenderers)};
  connected_.emplace(next_connection_, std::move(renderer));
  return next_connection_++;
}

void RemoteRenderer::activate(uint64_t connection) {
  {
    const std::lock_guard lock(mutex_);
    const auto found = connected_.find(connection);
    if (found == connected_.end()) return;
    found->second.active = true;
    for (size_t robot = 0; robot < falling_back_.size(); ++robot)
      if (found->second.serves[robot]) falling_back_[robot] = false;
  }
  changed_.notify_all();
}

std::optional<std::string> RemoteRenderer::take_rows(uint64_t connection, uint64_t number,
                                                     uint32_t first_row, std::string_view rgb,
                                                     uint64_t fingerprint) {
  {
    const std::lock_guard lock(mutex_);
    if (!connected_.contains(connection)) return std::nullopt;  // Whoever is dropping it says why.
    const auto found = tickets_.find(number);
    if (found == tickets_.end() || found->second->connection != connection)
      return fmt::format("number: no frame {} is asked for here", number);
    Ticket* const ticket = found->second;
    const size_t expected = frame_bytes(ticket->robot);
    const size_t row_bytes =
        static_cast<size_t>(3) * setup_.cameras[static_cast<size_t>(ticket->robot)].width_px;
    if (ticket->rgb.size() != first_row * row_bytes)
      return fmt::format("first_row: found {}, expected {}", first_row,
                         ticket->rgb.size() / row_bytes);
    if (rgb.empty() || rgb.size() % row_bytes != 0 || ticket->rgb.size() + rgb.size() > expected)
      return fmt::format("rgb: found {} bytes, expected whole rows of {} bytes, {} bytes at most",
                         rgb.size(), row_bytes, expected - ticket->rgb.size());
    ticket->rgb.insert(ticket->rgb.end(), rgb.begin(), rgb.end());
    if (ticket->rgb.size() < expected) return std::nullopt;
    ticket->fingerprint = fingerprint;
    ticket->state = State::done;
  }
  changed_.notify_all();
  return std::nullopt;
}

std::shared_ptr<RendererConnection> RemoteRenderer::remove(uint64_t connection,
                                                           const std::string& reason) {
  std::shared_ptr<RendererConnection> gone;
  std::string name;
  {
    const std::lock_guard lock(mutex_);
    const auto found = connected_.find(connection);
    if (found == connected_.end()) return nullptr;
    gone = std::move(found->second.connection);
    name = found->second.name;
    for (size_t robot = 0; robot < last_reason_.size(); ++robot)
      if (found->second.serves[robot]) last_reason_[robot] = fmt::format("'{}': {}", name, reason);
    connected_.erase(found);
    for (auto& [number, ticket] : tickets_)
      if (ticket->connection == connection && ticket->state == State::waiting)
        ticket->state = State::lost;
    if (ended_) name.clear();
  }
  changed_.notify_all();
  if (!name.empty()) tell_fault_(-1, fmt::format("renderer '{}' is lost: {}", name, reason));
  return gone;
}

void RemoteRenderer::detach(uint64_t connection, const std::string& reason) {
  remove(connection, reason);
}

// ---- Frames ----

bool RemoteRenderer::served(int robot) const {
  return std::any_of(connected_.begin(), connected_.end(), [&](const auto& entry) {
    return entry.second.active && entry.second.serves[static_cast<size_t>(robot)];
  });
}

std::optional<uint64_t> RemoteRenderer::choose(int robot) const {
  std::optional<uint64_t> best;
  double least = 1;
  for (const auto& [number, renderer] : connected_) {
    if (!renderer.active || !renderer.serves[static_cast<size_t>(robot)]) continue;
    const double load =
        static_cast<double>(renderer.in_flight) / static_cast<double>(renderer.capacity);
    if (load >= least) continue;
    least = load;
    best = number;
  }
  return best;
}

bool RemoteRenderer::wait_for_rows(Ticket& ticket, const std::string& name, Lock& lock) {
  const auto limit = std::chrono::duration<double>(options_.limit_s);
  if (changed_.wait_for(lock, limit, [&] { return ticket.state != State::waiting; }))
    return ticket.state == State::done;
  lock.unlock();
  const std::string reason =
      fmt::format("frame {} of {} took longer than {} s", ticket.job->frame_index,
                  ticket.job->robot, options_.limit_s);
  if (const auto late = remove(ticket.connection, reason)) late->drop(name + ": " + reason);
  lock.lock();
  // Its last rows may have come in between.
  return ticket.state == State::done;
}

std::optional<Frame> RemoteRenderer::try_once(uint64_t connection, int robot, const FrameJob& job,
                                              Lock& lock) {
  Connected& renderer = connected_.at(connection);
  const std::shared_ptr<RendererConnection> stream = renderer.connection;
  const std::string name = renderer.name;
  const bool check = options_.check_every > 0 && renderer.frames++ % options_.check_every == 0;
  ++renderer.in_flight;
  const uint64_t number = next_number_++;
  Ticket ticket{.connection = connection, .robot = robot, .job = &job};
  tickets_[number] = &ticket;

  lock.unlock();
  const bool sent = stream->send(number, robot, job);
  lock.lock();
  const bool done = sent && wait_for_rows(ticket, name, lock);
  tickets_.erase(number);
  if (const auto found = connected_.find(connection); found != connected_.end())
    --found->second.in_flight;
  changed_.notify_all();
  if (!sent) return render_here(robot, job, lock);
  if (!done) return std::nullopt;

  lock.unlock();
  const RenderCamera& camera = setup_.cameras[static_cast<size_t>(robot)];
  Frame frame{.robot = job.robot,
              .frame_index = job.frame_index,
              .stamp = job.stamp,
              .width_px = camera.width_px,
              .height_px = camera.height_px,
              .rows = job.schedule.rows,
              .rgb = std::move(ticket.rgb)};
  develop_(robot, frame);
  const bool whole = frame.fingerprint == ticket.fingerprint;
  if (!whole) {
    const std::string reason = fmt::format(
        "fingerprint: found {}, expected {} for the pixels of frame {} of {}",
        to_hex(ticket.fingerprint), to_hex(frame.fingerprint), job.frame_index, job.robot);
    remove(connection, reason);
    stream->drop(reason);
  }
  lock.lock();
  if (!whole) return std::nullopt;
  ++rendered_remotely_;
  if (check) compare(frame, robot, job, name, lock);
  return frame;
}

Frame RemoteRenderer::render_here(int robot, const FrameJob& job, Lock& lock) {
  changed_.wait(lock, [&] { return !idle_local_workers_.empty(); });
  const int worker = idle_local_workers_.back();
  idle_local_workers_.pop_back();
  lock.unlock();
  const auto give_back = [&] {
    lock.lock();
    idle_local_workers_.push_back(worker);
    changed_.notify_all();
  };
  try {
    Frame frame = local_.render(robot, job, worker);
    give_back();
    return frame;
  } catch (...) {
    give_back();
    throw;
  }
}

void RemoteRenderer::compare(const Frame& given, int robot, const FrameJob& job,
                             const std::string& name, Lock& lock) {
  const Frame own = render_here(robot, job, lock);
  if (own.rgb == given.rgb) return;
  const auto at =
      std::mismatch(own.rgb.begin(), own.rgb.end(), given.rgb.begin()).first - own.rgb.begin();
  throw InputError(fmt::format(
      "renderer '{}' does not give this server's bits: frame {} of {}, pixel ({}, {}), found {}, "
      "expected {}; frames that it made before may be wrong too, so the run ends here",
      name, job.frame_index, job.robot, at / 3 % given.width_px, at / 3 / given.width_px,
      given.rgb[static_cast<size_t>(at)], own.rgb[static_cast<size_t>(at)]));
}

Frame RemoteRenderer::render(int robot, const FrameJob& job, int) {
  Lock lock(mutex_);
  while (true) {
    if (ended_) throw InputError("the run is over");
    if (const auto connection = choose(robot)) {
      if (auto frame = try_once(*connection, robot, job, lock)) return std::move(*frame);
      continue;
    }
    if (!served(robot)) break;
    changed_.wait(lock);  // All have as much as they can take.
  }
  const std::string reason = last_reason_[static_cast<size_t>(robot)];
  if (options_.policy == RendererPolicy::abort)
    throw InputError(fmt::format("no renderer for frame {} of {} (the last: {})", job.frame_index,
                                 job.robot, reason));
  if (!falling_back_[static_cast<size_t>(robot)]) {
    falling_back_[static_cast<size_t>(robot)] = true;
    lock.unlock();
    tell_fault_(robot, fmt::format("from frame {} of {} on the server renders itself: no renderer "
                                   "(the last: {})",
                                   job.frame_index, job.robot, reason));
    lock.lock();
  }
  return render_here(robot, job, lock);
}

// ---- For the run ----

bool RemoteRenderer::wait_for(size_t renderers, double limit_s,
                              const std::function<bool()>& give_up) const {
  const auto deadline = std::chrono::steady_clock::now() + std::chrono::duration<double>(limit_s);
  while (this->renderers() < renderers) {
    if (give_up() || std::chrono::steady_clock::now() >= deadline) return false;
    Lock lock(mutex_);
    changed_.wait_for(lock, std::chrono::milliseconds(20));
  }
  return true;
}

size_t RemoteRenderer::renderers() const {
  const std::lock_guard lock(mutex_);
  return static_cast<size_t>(std::count_if(connected_.begin(), connected_.end(),
                                           [](const auto& entry) { return entry.second.active; }));
}

uint64_t RemoteRenderer::rendered_remotely() const {
  const std::lock_guard lock(mutex_);
  return rendered_remotely_;
}

void RemoteRenderer::finish(const std::string& reason) {
  std::vector<std::shared_ptr<RendererConnection>> connections;
  {
    const std::lock_guard lock(mutex_);
    ended_ = true;
    for (auto& [number, renderer] : connected_) connections.push_back(renderer.connection);
    for (auto& [number, ticket] : tickets_)
      if (ticket->state == State::waiting) ticket->state = State::lost;
  }
  changed_.notify_all();
  for (const auto& connection : connections) connection->say_goodbye(reason);
}

}  // namespace seam::scheduler
