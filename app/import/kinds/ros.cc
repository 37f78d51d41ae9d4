// `seam import ros`: joints with their commands, walks with theirs, or a camera's calibration, from
// bags of ROS 1 and 2.
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "app/import/bags/ros_bag.h"
#include "app/import/draft/checks.h"
#include "app/import/draft/points_draft.h"
#include "app/import/draft/reversal.h"
#include "app/import/draft/walk_draft.h"
#include "app/import/kinds/kinds.h"
#include "app/import/kinds/ros_data.h"
#include "sim_core/base/error.h"

namespace seam::app {
namespace {

class RosImport {
 public:
  RosImport(const ImportRequest& request, SetDraft& draft)
      : request_(request), draft_(draft), reversal_(request) {}
  void run();

 private:
  std::string topics_text() const;
  // The topic that the map names among these, else the first that `fits`; nothing where none.
  template <typename Found>
  std::optional<size_t> choose(const std::map<size_t, Found>& found, const std::string& quantity,
                               const std::function<bool(const BagTopic&)>& fits) const;
  // Transforms that the user names, or where the bag has no other poses the body's, as topics.
  void take_transforms();
  const PlainCamera* chosen_camera() const;
  bool joints();
  // `known`: of types that are known as a controller's state alone.
  bool controllers(bool known);
  bool walk();
  bool camera();
  bool poses();
  // Rows of one joint, in order of time; `effort_nm` empty: nobody measured torques.
  struct JointRows {
    std::vector<int64_t> times;
    std::vector<double> command, angle, effort_nm;
  };
  void joint_rows(const std::string& name, const std::vector<JointSampleRow>& measured,
                  size_t place, const std::vector<JointSampleRow>& commands, bool with_efforts,
                  measurement::CsvWriter& table, size_t& rows);
  void add_joint(const std::string& name, JointRows& of, measurement::CsvWriter& table,
                 size_t& rows);
  size_t controller_rows(size_t topic, std::set<std::string>& taken, measurement::CsvWriter& table);

  const ImportRequest& request_;
  SetDraft& draft_;
  Reversal reversal_;
  BagData data_;
};

std::string RosImport::topics_text() const {
  std::vector<std::string> texts;
  for (const BagTopic& topic : data_.topics)
    texts.push_back(fmt::format("{} ({}, {} messages)", topic.name, topic.type, topic.messages));
  std::string text = fmt::format("{}", fmt::join(texts, "; "));
  if (const auto moving = data_.transforms.moving(); !moving.empty())
    text += fmt::format("; transforms, of which --map measured=/tf:PARENT:CHILD takes one: {}",
                        fmt::join(moving, ", "));
  return text;
}

template <typename Found>
std::optional<size_t> RosImport::choose(const std::map<size_t, Found>& found,
                                        const std::string& quantity,
                                        const std::function<bool(const BagTopic&)>& fits) const {
  const std::string mapped = request_.name_of(quantity);
  for (const auto& [topic, value] : found) {
    const BagTopic& of = data_.topics[topic];
    if (mapped.empty() ? fits(of) : of.name == mapped) return topic;
  }
  return std::nullopt;
}

bool contains(const std::string& text, const char* part) {
  return text.find(part) != std::string::npos;
}

// Where a joint stands in a message; by the name, or by its place where the message has none.
std::optional<size_t> place_of(const JointSampleRow& row, const std::string& name, size_t place) {
  const std::optional<size_t> at = row.names ? row.names->find(name) : std::optional(place);
  return at && *at < row.positions.size() ? at : std::nullopt;
}

// What is NaN, or 0 in all messages, is a habit of drivers that measure no torque.
bool are_measured(const std::vector<JointSampleRow>& rows) {
  return std::any_of(rows.begin(), rows.end(), [](const JointSampleRow& row) {
    return std::any_of(row.efforts.begin(), row.efforts.end(),
                       [](double effort) { return std::isfinite(effort) && effort != 0; });
  });
}

void RosImport::joint_rows(const std::string& name, const std::vector<JointSampleRow>& measured,
                           size_t place, const std::vector<JointSampleRow>& commands,
                           bool with_efforts, measurement::CsvWriter& table, size_t& rows) {
  JointRows of;
  size_t next = 0;
  std::optional<double> now;
  for (const JointSampleRow& row : measured) {
    for (; next < commands.size() && commands[next].log_ns <= row.log_ns; ++next) {
      if (const auto at = place_of(commands[next], name, place))
        now = commands[next].positions[*at];
    }
    const auto at = place_of(row, name, place);
    if (!now || !at || (!of.times.empty() && row.log_ns == of.times.back())) continue;
    of.times.push_back(row.log_ns);
    of.command.push_back(*now), of.angle.push_back(row.positions[*at]);
    if (with_efforts) of.effort_nm.push_back(row.efforts.empty() ? NAN : row.efforts[*at]);
  }
  add_joint(name, of, table, rows);
}

void RosImport::add_joint(const std::string& name, JointRows& of, measurement::CsvWriter& table,
                          size_t& rows) {
  if (of.times.size() < 3) return;
  const RowPlace where = [&](size_t i) {
    return fmt::format("joint {} at {} s", name, seconds_text(of.times[i]));
  };
  check_times(of.times, where, request_, 2, draft_);
  to_radians(of.command, "command", where, request_, draft_);
  to_radians(of.angle, "position", where, request_, draft_);
  reversal_.apply(name, of.command, of.angle);
  const auto& reversed = request_.reversed;
  // Torques count the way that the angles do.
  if (std::find(reversed.begin(), reversed.end(), name) != reversed.end())
    for (double& effort : of.effort_nm) effort = -effort;
  for (size_t i = 0; i < of.times.size(); ++i, ++rows) {
    std::vector<std::string> cells = {"0", seconds_text(of.times[i]), name, exact(of.command[i]),
                                      exact(of.angle[i])};
    if (!of.effort_nm.empty())
      cells.push_back(std::isfinite(of.effort_nm[i]) ? exact(of.effort_nm[i]) : "");
    table.row(cells);
  }
}

bool RosImport::joints() {
  const auto measured = choose(data_.joints, "measured", [](const BagTopic& topic) {
    return topic.type == "sensor_msgs/JointState" && !contains(topic.name, "command") &&
           !contains(topic.name, "cmd") && !contains(topic.name, "target") &&
           !contains(topic.name, "goal");
  });
  if (!measured) return false;
  const auto command = choose(data_.joints, "command", [&](const BagTopic& topic) {
    return topic.name != data_.topics[*measured].name;
  });
  if (!command) return false;
  const auto& seen = data_.joints[*measured];
  std::vector<std::string> columns = {"run", "time_s", "joint", "command_rad", "measured_rad"};
  const bool with_efforts = are_measured(seen);
  if (with_efforts) columns.emplace_back("effort_nm");
  measurement::CsvWriter table(columns);
  size_t rows = 0;
  // Without names of its own a state has none.
  const std::vector<std::string> names =
      seen.front().names ? seen.front().names->list : std::vector<std::string>();
  for (size_t i = 0; i < names.size(); ++i)
    joint_rows(names[i], seen, i, data_.joints[*command], with_efforts, table, rows);
  if (rows == 0)
    throw InputError(fmt::format("{} and {} have no joint in common while both were recorded",
                                 data_.topics[*measured].name, data_.topics[*command].name));
  reversal_.finish({names.begin(), names.end()}, draft_);
  draft_.kind = "joints";
  draft_.group = "joint";
  draft_.effects = "  ideal_servo: {}\n";
  draft_.add_table("joints", table);
  draft_.did(fmt::format("{} rows: angles of {} under commands of {}, by the times of recording",
                         rows, data_.topics[*measured].name, data_.topics[*command].name));
  if (with_efforts) draft_.did("effort_nm: the efforts of these messages, as torques in N m");
  draft_.could_not_know("how long messages were on their way: a command acts from the next row on");
  if (names.size() > 1 && !data_.joints[*command].front().names)
    draft_.could_not_know(fmt::format(
        "which joint each number of {} is for: it has no names, so they are taken in the order of "
        "{}: {}",
        data_.topics[*command].name, data_.topics[*measured].name, fmt::join(names, ", ")));
  return true;
}

size_t RosImport::controller_rows(size_t topic, std::set<std::string>& taken,
                                  measurement::CsvWriter& table) {
  auto& [state, samples, without] = data_.controllers.at(topic);
  std::stable_sort(samples.begin(), samples.end(),
                   [](const auto& a, const auto& b) { return a.ns < b.ns; });
  std::map<std::string, JointRows> joints;
  size_t no_numbers = 0, rows = 0;
  for (const ControllerState::Sample& sample : samples) {
    for (size_t i = 0; i < sample.command.size(); ++i) {
      JointRows& of = joints[sample.names->list[i]];
      const bool good = std::isfinite(sample.command[i]) && std::isfinite(sample.measured[i]);
      no_numbers += good ? 0 : 1;
      if (!good || (!of.times.empty() && of.times.back() == sample.ns)) continue;
      of.times.push_back(sample.ns);
      of.command.push_back(sample.command[i]), of.angle.push_back(sample.measured[i]);
    }
  }
  const std::string& name = data_.topics[topic].name;
  for (auto& [joint, of] : joints) {
    const size_t before = rows;
    if (taken.contains(joint)) {
      draft_.warn(fmt::format("{} holds joint {} again: left out", name, joint));
    } else {
      add_joint(joint, of, table, rows);
    }
    if (rows > before) taken.insert(joint);
  }
  if (rows == 0) return 0;
  draft_.did(fmt::format("{} rows: {} of {}, by the stamps of its messages", rows,
                         state.fields_text(), name));
  if (without + no_numbers > 0)
    draft_.warn(
        fmt::format("{}: {} messages without command or state and {} rows that are no "
                    "numbers: left out",
                    name, without, no_numbers));
  return rows;
}

bool RosImport::controllers(bool known) {
  const std::string mapped = request_.name_of("measured");
  measurement::CsvWriter table({"run", "time_s", "joint", "command_rad", "measured_rad"});
  std::set<std::string> joints;
  size_t rows = 0;
  for (const auto& [topic, of] : data_.controllers) {
    const bool wanted =
        mapped.empty() ? of.state.is_known() == known : data_.topics[topic].name == mapped;
    if (wanted) rows += controller_rows(topic, joints, table);
  }
  if (rows == 0) return false;
  reversal_.finish(joints, draft_);
  draft_.kind = "joints";
  draft_.group = "joint";
  draft_.effects = "  ideal_servo: {}\n";
  draft_.add_table("joints", table);
  return true;
}

bool RosImport::walk() {
  const auto truth = choose(data_.poses, "measured", [](const BagTopic& topic) {
    return topic.messages >= 4 && !contains(topic.name, "initial") && !contains(topic.name, "goal");
  });
  const auto odometry =
      choose(data_.odometry, truth ? "odometry" : "measured", [](const BagTopic&) { return true; });
  const auto twist = choose(data_.twists, "command", [](const BagTopic& topic) {
    return contains(topic.name, "cmd_vel") || contains(topic.name, "command");
  });
  const auto& measured = odometry && (twist || !truth) && request_.name_of("measured").empty()
                             ? data_.odometry[*odometry]
                         : truth    ? data_.poses[*truth]
                         : odometry ? data_.odometry[*odometry]
                                    : std::vector<PoseRow>{};
  if (measured.empty() || (!twist && !(odometry && truth))) return false;
  const auto laid = [&](const std::vector<PoseRow>& rows, const std::string& name) {
    std::vector<StampedPose> path;
    for (const PoseRow& row : rows) path.push_back(row.pose);
    return planar(path, name, draft_);
  };
  std::vector<PlanarPose> poses = laid(measured, request_.sources[0].string());
  // Commands have no stamp of their own: both by the clock of the recording.
  for (size_t i = 0; twist && i < poses.size(); ++i) poses[i].ns = measured[i].log_ns;
  std::stable_sort(poses.begin(), poses.end(),
                   [](const PlanarPose& a, const PlanarPose& b) { return a.ns < b.ns; });
  if (twist) {
    draft_walk(data_.twists[*twist], poses, draft_);
    draft_.did(
        fmt::format("velocities of {}, by the times of recording", data_.topics[*twist].name));
    draft_.could_not_know("how long messages were on their way");
    return true;
  }
  draft_walk(velocities_of(laid(data_.odometry[*odometry], data_.topics[*odometry].name)), poses,
             draft_);
  draft_.did(fmt::format("the steps of {} stand for commanded velocities, {} is what was measured",
                         data_.topics[*odometry].name, data_.topics[*truth].name));
  draft_.could_not_know("what was commanded: this constrains odometry's errors, not the gait's");
  return true;
}

const PlainCamera* RosImport::chosen_camera() const {
  const auto found = choose(data_.cameras, "camera", [&](const BagTopic& topic) {
    return request_.camera.empty() || contains(topic.name, request_.camera.c_str());
  });
  return found ? &data_.cameras.at(*found) : nullptr;
}

bool RosImport::camera() {
  const PlainCamera* camera = chosen_camera();
  if (camera == nullptr) return false;
  draft_.camera.width_px = camera->width_px, draft_.camera.height_px = camera->height_px;
  draft_protocol({*camera}, request_, draft_);
  draft_.did(fmt::format("the calibration of {}", camera->name));
  return true;
}

bool RosImport::poses() {
  const auto fits = [](const BagTopic& topic) {
    return topic.messages >= 4 && !contains(topic.name, "initial") && !contains(topic.name, "goal");
  };
  const auto found = choose(data_.poses, "measured", fits);
  const auto walked = choose(data_.odometry, "measured", fits);
  if (!found && !walked) return false;
  const std::string& name = data_.topics[found ? *found : *walked].name;
  std::vector<StampedPose> poses;
  for (const PoseRow& row : found ? data_.poses[*found] : data_.odometry[*walked])
    poses.push_back(row.pose);
  const auto sooner = [](const StampedPose& a, const StampedPose& b) { return a.ns < b.ns; };
  std::stable_sort(poses.begin(), poses.end(), sooner);
  const auto same = [](const StampedPose& a, const StampedPose& b) { return a.ns == b.ns; };
  poses.erase(std::unique(poses.begin(), poses.end(), same), poses.end());
  if (poses.size() < 3)
    throw InputError(fmt::format("{}: found {} poses at different times, expected 3 or more", name,
                                 poses.size()));
  check_speed(poses, name, request_);
  const PlainCamera* camera = chosen_camera();
  draft_poses(poses, {}, Pose{Mat3(1.0), Vec3(0.0)},
              camera ? *camera : camera_for_granted(request_, draft_), draft_);
  draft_.did(fmt::format("the poses of {}", name));
  return true;
}

void RosImport::take_transforms() {
  const auto take = [&](const std::string& names, std::map<size_t, std::vector<PoseRow>>& into) {
    auto rows = data_.transforms.poses(names);
    if (!rows) return;
    data_.topics.push_back(
        {.name = "/tf:" + names, .type = "tf2_msgs/TFMessage", .messages = rows->size()});
    into[data_.topics.size() - 1] = std::move(*rows);
  };
  for (const auto& [quantity, topic] : request_.names) {
    if (topic.starts_with("/tf:"))
      take(topic.substr(4), quantity == "odometry" ? data_.odometry : data_.poses);
  }
  if (data_.poses.empty() && data_.odometry.empty()) take(data_.transforms.body(), data_.poses);
}

void RosImport::run() {
  if (request_.sources.size() != 1) throw UsageError("ros: expected one bag");
  const std::string name = request_.sources[0].string();
  if (!std::filesystem::is_directory(request_.sources[0]) &&
      request_.sources[0].extension() == ".yaml") {
    return import_opencv(request_, draft_);
  }
  data_ = read_bag_data(request_.sources[0], draft_);
  take_transforms();
  for (const auto& [quantity, topic] : request_.names) {
    std::vector<std::string> names;
    for (const BagTopic& known : data_.topics) names.push_back(known.name);
    if (std::find(names.begin(), names.end(), topic) == names.end())
      throw InputError(fmt::format("{}: topic '{}' (--map {}=...) is missing{}", name, topic,
                                   quantity, suggestion_for(topic, names)));
  }
  for (const BagTopic& topic : data_.topics) {
    if (topic.messages == 0) draft_.warn(fmt::format("topic {} is empty", topic.name));
  }
  // A message that holds both is worth more than two topics, which are joined by guessed delays.
  if (controllers(true) || joints() || walk() || controllers(false)) return;
  const bool shows =
      std::any_of(data_.topics.begin(), data_.topics.end(), [](const BagTopic& topic) {
        return topic.type == "sensor_msgs/Image" || topic.type == "sensor_msgs/CompressedImage";
      });
  // Where the user says what is on the pictures, they are worth more than a calibration alone.
  if (shows && request_.board_columns > 0) return import_images(request_, draft_);
  if (!request_.name_of("measured").empty() && poses()) return;
  if (camera() || poses()) return;
  throw InputError(fmt::format(
      "{}: found no joints with commands (a controller's state, or JointState and another topic), "
      "no walk (Odometry with "
      "cmd_vel, or with poses), no CameraInfo and no poses among its topics: {}; say which, --map "
      "measured=/TOPIC,command=/TOPIC",
      name, topics_text()));
}

}  // namespace

void import_ros(const ImportRequest& request, SetDraft& draft) {
  RosImport(request, draft).run();
}

}  // namespace seam::app
