#include "app/import/tracks/imu_bag.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>
#include <map>

#include "app/import/bags/ros_bag.h"
#include "app/import/draft/checks.h"
#include "sim_core/base/error.h"

namespace seam::app {
namespace {

constexpr const char* kType = "sensor_msgs/Imu";
constexpr size_t kCovariance = 9;

struct Readings {
  ImuBag bag;
  // By sensor: whether a message had it, and whether one had not.
  std::array<bool, 2> has{}, lacks{};
};

// orientation, angular_velocity and linear_acceleration, each with its covariance, whose first
// element is -1 where the driver does not have it.
void take(RosMessage& message, int64_t log_ns, Readings& to) {
  const int64_t stamp_ns = message.header().stamp_ns;
  message.quaternion();
  message.skip_reals(kCovariance);
  const int64_t at_ns = stamp_ns != 0 ? stamp_ns : log_ns;
  const bool again = !to.bag.ns.empty() && to.bag.ns.back() == at_ns;
  if (!again) to.bag.ns.push_back(at_ns);
  for (size_t sensor = 0; sensor < 2; ++sensor) {
    const Vec3 read = message.vec3();
    const bool has = message.real() != -1;
    message.skip_reals(kCovariance - 1);
    (has ? to.has : to.lacks)[sensor] = true;
    if (again) continue;
    for (int axis = 0; axis < 3; ++axis) {
      if (!std::isfinite(read[axis]))
        throw InputError(fmt::format("{}: at {} s: found a reading that is not finite",
                                     to.bag.topic, seconds_text(at_ns)));
      to.bag.values[3 * sensor + static_cast<size_t>(axis)].push_back(read[axis]);
    }
  }
}

}  // namespace

bool is_ros_bag(const std::filesystem::path& source) {
  const std::string ending = source.extension().string();
  return ending == ".bag" || ending == ".mcap" || std::filesystem::is_directory(source);
}

ImuBag read_imu_bag(const std::filesystem::path& bag, const ImportRequest& request,
                    SetDraft& draft) {
  std::vector<BagTopic> topics;
  std::map<size_t, Readings> found;
  UnpackBudget kept(bag.string());
  const std::string wanted = request.name_of("imu");
  const auto warnings = read_bag(
      bag, topics, [&](size_t topic, int64_t log_ns, std::string_view bytes, RosForm form) {
        const BagTopic& of = topics[topic];
        if (of.type != kType || (!wanted.empty() && of.name != wanted)) return;
        kept.take(7 * sizeof(double));
        Readings& readings = found[topic];
        readings.bag.topic = of.name;
        RosMessage message(bytes, form, of.name);
        take(message, log_ns, readings);
      });
  for (const std::string& warning : warnings) draft.warn(warning);
  if (found.size() != 1) {
    std::vector<std::string> texts;
    for (const BagTopic& topic : topics)
      texts.push_back(fmt::format("{} ({}, {} messages)", topic.name, topic.type, topic.messages));
    throw InputError(fmt::format(
        "{}: found {} topics of {}{}, expected one: name it with --map imu=TOPIC; the bag has {}",
        bag.string(), found.size(), kType, wanted.empty() ? "" : " called " + wanted,
        fmt::join(texts, "; ")));
  }
  Readings& readings = found.begin()->second;
  for (size_t sensor = 0; sensor < 2; ++sensor) {
    if (readings.has[sensor] && readings.lacks[sensor])
      throw InputError(fmt::format(
          "{}: {}: some messages say that they have no {}, expected all or none", bag.string(),
          readings.bag.topic, sensor == 0 ? "angular velocity" : "linear acceleration"));
    if (readings.has[sensor]) continue;
    for (size_t axis = 3 * sensor; axis < 3 * sensor + 3; ++axis) readings.bag.values[axis].clear();
  }
  if (!readings.has[0] && !readings.has[1])
    throw InputError(fmt::format("{}: {}: all messages say that they have neither sensor",
                                 bag.string(), readings.bag.topic));
  draft.did(fmt::format("readings of {}, by the stamps of its messages", readings.bag.topic));
  return std::move(readings.bag);
}

}  // namespace seam::app
