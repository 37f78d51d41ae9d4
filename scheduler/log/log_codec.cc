// The records of a log as Protocol Buffers, and back.
#include <fmt/format.h>
#include <google/protobuf/descriptor.h>
#include <google/protobuf/descriptor.pb.h>

#include <set>

#include "foxglove/image.pb.h"
#include "foxglove/scene.pb.h"
#include "foxglove/transforms.pb.h"
#include "scheduler/log/log_records.h"
#include "scheduler/wire/wire.h"
#include "seam/v1/log.pb.h"
#include "seam/v1/turn.pb.h"
#include "sim_core/base/error.h"

namespace seam::scheduler {
namespace {

constexpr std::string_view kTopicNames[kTopics] = {"/seam/header",   "/seam/turn",  "/seam/step",
                                                   "/seam/snapshot", "/seam/frame", "/seam/event",
                                                   "/seam/end"};
constexpr std::string_view kSchemaNames[kTopics] = {
    "seam.v1.LogHeader", "seam.v1.Turn",     "seam.v1.LogStep", "seam.v1.LogSnapshot",
    "seam.v1.LogFrame",  "seam.v1.LogEvent", "seam.v1.LogEnd"};

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

std::string encode_header(const RunHeader& header) {
  v1::LogHeader message;
  message.set_format(std::string(kLogFormat));
  message.set_scenario_name(header.scenario_name);
  message.set_scenario_text(header.scenario_text);
  message.set_seed(header.seed);
  for (const auto& [name, text] : header.files) {
    v1::LogFile* file = message.add_files();
    file->set_name(name);
    file->set_text(text);
  }
  for (const auto& [name, version] : header.versions) {
    v1::LogVersion* one = message.add_versions();
    one->set_name(name);
    one->set_version(version);
  }
  for (const std::string& robot : header.robots) message.add_robots(robot);
  for (const std::string& section : header.sections) message.add_sections(section);
  return message.SerializeAsString();
}

RunHeader decode_header(std::string_view bytes) {
  const auto message = parse<v1::LogHeader>(bytes, Topic::header);
  if (message.format() != kLogFormat) {
    throw InputError(fmt::format("found a log of format '{}', expected {}",
                                 message.format().substr(0, 64), kLogFormat));
  }
  RunHeader header;
  header.scenario_name = message.scenario_name();
  header.scenario_text = message.scenario_text();
  header.seed = message.seed();
  for (const v1::LogFile& file : message.files())
    header.files.emplace_back(file.name(), file.text());
  for (const v1::LogVersion& one : message.versions())
    header.versions.emplace_back(one.name(), one.version());
  header.robots.assign(message.robots().begin(), message.robots().end());
  header.sections.assign(message.sections().begin(), message.sections().end());
  return header;
}

std::string encode_step(const StepRecord& step) {
  v1::LogStep message;
  message.set_time_ns(step.time.ns());
  message.set_step(step.step);
  message.set_fingerprint(step.fingerprint);
  message.mutable_section_hashes()->Add(step.section_hashes.begin(), step.section_hashes.end());
  message.set_field_checks(step.field_checks);
  message.mutable_poses()->Add(step.poses.begin(), step.poses.end());
  message.mutable_field_sums()->Add(step.field_sums.begin(), step.field_sums.end());
  return message.SerializeAsString();
}

StepRecord decode_step(std::string_view bytes) {
  auto message = parse<v1::LogStep>(bytes, Topic::step);
  return {time_from_log(message.time_ns(), "/seam/step: time_ns"),
          message.step(),
          message.fingerprint(),
          {message.section_hashes().begin(), message.section_hashes().end()},
          std::move(*message.mutable_field_checks()),
          {message.poses().begin(), message.poses().end()},
          {message.field_sums().begin(), message.field_sums().end()}};
}

std::string encode_snapshot(const SnapshotRecord& snapshot) {
  v1::LogSnapshot message;
  message.set_time_ns(snapshot.time.ns());
  message.set_step(snapshot.step);
  message.set_state(snapshot.state);
  return message.SerializeAsString();
}

SnapshotRecord decode_snapshot(std::string_view bytes) {
  auto message = parse<v1::LogSnapshot>(bytes, Topic::snapshot);
  return {time_from_log(message.time_ns(), "/seam/snapshot: time_ns"), message.step(),
          std::move(*message.mutable_state())};
}

std::string encode_frame(const FrameRecord& frame) {
  v1::LogFrame message;
  message.set_time_ns(frame.time.ns());
  message.set_robot(static_cast<uint32_t>(frame.robot));
  message.set_index(frame.index);
  message.set_stamp_ns(frame.stamp.ns());
  message.set_fingerprint(frame.fingerprint);
  return message.SerializeAsString();
}

FrameRecord decode_frame(std::string_view bytes, size_t robots) {
  const auto message = parse<v1::LogFrame>(bytes, Topic::frame);
  if (message.robot() >= robots) {
    throw InputError(fmt::format("/seam/frame: robot: found {}, expected less than {}",
                                 message.robot(), robots));
  }
  return {time_from_log(message.time_ns(), "/seam/frame: time_ns"),
          static_cast<int>(message.robot()), message.index(),
          time_from_log(message.stamp_ns(), "/seam/frame: stamp_ns"), message.fingerprint()};
}

std::string encode_event(const SimulationEvent& event) {
  v1::LogEvent message;
  message.set_time_ns(event.time.ns());
  message.set_kind(static_cast<v1::LogEvent::Kind>(event.kind));
  message.set_robot(event.robot);
  message.set_name(event.name);
  message.set_detail(event.detail);
  return message.SerializeAsString();
}

SimulationEvent decode_event(std::string_view bytes) {
  const auto message = parse<v1::LogEvent>(bytes, Topic::event);
  return {time_from_log(message.time_ns(), "/seam/event: time_ns"),
          checked(message.kind(), EventKind::debug, Topic::event, "kind"), message.robot(),
          message.name(), message.detail()};
}

std::string encode_end(const EndRecord& end) {
  v1::LogEnd message;
  message.set_time_ns(end.time.ns());
  message.set_reason(static_cast<v1::LogEnd::Reason>(end.reason));
  message.set_fingerprint(end.fingerprint);
  message.set_steps(end.steps);
  message.set_frames(end.frames);
  return message.SerializeAsString();
}

EndRecord decode_end(std::string_view bytes) {
  const auto message = parse<v1::LogEnd>(bytes, Topic::end);
  return {time_from_log(message.time_ns(), "/seam/end: time_ns"),
          checked(message.reason(), EndReason::aborted, Topic::end, "reason"),
          message.fingerprint(), message.steps(), message.frames()};
}

// A file behind all that it imports.
void add_file(const google::protobuf::FileDescriptor& file, std::set<std::string>& added,
              google::protobuf::FileDescriptorSet& files) {
  if (!added.insert(file.name()).second) return;
  for (int i = 0; i < file.dependency_count(); ++i) add_file(*file.dependency(i), added, files);
  file.CopyTo(files.add_file());
}

template <class... Cases>
struct Overloaded : Cases... {
  using Cases::operator()...;
};
template <class... Cases>
Overloaded(Cases...) -> Overloaded<Cases...>;  // clang 14 does not deduce it.

}  // namespace

std::string_view topic_name(Topic topic) {
  return kTopicNames[static_cast<int>(topic)];
}
std::string_view schema_name(Topic topic) {
  return kSchemaNames[static_cast<int>(topic)];
}

std::string encode(const LogRecord& record, const std::vector<std::string>& robots) {
  return std::visit(
      Overloaded{[](const RunHeader& header) { return encode_header(header); },
                 [&](const TurnRecord& turn) { return encode_turn(turn.time, turn.turn, robots); },
                 [](const StepRecord& step) { return encode_step(step); },
                 [](const SnapshotRecord& snapshot) { return encode_snapshot(snapshot); },
                 [](const FrameRecord& frame) { return encode_frame(frame); },
                 [](const SimulationEvent& event) { return encode_event(event); },
                 [](const EndRecord& end) { return encode_end(end); }},
      record);
}

LogRecord decode(Topic topic, std::string_view bytes, const std::vector<std::string>& robots) {
  switch (topic) {
    case Topic::header:
      return decode_header(bytes);
    case Topic::turn: {
      auto [time, turn] = decode_turn(bytes, robots);
      return TurnRecord{time, std::move(turn)};
    }
    case Topic::step:
      return decode_step(bytes);
    case Topic::snapshot:
      return decode_snapshot(bytes);
    case Topic::frame:
      return decode_frame(bytes, robots.size());
    case Topic::event:
      return decode_event(bytes);
    case Topic::end:
      return decode_end(bytes);
  }
  check_failed(__FILE__, __LINE__, "topic", std::to_string(static_cast<int>(topic)));
}

std::string descriptor_set_of(std::string_view message_name) {
  // The generated pool knows only files whose code is linked in: name each once.
  v1::LogHeader::descriptor();
  v1::Turn::descriptor();
  foxglove::CompressedImage::descriptor();
  foxglove::FrameTransforms::descriptor();
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
