// The records of a log as Protocol Buffers, and back.
#include <fmt/format.h>
#include <google/protobuf/descriptor.h>
#include <google/protobuf/descriptor.pb.h>

#include <set>

#include "foxglove/image.pb.h"
#include "foxglove/log.pb.h"
#include "foxglove/scene.pb.h"
#include "foxglove/transforms.pb.h"
#include "scheduler/log/log_records.h"
#include "scheduler/wire/wire.h"
#include "seam/v1/log.pb.h"
#include "seam/v1/turn.pb.h"
#include "sim_core/base/error.h"
#include "sim_core/scenario/scenario.h"

namespace seam::scheduler {
namespace {

#define SEAM_TOPIC_NAME(name, Record, Message) "/seam/" #name,
constexpr std::string_view kTopicNames[] = {SEAM_LOG_MESSAGES(SEAM_TOPIC_NAME)};
#undef SEAM_TOPIC_NAME
#define SEAM_SCHEMA_NAME(name, Record, Message) "seam.v1." #Message,
constexpr std::string_view kSchemaNames[] = {SEAM_LOG_MESSAGES(SEAM_SCHEMA_NAME)};
#undef SEAM_SCHEMA_NAME

using Robots = std::vector<std::string>;

template <typename Message>
Message parse(std::string_view bytes, Topic topic) {
  Message message;
  if (!message.ParseFromArray(bytes.data(), static_cast<int>(bytes.size()))) {
    throw InputError(fmt::format("{}: {} bytes that are no {}", topic_name(topic), bytes.size(),
                                 schema_name(topic)));
  }
  return message;
}

// An enumerator of ours from the number on the wire.
template <typename Enum>
Enum checked(int number, Enum last, Topic topic, const char* field) {
  if (number < 0 || number > static_cast<int>(last)) {
    throw InputError(fmt::format("{}: {}: found {}, expected 0 to {}", topic_name(topic), field,
                                 number, static_cast<int>(last)));
  }
  return static_cast<Enum>(number);
}

void fill(v1::LogHeader& message, const RunHeader& header, const Robots&) {
  message.set_format(std::string(kLogFormat));
  message.set_scenario_name(header.scenario_name);
  message.set_scenario_text(header.scenario_text);
  message.set_seed(header.seed);
  for (const auto& [name, version] : header.versions) {
    v1::LogVersion* one = message.add_versions();
    one->set_name(name);
    one->set_version(version);
  }
  for (const std::string& robot : header.robots) message.add_robots(robot);
  for (const std::string& section : header.sections) message.add_sections(section);
}

RunHeader read(const v1::LogHeader& message, const Robots&) {
  if (message.format() != kLogFormat) {
    throw InputError(fmt::format("found a log of format '{}', expected {}",
                                 message.format().substr(0, 64), kLogFormat));
  }
  RunHeader header;
  header.scenario_name = message.scenario_name();
  header.scenario_text = message.scenario_text();
  header.seed = message.seed();
  for (const v1::LogVersion& one : message.versions())
    header.versions.emplace_back(one.name(), one.version());
  header.robots.assign(message.robots().begin(), message.robots().end());
  std::set<std::string> seen;
  for (const std::string& robot : header.robots) {
    if (!is_robot_id(robot)) {
      throw InputError(fmt::format("/seam/header: robots: found '{}', expected {}",
                                   robot.substr(0, 64), kRobotIdRule));
    }
    if (!seen.insert(robot).second) {
      throw InputError(fmt::format("/seam/header: robots: found '{}' twice", robot));
    }
  }
  header.sections.assign(message.sections().begin(), message.sections().end());
  return header;
}

void fill(v1::Turn& message, const TurnRecord& turn, const Robots& robots) {
  turn_to_wire(turn.time, turn.turn, robots, message);
}

TurnRecord read(const v1::Turn& message, const Robots& robots) {
  auto [time, turn] = turn_from_wire(message, robots);
  return {time, std::move(turn)};
}

void fill(v1::LogStep& message, const StepRecord& step, const Robots&) {
  message.set_time_ns(step.time.ns());
  message.set_step(step.step);
  message.set_fingerprint(step.fingerprint);
  message.mutable_section_hashes()->Add(step.section_hashes.begin(), step.section_hashes.end());
  message.set_field_checks(step.field_checks);
  message.mutable_poses()->Add(step.poses.begin(), step.poses.end());
  message.mutable_field_sums()->Add(step.field_sums.begin(), step.field_sums.end());
}

StepRecord read(v1::LogStep&& message, const Robots&) {
  return {time_from_log(message.time_ns(), "/seam/step: time_ns"),
          message.step(),
          message.fingerprint(),
          {message.section_hashes().begin(), message.section_hashes().end()},
          std::move(*message.mutable_field_checks()),
          {message.poses().begin(), message.poses().end()},
          {message.field_sums().begin(), message.field_sums().end()}};
}

void fill(v1::LogSnapshot& message, const SnapshotRecord& snapshot, const Robots&) {
  message.set_time_ns(snapshot.time.ns());
  message.set_step(snapshot.step);
  message.set_state(snapshot.state);
}

SnapshotRecord read(v1::LogSnapshot&& message, const Robots&) {
  return {time_from_log(message.time_ns(), "/seam/snapshot: time_ns"), message.step(),
          std::move(*message.mutable_state())};
}

void fill(v1::LogFrame& message, const FrameRecord& frame, const Robots&) {
  message.set_time_ns(frame.time.ns());
  message.set_robot(static_cast<uint32_t>(frame.robot));
  message.set_index(frame.index);
  message.set_stamp_ns(frame.stamp.ns());
  message.set_fingerprint(frame.fingerprint);
}

FrameRecord read(const v1::LogFrame& message, const Robots& robots) {
  if (message.robot() >= robots.size()) {
    throw InputError(fmt::format("/seam/frame: robot: found {}, expected less than {}",
                                 message.robot(), robots.size()));
  }
  return {time_from_log(message.time_ns(), "/seam/frame: time_ns"),
          static_cast<int>(message.robot()), message.index(),
          time_from_log(message.stamp_ns(), "/seam/frame: stamp_ns"), message.fingerprint()};
}

void fill(v1::LogEvent& message, const SimulationEvent& event, const Robots&) {
  message.set_time_ns(event.time.ns());
  message.set_kind(static_cast<v1::LogEvent::Kind>(event.kind));
  message.set_robot(event.robot);
  message.set_name(event.name);
  message.set_detail(event.detail);
}

SimulationEvent read(const v1::LogEvent& message, const Robots&) {
  return {time_from_log(message.time_ns(), "/seam/event: time_ns"),
          checked(message.kind(), EventKind::debug, Topic::event, "kind"), message.robot(),
          message.name(), message.detail()};
}

void fill(v1::LogEnd& message, const EndRecord& end, const Robots&) {
  message.set_time_ns(end.time.ns());
  message.set_reason(static_cast<v1::LogEnd::Reason>(end.reason));
  message.set_fingerprint(end.fingerprint);
  message.set_steps(end.steps);
  message.set_frames(end.frames);
  message.set_inputs_hash(end.inputs_hash);
}

EndRecord read(const v1::LogEnd& message, const Robots&) {
  return {time_from_log(message.time_ns(), "/seam/end: time_ns"),
          checked(message.reason(), EndReason::aborted, Topic::end, "reason"),
          message.fingerprint(),
          message.steps(),
          message.frames(),
          message.inputs_hash()};
}

// A file behind all that it imports.
void add_file(const google::protobuf::FileDescriptor& file, std::set<std::string>& added,
              google::protobuf::FileDescriptorSet& files) {
  if (!added.insert(file.name()).second) return;
  for (int i = 0; i < file.dependency_count(); ++i) add_file(*file.dependency(i), added, files);
  file.CopyTo(files.add_file());
}

// The message type of a record.
template <typename Record>
struct MessageOf;
#define SEAM_MESSAGE_OF(name, Record, Message) \
  template <>                                  \
  struct MessageOf<Record> {                   \
    using Type = v1::Message;                  \
  };
SEAM_LOG_MESSAGES(SEAM_MESSAGE_OF)
#undef SEAM_MESSAGE_OF

}  // namespace

std::string_view topic_name(Topic topic) {
  return kTopicNames[static_cast<int>(topic)];
}
std::string_view schema_name(Topic topic) {
  return kSchemaNames[static_cast<int>(topic)];
}

std::string encode(const LogRecord& record, const Robots& robots) {
  return std::visit(
      [&]<typename Record>(const Record& one) {
        typename MessageOf<Record>::Type message;
        fill(message, one, robots);
        return message.SerializeAsString();
      },
      record);
}

LogRecord decode(Topic topic, std::string_view bytes, const Robots& robots) {
  switch (topic) {
#define SEAM_DECODE(name, Record, Message) \
  case Topic::name:                        \
    return read(parse<v1::Message>(bytes, Topic::name), robots);
    SEAM_LOG_MESSAGES(SEAM_DECODE)
#undef SEAM_DECODE
  }
  check_failed(__FILE_NAME__, __LINE__, "topic", std::to_string(static_cast<int>(topic)));
}

std::string descriptor_set_of(std::string_view message_name) {
  // The generated pool knows only files whose code is linked in: name each once.
#define SEAM_NAME_ONCE(name, Record, Message) v1::Message::descriptor();
  SEAM_LOG_MESSAGES(SEAM_NAME_ONCE)
#undef SEAM_NAME_ONCE
  foxglove::CompressedImage::descriptor();
  foxglove::FrameTransforms::descriptor();
  foxglove::Log::descriptor();
  foxglove::SceneUpdate::descriptor();
  const google::protobuf::Descriptor* descriptor =
      google::protobuf::DescriptorPool::generated_pool()->FindMessageTypeByName(
          std::string(message_name));
  SEAM_CHECK(descriptor != nullptr, "{}", message_name);
  google::protobuf::FileDescriptorSet files;
  std::set<std::string> added;
  add_file(*descriptor->file(), added, files);
  return files.SerializeAsString();
}

}  // namespace seam::scheduler
