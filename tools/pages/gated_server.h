// An HTTP server whose answers do not wait for the slow: a connection takes one of the few threads
// that answer only when its whole request is there, with its body where one of that size is taken.
#pragma once

#include <httplib.h>

#include <condition_variable>
#include <deque>
#include <functional>
#include <mutex>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "scheduler/listen/wake.h"

namespace seam::tools {

class GatedServer : public httplib::Server {
 public:
  // How many bytes of body a request with this head may have; 0: none is waited for.
  using MostBody = std::function<size_t(std::string_view head)>;
  static constexpr int kUsualThreads = 8;  // A browser asks for about six things at once.

  // Throws InputError where the system grants no threads or descriptors.
  explicit GatedServer(int threads = kUsualThreads, MostBody most_body = {});
  ~GatedServer() override;

  // After a port is bound: so many connections may wait until they are taken, in place of
  // httplib's 5.
  void lengthen_queue();

  static constexpr size_t kMostWaiting = 256;  // Connections without a whole request.
  static constexpr size_t kMostQueued = 256;   // Whole requests.
  static constexpr size_t kMostHeadBytes = 16384;

 private:
  struct Connection {
    int socket = -1;
    std::string bytes;  // What came so far.
    size_t whole = 0;   // With head and body; 0: its head is not there yet.
    int ticks = 0;      // How long it has been waiting.
  };

  // On httplib's thread, which takes connections.
  bool process_and_close_socket(socket_t socket) override;
  void watch();  // On a thread of its own: reads requests until they are whole.
  void read_from(Connection& connection);
  void answer();  // On each thread that answers.

  size_t size_of_whole(const std::string& bytes) const;  // 0: the head is not there yet.

  const MostBody most_body_;
  const scheduler::Wake wake_;
  std::mutex mutex_;
  std::condition_variable queued_;
  std::vector<int> taken_;        // New connections, for the thread that watches.
  std::deque<Connection> whole_;  // For the threads that answer.
  bool ending_ = false;
  std::deque<Connection> waiting_;  // Of the thread that watches; the oldest first.
  std::vector<std::jthread> threads_;
};

}  // namespace seam::tools
