// Messages of ROS as bytes: CDR with its alignment (ROS 2) or the plain form of ROS 1, one after
// another field. Never reads beyond the bytes: throws InputError instead.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "sim_core/base/pose.h"

namespace seam::app {

enum class RosForm { cdr, ros1 };

class RosMessage {
 public:
  // `name` is what errors call the message.
  RosMessage(std::string_view bytes, RosForm form, std::string name);

  uint64_t word(size_t size);  // The bits of a number of 1, 2, 4 or 8 bytes.
  uint32_t number();           // uint32 and int32.
  double real();               // float64.
  uint8_t byte();              // uint8 and bool.
  std::string_view bytes();    // A list of uint8.
  std::string text();
  std::vector<double> reals();  // A list.
  std::vector<std::string> texts();
  void skip_reals(size_t count);
  Vec3 vec3();
  std::array<double, 4> quaternion();  // To w, x, y, z.

  struct Header {
    int64_t stamp_ns = 0;
    std::string frame;
  };
  Header header();
  int64_t time_ns();  // A time or duration.
  // The length of a list whose elements take `least_bytes` or more each.
  uint32_t count(size_t least_bytes);
  RosForm form() const { return form_; }

 private:
  std::string_view raw(size_t size, size_t alignment);
  [[noreturn]] void fail() const;

  std::string_view bytes_;
  RosForm form_;
  std::string name_;
  size_t at_ = 0, origin_ = 0;
  bool big_ = false;
};

}  // namespace seam::app
