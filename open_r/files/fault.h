// What ends a program or a build: said to its user, as "what was found, what was expected, what to
// do".
#pragma once

#include <stdexcept>

namespace seam::open_r {

class Fault : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

}  // namespace seam::open_r
