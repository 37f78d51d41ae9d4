#include "scheduler/listen/accept_loop.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <utility>

#include "scheduler/listen/listen_address.h"
#include "scheduler/listen/refusal.h"
#include "sim_core/base/error.h"
#include "sim_core/system/thread.h"

namespace seam::scheduler {
namespace {

// So often listeners are looked at, refusals reported, and those who were refused hung up on.
constexpr std::chrono::milliseconds kWatch{500};
// Of one listener at a time, so that others have their turn.
constexpr int kAcceptedAtOnce = 64;
constexpr size_t kMostParting = 256;

// Descriptors kept for refusals: another thread may take one that was just given up, and keep it.
constexpr size_t kSpare = 8;

std::string with_port(const std::string& address, int port) {
  if (port < 0) return address;
  return address.substr(0, address.rfind(':') + 1) + std::to_string(port);
}

std::string refusal_in(Spoken spoken, const std::string& why) {
  if (spoken == Spoken::tls) return tls_refusal();
  return spoken == Spoken::line ? line_refusal(why) : http2_refusal(why);
}

bool lacks_resources(int error) {
  return error == EMFILE || error == ENFILE || error == ENOBUFS || error == ENOMEM;
}

}  // namespace

AcceptLoop::AcceptLoop(std::vector<Endpoint> endpoints, ConnectionLimits limits, Report report)
    : count_(limits), report_(std::move(report)) {
  for (Endpoint& endpoint : endpoints) {
    int port = -1;
    std::vector<ListeningSocket> sockets = listen_on(endpoint.address, port);
    const std::string address = with_port(endpoint.address, port);
    places_.push_back({std::move(endpoint), address, std::move(sockets)});
  }
  keep_spare();
}

AcceptLoop::~AcceptLoop() {
  ending_ = true;
  wake_.ring();
  if (thread_.joinable()) thread_.join();
  for (const int connection : parting_) close(connection);
  for (const int spare : spare_) close(spare);
}

std::vector<std::string> AcceptLoop::addresses() const {
  std::vector<std::string> all;
  for (const Place& place : places_) all.push_back(place.address);
  return all;
}

void AcceptLoop::start() {
  thread_ = start_thread([this] { run(); });
}

void AcceptLoop::run() {
  Clock::time_point watched = Clock::now();
  while (!ending_) {
    // Whatever fails for want of memory is tried again; a listener does not end by it.
    try {
      wait();
      for (const Place& place : places_)
        for (const ListeningSocket& listener : place.sockets) accept_all(place, listener);
      if (Clock::now() - watched < kWatch) continue;
      watched = Clock::now();
      for (Place& place : places_) watch(place);
      report_refusals();
      for (const int connection : std::exchange(parting_, {})) close(connection);
    } catch (const std::exception&) {
      std::this_thread::sleep_for(kWatch);
    }
  }
}

void AcceptLoop::wait() const {
  std::vector<pollfd> all{{.fd = wake_.descriptor(), .events = POLLIN, .revents = 0}};
  for (const Place& place : places_)
    for (const ListeningSocket& listener : place.sockets)
      if (listener.lives()) all.push_back({listener.descriptor(), POLLIN, 0});
  poll(all.data(), all.size(), static_cast<int>(kWatch.count()));
}

void AcceptLoop::accept_all(const Place& place, const ListeningSocket& listener) {
  for (int i = 0; i < kAcceptedAtOnce; ++i) {
    const int connection =
        accept4(listener.descriptor(), nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC);
    if (connection >= 0) {
      take(place, listener, connection);
    } else if (lacks_resources(errno)) {
      if (!refuse_with_a_spare(place, listener)) return;
    } else if (errno != ECONNABORTED && errno != EINTR) {
      return;  // None waits, or the listener is dead: `watch` sees to it.
    }
  }
}

void AcceptLoop::take(const Place& place, const ListeningSocket& listener, int connection) {
  const std::string why = count_.refusal(peer_of_socket(connection), connection);
  if (!why.empty()) return refuse(place, connection, why);
  const int yes = 1;  // Small messages in lockstep; does nothing on Unix sockets.
  setsockopt(connection, IPPROTO_TCP, TCP_NODELAY, &yes, sizeof yes);
  place.endpoint.take(listener.descriptor(), connection);
}

void AcceptLoop::refuse(const Place& place, int connection, const std::string& why) {
  ++refused_;
  refused_why_ = why;
  const std::string words = refusal_in(place.endpoint.spoken, why);
  [[maybe_unused]] const ssize_t sent =
      send(connection, words.data(), words.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
  // Hanging up at once would take the words back where the client has sent something meanwhile.
  if (parting_.size() < kMostParting && spare_.size() == kSpare) {
    shutdown(connection, SHUT_WR);
    parting_.push_back(connection);
  } else {
    close(connection);
  }
}

void AcceptLoop::keep_spare() {
  while (spare_.size() < kSpare) {
    const int spare = open("/dev/null", O_RDONLY | O_CLOEXEC);
    if (spare < 0) return;
    spare_.push_back(spare);
  }
}

bool AcceptLoop::refuse_with_a_spare(const Place& place, const ListeningSocket& listener) {
  for (const int connection : std::exchange(parting_, {})) close(connection);
  if (!spare_.empty()) {
    close(spare_.back());
    spare_.pop_back();
  }
  const int connection = accept4(listener.descriptor(), nullptr, nullptr, SOCK_CLOEXEC);
  if (connection >= 0) refuse(place, connection, "the server has no descriptors left");
  keep_spare();
  // What waits makes poll return at once; it is not asked for all the time.
  if (connection < 0) std::this_thread::sleep_for(std::chrono::milliseconds(20));
  return connection >= 0;
}

void AcceptLoop::watch(Place& place) {
  keep_spare();
  const bool live = !place.sockets.empty() &&
                    std::all_of(place.sockets.begin(), place.sockets.end(),
                                [](const ListeningSocket& socket) { return socket.lives(); });
  if (live) return;
  place.sockets.clear();
  int port = -1;
  try {
    place.sockets = listen_on(place.address, port);
    report_(fmt::format("{}: the listener was dead, another was opened", place.address));
  } catch (const InputError&) {
    // Tried again with the next look.
  }
}

void AcceptLoop::report_refusals() {
  if (refused_ == 0) return;
  report_(
      fmt::format("refused {} connection{}: {}", refused_, refused_ == 1 ? "" : "s", refused_why_));
  refused_ = 0;
}

}  // namespace seam::scheduler
