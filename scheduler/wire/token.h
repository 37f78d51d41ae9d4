// Secrets.
#pragma once

#include <string>

namespace seam::scheduler {

// Compares in a time that does not depend on how far two tokens agree.
inline bool same_token(const std::string& a, const std::string& b) {
  if (a.size() != b.size()) return false;
  unsigned char difference = 0;
  for (size_t i = 0; i < a.size(); ++i)
    difference |= static_cast<unsigned char>(a[i]) ^ static_cast<unsigned char>(b[i]);
  return difference == 0;
}

}  // namespace seam::scheduler
