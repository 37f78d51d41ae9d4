#include "app/import/kinds/ros_data.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "sim_core/base/error.h"

namespace seam::app {
namespace {

int64_t stamp_or_log(const RosMessage::Header& header, int64_t log_ns) {
  return header.stamp_ns != 0 ? header.stamp_ns : log_ns;
}

class BagReader {
 public:
  BagReader(BagData& data, SetDraft& draft, const std::string& bag)
      : data_(data), draft_(draft), kept_(bag) {}

  void take(size_t topic, int64_t log_ns, std::string_view bytes, RosForm form) {
    const BagTopic& of = data_.topics[topic];
    const auto reader = kReaders.find(of.type);
    if (reader == kReaders.end()) return controller(topic, log_ns, bytes, form);
    RosMessage message(bytes, form, of.name);
    (this->*reader->second)(topic, log_ns, message);
  }

 private:
  using Read = void (BagReader::*)(size_t, int64_t, RosMessage&);
  static const std::map<std::string, Read> kReaders;

  // A topic of a type without a reader of its own.
  void controller(size_t topic, int64_t log_ns, std::string_view bytes, RosForm form) {
    if (is_none_.contains(topic)) return;
    auto found = data_.controllers.find(topic);
    if (found == data_.controllers.end()) {
      auto state = controller_of(topic);
      if (!state) {
        is_none_.insert(topic);
        return;
      }
      found = data_.controllers.emplace(topic, BagData::ControllerRows{std::move(*state)}).first;
    }
    auto sample = found->second.state.read(bytes, form, log_ns);
    if (!sample) {
      ++found->second.without;
      return;
    }
    check_joints(topic, sample->names->list.size());
    kept_.take(sizeof(*sample) + 16 * sample->command.size());
    found->second.rows.push_back(std::move(*sample));
  }
  std::optional<ControllerState> controller_of(size_t topic) {
    try {
      return ControllerState::of(data_.topics[topic]);
    } catch (const InputError& error) {
      draft_.warn(fmt::format("topic {} is not read: {}", data_.topics[topic].name, error.what()));
      return std::nullopt;
    }
  }
  void check_joints(size_t topic, size_t count) const {
    constexpr size_t kMostJoints = 1000;
    if (count > kMostJoints)
      throw InputError(fmt::format("{}: a message of {} joints, expected {} at most",
                                   data_.topics[topic].name, count, kMostJoints));
  }
  void add_joints(size_t topic, JointSampleRow row, std::vector<std::string> names) {
    check_joints(topic, std::max(names.size(), row.positions.size()));
    SharedNames& last = names_[topic];
    if (!names.empty()) {
      const SharedNames before = last;
      row.names = share_names(last, std::move(names));
      if (last != before) kept_.take(150 * row.names->list.size());
    }
    kept_.take(sizeof(row) + 8 * (row.positions.size() + row.efforts.size()));
    data_.joints[topic].push_back(std::move(row));
  }

  void joint_state(size_t topic, int64_t log_ns, RosMessage& message) {
    const auto header = message.header();
    auto names = message.texts();
    auto positions = message.reals();
    message.reals();  // Velocities.
    auto efforts = message.reals();
    if (efforts.size() != positions.size()) efforts.clear();
    add_joints(
        topic,
        {log_ns, stamp_or_log(header, log_ns), nullptr, std::move(positions), std::move(efforts)},
        std::move(names));
  }
  void joint_trajectory(size_t topic, int64_t log_ns, RosMessage& message) {
    message.header();
    auto names = message.texts();
    if (message.count(16) == 0) return;
    auto positions = message.reals();
    add_joints(topic, {log_ns, log_ns, nullptr, std::move(positions)}, std::move(names));
  }
  void numbers(size_t topic, int64_t log_ns, RosMessage& message) {
    for (uint32_t left = message.count(12); left > 0; --left) {
      message.text();
      message.number(), message.number();
    }
    message.number();
    add_joints(topic, {log_ns, log_ns, nullptr, message.reals()}, {});
  }
  void one_number(size_t topic, int64_t log_ns, RosMessage& message) {
    add_joints(topic, {log_ns, log_ns, nullptr, {message.real()}}, {});
  }
  void odometry(size_t topic, int64_t log_ns, RosMessage& message) {
    const auto header = message.header();
    check_frame(topic, header);
    message.text();
    data_.odometry[topic].push_back(
        {log_ns, pose_in(message, stamp_or_log(header, log_ns), data_.topics[topic].name)});
  }
  void pose(size_t topic, int64_t log_ns, RosMessage& message) {
    const auto header = message.header();
    check_frame(topic, header);
    data_.poses[topic].push_back(
        {log_ns, pose_in(message, stamp_or_log(header, log_ns), data_.topics[topic].name)});
  }
  // Poses of a topic make one path, in one frame.
  void check_frame(size_t topic, const RosMessage::Header& header) {
    const auto [known, is_new] = data_.frames.try_emplace(topic, header.frame);
    if (known->second != header.frame)
      throw InputError(fmt::format(
          "{}: at {} s: found a pose in frame '{}' where those before are in '{}', expected one "
          "frame",
          data_.topics[topic].name, seconds_text(header.stamp_ns), header.frame, known->second));
  }
  void transform(size_t topic, int64_t log_ns, RosMessage& message) {
    data_.transforms.take_one(message, log_ns, data_.topics[topic].name);
  }
  void transforms(size_t topic, int64_t log_ns, RosMessage& message) {
    data_.transforms.take(message, log_ns, data_.topics[topic].name);
  }
  void twist(size_t topic, int64_t log_ns, RosMessage& message) {
    const Vec3 linear = message.vec3(), angular = message.vec3();
    if (!std::isfinite(linear.x + linear.y + angular.z))
      throw InputError(fmt::format("{}: at {} s: found a velocity that is not finite",
                                   data_.topics[topic].name, seconds_text(log_ns)));
    data_.twists[topic].push_back({log_ns, linear.x, linear.y, angular.z});
  }
  void twist_stamped(size_t topic, int64_t log_ns, RosMessage& message) {
    message.header();
    twist(topic, log_ns, message);
  }
  void camera_info(size_t topic, int64_t, RosMessage& message) {
    if (data_.cameras.contains(topic)) return;
    const auto camera = read_camera_info(message, data_.topics[topic].name, false, draft_);
    if (camera) data_.cameras[topic] = *camera;
  }

  BagData& data_;
  SetDraft& draft_;
  UnpackBudget kept_;                    // Of rows: they outlive the chunk that they came from.
  std::map<size_t, SharedNames> names_;  // By topic, the last.
  std::set<size_t> is_none_;             // Topics that no reader understands.
};

const std::map<std::string, BagReader::Read> BagReader::kReaders = {
    {"sensor_msgs/JointState", &BagReader::joint_state},
    {"trajectory_msgs/JointTrajectory", &BagReader::joint_trajectory},
    {"std_msgs/Float64MultiArray", &BagReader::numbers},
    {"std_msgs/Float64", &BagReader::one_number},
    {"nav_msgs/Odometry", &BagReader::odometry},
    {"geometry_msgs/PoseStamped", &BagReader::pose},
    {"geometry_msgs/PoseWithCovarianceStamped", &BagReader::pose},
    {"geometry_msgs/TransformStamped", &BagReader::transform},
    {"tf/tfMessage", &BagReader::transforms},
    {"tf2_msgs/TFMessage", &BagReader::transforms},
    {"geometry_msgs/Twist", &BagReader::twist},
    {"geometry_msgs/TwistStamped", &BagReader::twist_stamped},
    {"sensor_msgs/CameraInfo", &BagReader::camera_info},
};

}  // namespace

BagData read_bag_data(const std::filesystem::path& bag, SetDraft& draft) {
  BagData data;
  BagReader reader(data, draft, bag.string());
  const auto losses = read_bag(
      bag, data.topics, [&](size_t topic, int64_t log_ns, std::string_view bytes, RosForm form) {
        reader.take(topic, log_ns, bytes, form);
      });
  for (const std::string& loss : losses) draft.warn(loss);
  return data;
}

}  // namespace seam::app
