// A descriptor that becomes readable when another thread wants this one: what poll can wait for
// beside sockets.
#pragma once

#include <fmt/format.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "sim_core/base/error.h"

namespace seam::scheduler {

class Wake {
 public:
  Wake() : descriptor_(eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)) {
    if (descriptor_ < 0) throw InputError(fmt::format("no event descriptor: {}", strerror(errno)));
  }
  ~Wake() { close(descriptor_); }
  Wake(const Wake&) = delete;
  Wake& operator=(const Wake&) = delete;

  int descriptor() const { return descriptor_; }
  // From any thread.
  void ring() const { eventfd_write(descriptor_, 1); }
  // Not readable any more, until it is rung again.
  void clear() const {
    eventfd_t rung;
    eventfd_read(descriptor_, &rung);
  }

 private:
  int descriptor_;
};

}  // namespace seam::scheduler
