// A direct line: the messages of a robot's stream on a Unix socket without gRPC, for clients on the
// run's own machine, where most of a turn would be gRPC's. Each message stands behind its length, 4
// bytes little-endian. A length with its highest bit set is the end: gRPC's status code in a byte,
// and its text.
#pragma once

#include <google/protobuf/message_lite.h>

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

namespace seam {

std::string line_frame(const google::protobuf::MessageLite& message);
std::string line_end(int code, std::string_view text);

// What has come on a line, by frames.
class LineFrames {
 public:
  struct Frame {
    std::string_view bytes;  // Valid until the next call.
    bool is_end = false;
    int code = 0;              // Of an end, whose text the bytes are.
    size_t skipped_bytes = 0;  // Of a frame that is too long, whose bytes are left out.
  };
  enum class Received { bytes, nothing, closed };

  // A frame of more than `most_bytes`, up to `most_skipped_bytes`, is skipped as it comes.
  explicit LineFrames(size_t most_bytes, size_t most_skipped_bytes = 0)
      : most_bytes_(most_bytes), most_skipped_bytes_(most_skipped_bytes) {}

  // Takes what the socket has; `flags` are recv's.
  Received receive(int socket, int flags);
  // The next whole frame, or the head of one that is skipped. Throws std::length_error for one that
  // is longer than allowed.
  std::optional<Frame> next();

 private:
  size_t most_bytes_, most_skipped_bytes_;
  size_t to_skip_ = 0;
  std::string buffer_;
  size_t begin_ = 0, end_ = 0;  // What was received and not given out.
};

}  // namespace seam
