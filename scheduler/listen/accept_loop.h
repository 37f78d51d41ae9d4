// Takes connections on a thread of its own: counts them, refuses those beyond the limits with a
// word that the client can read, lives through a lack of descriptors and memory, and opens a
// listener again that died.
#pragma once

#include <atomic>
#include <functional>
#include <string>
#include <thread>
#include <vector>

#include "scheduler/listen/connection_count.h"
#include "scheduler/listen/listening_socket.h"
#include "scheduler/listen/wake.h"

namespace seam::scheduler {

// What is spoken on a connection, so that a refusal can be in its words.
enum class Spoken { http2, tls, line };

struct Endpoint {
  std::string address;
  Spoken spoken = Spoken::http2;
  // Takes over the descriptor of a connection. On the loop's thread.
  std::function<void(int listener, int connection)> take;
};

class AcceptLoop {
 public:
  // Something that a person should know; on the loop's thread.
  using Report = std::function<void(const std::string&)>;

  // Listens when it returns; throws InputError.
  AcceptLoop(std::vector<Endpoint> endpoints, ConnectionLimits limits, Report report);
  ~AcceptLoop();
  AcceptLoop(const AcceptLoop&) = delete;
  AcceptLoop& operator=(const AcceptLoop&) = delete;

  // As asked for, with the ports that were given.
  std::vector<std::string> addresses() const;
  // Connections are taken from now on.
  void start();

 private:
  using Clock = ConnectionCount::Clock;
  struct Place {
    Endpoint endpoint;
    std::string address;  // With its port.
    std::vector<ListeningSocket> sockets;
  };

  void run();
  void wait() const;
  void accept_all(const Place& place, const ListeningSocket& listener);
  void take(const Place& place, const ListeningSocket& listener, int connection);
  void refuse(const Place& place, int connection, const std::string& why);
  // There are no descriptors for what waits: it is refused by one that was kept for this.
  bool refuse_with_a_spare(const Place& place, const ListeningSocket& listener);
  void keep_spare();
  void watch(Place& place);
  void report_refusals();

  std::vector<Place> places_;
  ConnectionCount count_;
  Report report_;
  Wake wake_;               // Once the loop is to end.
  std::vector<int> spare_;  // Descriptors for refusals when there are no others.
  size_t refused_ = 0;
  std::string refused_why_;   // The last.
  std::vector<int> parting_;  // Refused; their last words are on the way.
  std::atomic<bool> ending_ = false;
  std::jthread thread_;
};

}  // namespace seam::scheduler
