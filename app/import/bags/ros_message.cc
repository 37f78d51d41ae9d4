#include "app/import/bags/ros_message.h"

#include <bit>

#include "sim_core/base/error.h"

namespace seam::app {

RosMessage::RosMessage(std::string_view bytes, RosForm form, std::string name)
    : bytes_(bytes), form_(form), name_(std::move(name)) {
  if (form_ == RosForm::ros1) return;
  // The representation's identifier and options stand before the first field.
  if (bytes_.size() < 4) fail();
  big_ = (static_cast<uint8_t>(bytes_[1]) & 1) == 0;
  if (bytes_[0] != 0 || static_cast<uint8_t>(bytes_[1]) > 1)
    throw InputError(fmt::format("{}: found CDR of another kind than plain", name_));
  at_ = origin_ = 4;
}

void RosMessage::fail() const {
  throw InputError(fmt::format("{}: the message ends early: damaged, or of another type", name_));
}

std::string_view RosMessage::raw(size_t size, size_t alignment) {
  if (form_ == RosForm::cdr) at_ += (alignment - (at_ - origin_) % alignment) % alignment;
  if (at_ > bytes_.size() || bytes_.size() - at_ < size) fail();
  const std::string_view bytes = bytes_.substr(at_, size);
  at_ += size;
  return bytes;
}

uint64_t RosMessage::word(size_t size) {
  const std::string_view bytes = raw(size, size);
  uint64_t bits = 0;
  for (size_t i = 0; i < size; ++i)
    bits = bits << 8 | static_cast<uint8_t>(bytes[big_ ? i : size - 1 - i]);
  return bits;
}

uint32_t RosMessage::number() {
  return static_cast<uint32_t>(word(4));
}

double RosMessage::real() {
  return std::bit_cast<double>(word(8));
}

uint8_t RosMessage::byte() {
  return static_cast<uint8_t>(raw(1, 1)[0]);
}

std::string_view RosMessage::bytes() {
  const uint32_t size = count(1);
  return raw(size, 1);
}

uint32_t RosMessage::count(size_t least_bytes) {
  const uint32_t count = number();
  if (count > (bytes_.size() - at_) / least_bytes) fail();
  return count;
}

std::string RosMessage::text() {
  const uint32_t size = count(1);
  std::string text(raw(size, 1));
  // CDR counts the NUL at the end.
  if (form_ == RosForm::cdr && !text.empty() && text.back() == '\0') text.pop_back();
  return text;
}

std::vector<double> RosMessage::reals() {
  std::vector<double> values(count(8));
  for (double& value : values) value = real();
  return values;
}

std::vector<std::string> RosMessage::texts() {
  std::vector<std::string> values(count(4));
  for (std::string& value : values) value = text();
  return values;
}

void RosMessage::skip_reals(size_t count) {
  for (size_t i = 0; i < count; ++i) real();
}

Vec3 RosMessage::vec3() {
  const double x = real(), y = real(), z = real();
  return {x, y, z};
}

std::array<double, 4> RosMessage::quaternion() {
  const double x = real(), y = real(), z = real(), w = real();
  return {w, x, y, z};
}

int64_t RosMessage::time_ns() {
  const auto seconds = static_cast<int32_t>(number());
  return int64_t{seconds} * 1'000'000'000 + number();
}

RosMessage::Header RosMessage::header() {
  if (form_ == RosForm::ros1) number();  // seq.
  const int64_t stamp_ns = time_ns();
  return {stamp_ns, text()};
}

}  // namespace seam::app
