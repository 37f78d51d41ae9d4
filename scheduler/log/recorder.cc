#include "scheduler/log/recorder.h"

#include <algorithm>
#include <utility>

#include "scheduler/log/field_checks.h"
#include "scheduler/log/foxglove.h"
#include "scheduler/log/log.h"
#include "sim_core/base/hash.h"
#include "sim_core/base/image.h"

namespace seam::scheduler {
namespace {

mcap::WriterOptions writer_options(const RecorderOptions& options) {
  return {.profile = std::string(kLogFormat), .zstd_level = options.zstd_level};
}

}  // namespace

uint64_t step_fingerprint(std::span<const uint64_t> section_hashes) {
  Hasher hasher;
  for (const uint64_t hash : section_hashes) hasher.add(hash);
  return hasher.digest();
}

std::vector<float> poses_of(const World& world) {
  const SimTime time = world.start();
  std::vector<float> poses;
  for (size_t robot = 0; robot < world.scenario().robots.size(); ++robot) {
    const RobotTruth truth = world.robot(robot, time);
    const bool has_head = !world.scenario().robots[robot].body.tree.present();
    const JointAngles head = has_head ? truth.joints_rad : JointAngles{};
    for (const double value : {truth.pose.x_m, truth.pose.y_m, truth.pose.theta_rad, head[kTilt],
                               head[kPan], head[kRoll]}) {
      poses.push_back(static_cast<float>(value));
    }
  }
  const Vec3 ball = world.ball(time).p_W;
  for (const double value : {ball.x, ball.y, ball.z}) poses.push_back(static_cast<float>(value));
  return poses;
}

StepRecord Recorder::step_record(SimTime time, uint64_t step, const StateDigest& state) {
  StepRecord record{time, step, step_fingerprint(state.section_hashes), {}, {}, {}, {}};
  for (const uint64_t hash : state.section_hashes) {
    record.section_hashes.push_back(static_cast<uint32_t>(hash));
  }
  record.field_sums = sums_.of(state.words);
  if (step % kCheckEverySteps == 0) record.field_checks = field_checks(state.words, step);
  if (step % kPoseEverySteps == 0) record.poses = poses_of(world_);
  return record;
}

Recorder::Recorder(mcap::Output& output, const World& world, const RecorderOptions& options)
    : world_(world), options_(options), writer_(output, writer_options(options)) {}

uint16_t Recorder::add_channel(std::string_view topic, std::string_view message_name) {
  auto schema = schemas_.find(message_name);
  if (schema == schemas_.end()) {
    const std::string name(message_name);
    schema =
        schemas_.emplace(name, writer_.add_schema(name, "protobuf", descriptor_set_of(name))).first;
  }
  return writer_.add_channel(schema->second, std::string(topic), "protobuf");
}

void Recorder::on_start(const RunHeader& header) {
  robots_ = header.robots;
  for (const Topic topic : kTopics) {
    channels_.push_back(add_channel(topic_name(topic), schema_name(topic)));
  }
  for (const std::string& robot : robots_) {
    if (!options_.pictures) break;
    picture_channels_[robot] = add_channel(picture_topic(robot), kPictures.schema);
  }
  if (options_.transforms) transforms_channel_ = add_channel(kTransforms.topic, kTransforms.schema);
  if (options_.scene) scene_channel_ = add_channel(kSceneUpdates.topic, kSceneUpdates.schema);

  // The scenario as an attachment too: one damaged place must not cost it, and any MCAP tool can
  // take it out.
  writer_.attach(
      {.name = "scenario.yaml", .media_type = "application/yaml", .data = header.scenario_text});
  header_bytes_ = encode(header, robots_);
  inputs_.add(header, header_bytes_);
  writer_.write(channels_[static_cast<size_t>(Topic::header)], log_time(SimTime()), header_bytes_);
  writer_.flush();  // From the first moment on the log says what it is of.
}

void Recorder::note(Topic topic, SimTime time, LogRecord record) {
  // A chunk ends before the record that would make it too long, so that what is on disk is never
  // older than one period.
  if (time - chunk_start_ >= options_.chunk_period) {
    batches_.add([this] { writer_.flush(); });
    batches_.start();
    chunk_start_ = time;
  }
  batches_.add(
      [this, topic, time, record = std::move(record)]() mutable { write(topic, time, record); });
}

void Recorder::write(Topic topic, SimTime time, LogRecord& record) {
  if (auto* end = std::get_if<EndRecord>(&record)) {
    end->inputs_hash = inputs_.digest(end->time, end->reason);
  }
  const std::string bytes = encode(record, robots_);
  inputs_.add(record, bytes);
  writer_.write(channels_[static_cast<size_t>(topic)], log_time(time), bytes);
}

void Recorder::note_message(uint16_t channel, SimTime time, std::string bytes) {
  batches_.add([this, channel, time, bytes = std::move(bytes)] {
    writer_.write(channel, log_time(time), bytes);
  });
}

void Recorder::on_turn(SimTime time, const Turn& turn) {
  note(Topic::turn, time, TurnRecord{time, turn});
}

void Recorder::on_step(SimTime time, uint64_t step, const StateDigest& state) {
  ++steps_;
  note(Topic::step, time, step_record(time, step, state));
  if (!last_snapshot_ || time - *last_snapshot_ >= options_.snapshot_period) {
    note_snapshot(time, step);
    last_snapshot_ = time;
  }
  if (step % kPoseEverySteps == 0) note_foxglove(time);
}

void Recorder::note_snapshot(SimTime time, uint64_t step) {
  // With the definitions and the header, so that a file with a damaged start can be re-run from
  // its first whole snapshot on.
  batches_.add([this] { writer_.repeat_definitions(); });
  note_message(channels_[static_cast<size_t>(Topic::header)], time, header_bytes_);
  note(Topic::snapshot, time, SnapshotRecord{time, step, world_.snapshot()});
}

void Recorder::note_foxglove(SimTime time) {
  if (transforms_channel_ != 0)
    note_message(transforms_channel_, time, frame_transforms(world_, time));
  if (scene_channel_ != 0) {
    // What stands still is written once and stays.
    note_message(scene_channel_, time, scene_update(world_, time, !scene_written_));
    scene_written_ = true;
  }
}

void Recorder::on_frame(SimTime time, const FrameJob&, const Frame& frame) {
  ++frames_;
  const auto robot = std::find(robots_.begin(), robots_.end(), frame.robot) - robots_.begin();
  note(Topic::frame, time,
       FrameRecord{time, static_cast<int>(robot), frame.frame_index, frame.stamp,
                   frame.fingerprint});
  const auto channel = picture_channels_.find(frame.robot);
  if (channel == picture_channels_.end()) return;
  batches_.add([this, time, stamp = frame.stamp, link = frame.robot + "/camera",
                number = channel->second,
                image = Image{.width_px = frame.width_px,
                              .height_px = frame.height_px,
                              .channels = 3,
                              .samples = {frame.rgb.begin(), frame.rgb.end()}}] {
    writer_.write(number, log_time(time), log_time(stamp),
                  compressed_image(stamp, link, encode_png(image)));
  });
}

void Recorder::on_event(const SimulationEvent& event) {
  if (event.kind == EventKind::debug) return;  // Stands in the decision that brought it.
  note(Topic::event, event.time, event);
}

void Recorder::note_printed(const PrintedLine& line) {
  batches_.add([this, line] {
    if (printed_channel_ == 0) printed_channel_ = add_channel(kPrinted.topic, kPrinted.schema);
    writer_.write(printed_channel_, log_time(line.time), encode(line));
  });
}

void Recorder::on_end(SimTime time, EndReason reason, uint64_t fingerprint) {
  note(Topic::end, time, EndRecord{time, reason, fingerprint, steps_, frames_, 0});
  batches_.finish();
  writer_.finish();
}

}  // namespace seam::scheduler
