#include "scheduler/listen/refusal.h"

#include "proto/line.h"

namespace seam::scheduler {

std::string http2_refusal(std::string_view why) {
  constexpr char kSettings = 4, kGoAway = 7, kEnhanceYourCalm = 11;
  why = why.substr(0, 200);
  // A frame: length (3 bytes), type, flags, stream (4). All of it is about stream 0.
  std::string words{0, 0, 0, kSettings, 0, 0, 0, 0, 0};
  words += {0, 0, static_cast<char>(8 + why.size()), kGoAway, 0, 0, 0, 0, 0};
  words += {0, 0, 0, 0, 0, 0, 0, kEnhanceYourCalm};  // No stream was served; the error.
  words += why;
  return words;
}

std::string tls_refusal() {
  constexpr char kAlert = 21, kFatal = 2, kAccessDenied = 49;
  return {kAlert, 3, 3, 0, 2, kFatal, kAccessDenied};
}

std::string line_refusal(std::string_view why) {
  constexpr int kUnavailable = 14;
  return line_end(kUnavailable, why);
}

}  // namespace seam::scheduler
