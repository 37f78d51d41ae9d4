#include "scheduler/server/direct_lines.h"

#include <poll.h>

#include <utility>

#include "scheduler/listen/connection_count.h"
#include "sim_core/system/thread.h"

namespace seam::scheduler {

namespace {

constexpr std::chrono::seconds kHello{10}, kParting{1};
constexpr int kLook_ms = 200;

}  // namespace

DirectLines::DirectLines(const SessionParts& parts)
    : parts_(parts), thread_(start_thread([this] { run(); })) {}

DirectLines::~DirectLines() {
  {
    const std::lock_guard lock(mutex_);
    ending_ = true;
  }
  wake_.ring();
}

void DirectLines::add(int socket) {
  {
    const std::lock_guard lock(mutex_);
    new_sockets_.push_back(socket);
  }
  wake_.ring();
}

void DirectLines::run() {
  std::optional<Clock::time_point> parting;
  while (!parting || (!lines_.empty() && Clock::now() - *parting < kParting)) {
    take_new();
    serve_those_that_want();
    let_go();
    const std::lock_guard lock(mutex_);
    if (ending_ && !parting) parting = Clock::now();
  }
}

void DirectLines::take_new() {
  const std::lock_guard lock(mutex_);
  for (const int socket : std::exchange(new_sockets_, {}))
    lines_.push_back(
        {std::make_shared<DirectLine>(parts_, peer_of_socket(socket), socket), Clock::now()});
}

void DirectLines::serve_those_that_want() {
  std::vector<pollfd> all{{wake_.descriptor(), POLLIN, 0}};
  for (const Watched& watched : lines_) {
    // A robot's decisions are left to who waits for them; its end is noticed here, too.
    short events = POLLRDHUP;
    if (!watched.line->greeted()) events |= POLLIN;
    if (watched.line->wants_to_write()) events |= POLLOUT;
    all.push_back({watched.line->descriptor(), events, 0});
  }
  ::poll(all.data(), all.size(), kLook_ms);
  wake_.clear();
  for (size_t i = 0; i < lines_.size(); ++i) {
    DirectLine& line = *lines_[i].line;
    if (all[i + 1].revents != 0) line.serve();
    if (!line.greeted() && Clock::now() - lines_[i].since > kHello)
      line.close_down({grpc::StatusCode::DEADLINE_EXCEEDED, "no hello within 10 s"});
  }
}

void DirectLines::let_go() {
  std::erase_if(lines_, [](const Watched& watched) { return watched.line->is_over(); });
}

}  // namespace seam::scheduler
