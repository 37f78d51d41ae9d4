#include "proto/line.h"

#include <sys/socket.h>

#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <stdexcept>

namespace seam {
namespace {

constexpr size_t kHeadBytes = 4;
constexpr uint32_t kEnd = 1u << 31;
constexpr size_t kReadBytes = 64 << 10;

void put_head(uint32_t head, char* bytes) {
  for (size_t i = 0; i < kHeadBytes; ++i) bytes[i] = static_cast<char>(head >> (8 * i));
}

uint32_t head_of(const char* bytes) {
  uint32_t head = 0;
  for (size_t i = 0; i < kHeadBytes; ++i)
    head |= static_cast<uint32_t>(static_cast<unsigned char>(bytes[i])) << (8 * i);
  return head;
}

}  // namespace

std::string line_frame(const google::protobuf::MessageLite& message) {
  const size_t size = message.ByteSizeLong();
  std::string frame(kHeadBytes + size, '\0');
  put_head(static_cast<uint32_t>(size), frame.data());
  message.SerializeWithCachedSizesToArray(reinterpret_cast<uint8_t*>(frame.data() + kHeadBytes));
  return frame;
}

std::string line_end(int code, std::string_view text) {
  std::string frame(kHeadBytes, '\0');
  put_head(kEnd | static_cast<uint32_t>(text.size() + 1), frame.data());
  frame += static_cast<char>(code);
  return frame.append(text);
}

LineFrames::Received LineFrames::receive(int socket, int flags) {
  if (begin_ == end_) begin_ = end_ = 0;
  // A long message is read in one piece where its length is known.
  size_t wanted = kReadBytes;
  if (end_ - begin_ >= kHeadBytes)
    wanted = std::clamp<size_t>((head_of(&buffer_[begin_]) & ~kEnd) + kHeadBytes, wanted,
                                std::max(wanted, most_bytes_ + kHeadBytes));
  if (buffer_.size() < end_ + kReadBytes || buffer_.size() < begin_ + wanted) {
    buffer_.erase(0, begin_);
    end_ -= begin_;
    begin_ = 0;
    buffer_.resize(std::max(end_ + kReadBytes, wanted));
  }
  ssize_t got;
  do {
    got = recv(socket, &buffer_[end_], buffer_.size() - end_, flags);
  } while (got < 0 && errno == EINTR);
  if (got < 0 && (errno == EAGAIN || errno == EWOULDBLOCK)) return Received::nothing;
  if (got <= 0) return Received::closed;
  end_ += static_cast<size_t>(got);
  return Received::bytes;
}

std::optional<LineFrames::Frame> LineFrames::next() {
  const size_t skipped = std::min(to_skip_, end_ - begin_);
  begin_ += skipped;
  to_skip_ -= skipped;
  if (to_skip_ > 0 || end_ - begin_ < kHeadBytes) return std::nullopt;
  const uint32_t head = head_of(&buffer_[begin_]);
  const size_t size = head & ~kEnd;
  if (size > most_bytes_ && size <= most_skipped_bytes_ && (head & kEnd) == 0) {
    begin_ += kHeadBytes;
    to_skip_ = size;
    return Frame{.skipped_bytes = size};
  }
  if (size > most_bytes_ || (head == kEnd))
    throw std::length_error("found a message of " + std::to_string(size) +
                            " bytes, expected at most " + std::to_string(most_bytes_));
  if (end_ - begin_ < kHeadBytes + size) return std::nullopt;
  Frame frame{std::string_view(buffer_).substr(begin_ + kHeadBytes, size), (head & kEnd) != 0};
  begin_ += kHeadBytes + size;
  if (!frame.is_end) return frame;
  frame.code = static_cast<unsigned char>(frame.bytes.front());
  frame.bytes.remove_prefix(1);
  return frame;
}

}  // namespace seam
