#include "tools/pages/gated_server.h"

#include <arpa/inet.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <charconv>
#include <utility>

#include "sim_core/system/thread.h"

namespace seam::tools {
namespace {

constexpr int kTick_ms = 250;
constexpr int kMostTicks = 40;  // Ten seconds for a request.
constexpr int kWrite_ms = 5000;

// A request that came as a whole, and the socket for its answer.
class WholeRequest final : public httplib::Stream {
 public:
  WholeRequest(int socket, std::string bytes) : socket_(socket), bytes_(std::move(bytes)) {}

  bool is_readable() const override { return at_ < bytes_.size(); }
  bool is_writable() const override {
    pollfd ready{socket_, POLLOUT, 0};
    return ::poll(&ready, 1, kWrite_ms) == 1 && (ready.revents & POLLOUT) != 0;
  }
  ssize_t read(char* place, size_t size) override {
    const size_t taken = bytes_.copy(place, size, at_);
    at_ += taken;
    return static_cast<ssize_t>(taken);
  }
  ssize_t write(const char* bytes, size_t size) override {
    if (!is_writable()) return -1;
    return ::send(socket_, bytes, size, MSG_NOSIGNAL | MSG_DONTWAIT);
  }
  void get_remote_ip_and_port(std::string& ip, int& port) const override {
    address_by(::getpeername, ip, port);
  }
  void get_local_ip_and_port(std::string& ip, int& port) const override {
    address_by(::getsockname, ip, port);
  }
  socket_t socket() const override { return socket_; }

 private:
  template <typename Ask>
  void address_by(Ask ask, std::string& ip, int& port) const {
    sockaddr_in address{};
    socklen_t size = sizeof address;
    char text[INET_ADDRSTRLEN] = {};
    if (ask(socket_, reinterpret_cast<sockaddr*>(&address), &size) != 0) return;
    ip = ::inet_ntop(AF_INET, &address.sin_addr, text, sizeof text) == nullptr ? "" : text;
    port = ntohs(address.sin_port);
  }

  int socket_;
  std::string bytes_;
  size_t at_ = 0;
};

// httplib gives each connection to a queue of tasks: here the task only hands it on.
class NoQueue final : public httplib::TaskQueue {
 public:
  void enqueue(std::function<void()> task) override { task(); }
  void shutdown() override {}
};

std::string lower_case(std::string_view text) {
  std::string lower(text);
  for (char& c : lower) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return lower;
}

// Whether a head asks for several parts, of which httplib would put each into the answer: a
// thousand times the whole file, too, and before anybody looks at the token.
bool asks_for_parts(std::string_view head) {
  constexpr std::string_view kName = "\nrange:";
  const std::string lower = lower_case(head);
  for (size_t at = lower.find(kName); at != std::string::npos; at = lower.find(kName, at + 1)) {
    const size_t comma = lower.find(',', at);
    if (comma < lower.find('\n', at + 1)) return true;
  }
  return false;
}

constexpr std::string_view kNoParts =
    "HTTP/1.1 416 Range Not Satisfiable\r\nConnection: close\r\nContent-Length: 0\r\n\r\n";

// What a head says of the size of its body; 0 where it says nothing that is a size.
size_t content_length_of(std::string_view head) {
  constexpr std::string_view kName = "content-length:";
  const std::string lower = lower_case(head);
  const size_t at = lower.find(kName);
  if (at == std::string::npos) return 0;
  const size_t digits = lower.find_first_not_of(' ', at + kName.size());
  size_t length = 0;
  if (digits != std::string::npos)
    std::from_chars(lower.data() + digits, lower.data() + lower.size(), length);
  return length;
}

void drop(int& socket) {
  ::close(std::exchange(socket, -1));
}

}  // namespace

GatedServer::GatedServer(int threads, MostBody most_body) : most_body_(std::move(most_body)) {
  new_task_queue = [] { return new NoQueue; };
  // httplib's own options let another server of the same user listen on the same port.
  set_socket_options([](socket_t socket) {
    const int on = 1;
    ::setsockopt(socket, SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
  });
  // A thread that the system refuses ends the constructor: those that run are asked to end.
  try {
    threads_.push_back(start_thread([this] { watch(); }));
    for (int i = 0; i < threads; ++i) threads_.push_back(start_thread([this] { answer(); }));
  } catch (...) {
    const std::lock_guard lock(mutex_);
    ending_ = true;
    queued_.notify_all();
    wake_.ring();
    throw;
  }
}

void GatedServer::lengthen_queue() {
  ::listen(svr_sock_, static_cast<int>(kMostWaiting));
}

GatedServer::~GatedServer() {
  {
    const std::lock_guard lock(mutex_);
    ending_ = true;
  }
  queued_.notify_all();
  wake_.ring();
  threads_.clear();  // Joins them.
  for (Connection& connection : waiting_) drop(connection.socket);
  for (Connection& connection : whole_) drop(connection.socket);
  for (int& socket : taken_) drop(socket);
}

bool GatedServer::process_and_close_socket(socket_t socket) {
  {
    const std::lock_guard lock(mutex_);
    taken_.push_back(socket);
  }
  wake_.ring();
  return true;
}

void GatedServer::watch() {
  std::vector<pollfd> ready;
  while (true) {
    {
      const std::lock_guard lock(mutex_);
      if (ending_) return;
      for (const int socket : std::exchange(taken_, {}))
        waiting_.push_back({.socket = socket, .bytes = {}});
    }
    // Who has waited longest makes room, so that a whole request of somebody new is read.
    while (waiting_.size() > kMostWaiting) {
      drop(waiting_.front().socket);
      waiting_.pop_front();
    }
    ready.assign(1, {wake_.descriptor(), POLLIN, 0});
    for (const Connection& connection : waiting_) ready.push_back({connection.socket, POLLIN, 0});
    const int count = ::poll(ready.data(), ready.size(), kTick_ms);
    if (ready[0].revents != 0) wake_.clear();
    for (size_t i = 0; i < waiting_.size(); ++i) {
      Connection& connection = waiting_[i];
      if (ready[i + 1].revents != 0) {
        read_from(connection);
      } else if (count == 0 && ++connection.ticks > kMostTicks) {
        drop(connection.socket);
      }
    }
    std::erase_if(waiting_, [](const Connection& connection) { return connection.socket < 0; });
  }
}

void GatedServer::read_from(Connection& connection) {
  char bytes[65536];
  const ssize_t size = ::recv(connection.socket, bytes, sizeof bytes, MSG_DONTWAIT);
  if (size < 0 && (errno == EAGAIN || errno == EINTR)) return;
  if (size > 0) connection.bytes.append(bytes, static_cast<size_t>(size));
  if (size <= 0) return drop(connection.socket);
  if (connection.whole > 0) connection.ticks = 0;  // A body comes in many pieces.
  if (connection.whole == 0) connection.whole = size_of_whole(connection.bytes);
  const size_t most = connection.whole == 0 ? kMostHeadBytes : connection.whole;
  if (connection.bytes.size() > most) return drop(connection.socket);
  if (connection.whole == 0 || connection.bytes.size() < connection.whole) return;
  const std::lock_guard lock(mutex_);
  if (whole_.size() >= kMostQueued) return drop(connection.socket);
  whole_.push_back(
      {.socket = std::exchange(connection.socket, -1), .bytes = std::move(connection.bytes)});
  queued_.notify_one();
}

size_t GatedServer::size_of_whole(const std::string& bytes) const {
  const size_t end = bytes.find("\r\n\r\n");
  if (end == std::string::npos || end > kMostHeadBytes) return 0;
  const std::string_view head(bytes.data(), end);
  const size_t without_body = bytes.size();  // What has come is all that is read.
  if (!most_body_) return without_body;
  const size_t length = content_length_of(head);
  return length > most_body_(head) ? without_body : end + 4 + length;
}

void GatedServer::answer() {
  while (true) {
    Connection connection;
    {
      std::unique_lock lock(mutex_);
      queued_.wait(lock, [&] { return ending_ || !whole_.empty(); });
      if (ending_) return;
      connection = std::move(whole_.front());
      whole_.pop_front();
    }
    const std::string_view bytes = connection.bytes;
    const bool refused = asks_for_parts(bytes.substr(0, bytes.find("\r\n\r\n")));
    WholeRequest request(connection.socket, std::move(connection.bytes));
    bool closed = false;
    // One request a connection: the next one would wait in this thread.
    if (refused) {
      request.write(kNoParts.data(), kNoParts.size());
    } else {
      process_request(request, /*close_connection=*/true, closed, nullptr);
    }
    ::shutdown(connection.socket, SHUT_WR);
    drop(connection.socket);
  }
}

}  // namespace seam::tools
