// How much one source of strangers may unpack to, all that is in it together. A small file must
// neither fill the memory nor keep the processor for long.
#pragma once

#include <cstdint>
#include <string>

#include "sim_core/base/error.h"

namespace seam::app {

class UnpackBudget {
 public:
  static constexpr uint64_t kBytes = uint64_t{1} << 30;

  explicit UnpackBudget(std::string source, uint64_t bytes = kBytes)
      : source_(std::move(source)), whole_(bytes), left_(bytes) {}

  // Throws InputError where more is taken than is left; nothing is allocated before.
  void take(uint64_t bytes) {
    if (bytes > left_)
      throw InputError(fmt::format(
          "{}: unpacks to more than {} MB, expected less in all: a damaged or hostile file, or one "
          "to import in parts",
          source_, whole_ >> 20));
    left_ -= bytes;
  }
  uint64_t left() const { return left_; }

 private:
  std::string source_;
  uint64_t whole_, left_;
};

}  // namespace seam::app
