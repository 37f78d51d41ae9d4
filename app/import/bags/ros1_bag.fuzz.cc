// Whatever a bag of ROS 1 holds, reading it and all fields of its messages ends well or in an
// InputError.
#include "app/import/bags/ros_bag.h"
#include "sim_core/base/error.h"

using namespace seam::app;

namespace {

// Fields of all sorts, as long as the message has bytes.
void read_fields(std::string_view bytes, RosForm form) {
  try {
    RosMessage message(bytes, form, "message");
    while (true) {
      message.header();
      message.texts();
      message.reals();
      message.vec3();
      message.quaternion();
    }
  } catch (const seam::InputError&) {
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  const std::string bytes(reinterpret_cast<const char*>(data), size);
  read_fields(bytes, RosForm::cdr);
  std::vector<BagTopic> topics;
  try {
    seam::app::UnpackBudget budget("input");
    read_ros1_bag(
        seam::mcap::MemoryInput(bytes, "input"), topics,
        [](size_t, int64_t, std::string_view message, RosForm form) { read_fields(message, form); },
        budget);
  } catch (const seam::InputError&) {
  }
  return 0;
}
