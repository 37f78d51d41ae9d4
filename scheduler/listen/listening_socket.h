// A socket that listens, and notices when it does no more.
#pragma once

#include <sys/types.h>

#include <string>
#include <vector>

namespace seam::scheduler {

class ListeningSocket {
 public:
  ListeningSocket() = default;
  ~ListeningSocket() { close(); }
  ListeningSocket(ListeningSocket&& other) noexcept;
  ListeningSocket& operator=(ListeningSocket&& other) noexcept;

  int descriptor() const { return descriptor_; }
  // False where somebody closed it or shut it down, or took the name of a Unix socket away.
  bool lives() const;

 private:
  friend std::vector<ListeningSocket> listen_on(const std::string& address, int& port);
  ListeningSocket(int descriptor, std::string path);
  bool is_ours() const;
  bool has_its_name() const;
  void close() noexcept;

  int descriptor_ = -1;
  ino_t inode_ = 0;
  std::string path_;  // Of a Unix socket, else empty.
  dev_t path_device_ = 0;
  ino_t path_inode_ = 0;
};

// Listens on "unix:/path" or on all that "host:port" names; a port of 0 becomes a free one, which
// `port` then is (-1 for a Unix socket). Throws InputError where the address cannot be had.
std::vector<ListeningSocket> listen_on(const std::string& address, int& port);

}  // namespace seam::scheduler
