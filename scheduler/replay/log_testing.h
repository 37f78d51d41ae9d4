// What tests and benchmarks of logs share: runs recorded in memory, and their re-runs.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "scheduler/log/recorder.h"
#include "scheduler/loop/testing.h"
#include "scheduler/replay/player.h"
#include "scheduler/replay/rewinder.h"
#include "scheduler/replay/verification.h"

namespace seam::scheduler::testing {

// Swings the head, walks, asks for frames; depends on all that it gets.
inline Decision busy_behaviour(const Observation& seen) {
  Decision decision;
  const double pan = 0.4 * static_cast<double>((seen.sequence + seen.robot) % 3) - 0.4;
  decision.command.joints = {{SimDuration::from_ns(1'000'000 * seen.robot), {{kPan, pan, 3.0}}}};
  if (seen.sequence % 4 == 1)
    decision.command.walk = BodyVelocity{0.1, 0, 0.2 * seen.sensors.joints.rad[kPan]};
  if (seen.sequence == 1) decision.frame_requests = {{.which = FrameRequest::Which::all}};
  if (seen.sequence % 5 == 0) decision.debug = {{.name = "sequence", .value = 1.0}};
  return decision;
}

inline RunHeader header_of(const Scenario& scenario, const std::string& yaml) {
  RunHeader header{.scenario_text = yaml,
                   .scenario_name = "test.yaml",
                   .seed = static_cast<uint64_t>(scenario.seed),
                   .versions = {{"state", "1"}}};
  for (const RobotSpec& robot : scenario.robots) header.robots.push_back(robot.id);
  header.sections = World(scenario).section_names();
  return header;
}

struct RecordedRun {
  std::string bytes;
  uint64_t fingerprint = 0;
};

// Runs a scenario and records it. With `kill_after`, the run ends there as if the process had been
// killed: the log has no end.
inline RecordedRun record(const std::string& yaml, DecisionSource& decisions,
                          const RecorderOptions& options = {},
                          std::optional<SimTime> kill_after = {}) {
  const Scenario scenario = Scenario::from_text(yaml, "test.yaml");
  World world(scenario);
  RunControl control;
  HashRenderer renderer(scenario);
  mcap::MemoryOutput output;
  std::optional<Recorder> recorder(std::in_place, output, world, options);
  Simulation simulation(
      {scenario, world, decisions, control, &renderer, {&*recorder}, header_of(scenario, yaml)});
  if (kill_after) {
    simulation.run_to(*kill_after);
  } else {
    simulation.run();
  }
  recorder.reset();  // What it has begun to write it ends.
  return {output.bytes(), simulation.fingerprint()};
}

inline RecordedRun record(const std::string& yaml, const RecorderOptions& options = {}) {
  FunctionSource source(busy_behaviour);
  return record(yaml, source, options);
}

inline Log log_of(const std::string& bytes, LogAccess access = LogAccess::indexed) {
  return Log::open(std::make_unique<mcap::MemoryInput>(bytes, "test.mcap"), access);
}

// A message on its way into a changed copy of a log.
struct CopiedMessage {
  std::string topic;
  uint64_t log_time_ns;
  uint64_t publish_time_ns;
  std::string data;
};

// The same log, attachments included, with each message and attachment changed by these, which
// return whether it is kept.
struct LogEdit {
  std::function<bool(CopiedMessage&)> message = [](CopiedMessage&) { return true; };
  std::function<bool(mcap::Attachment&)> attachment = [](mcap::Attachment&) { return true; };
};

inline std::string edited(const std::string& bytes, const LogEdit& edit) {
  const Log log = log_of(bytes);
  const mcap::Contents& contents = log.file().contents();
  mcap::MemoryOutput output;
  mcap::Writer writer(output, {.profile = std::string(kLogFormat)});
  for (const auto& [id, schema] : contents.schemas)
    writer.add_schema(schema.name, schema.encoding, schema.data);
  for (const auto& [id, channel] : contents.channels)
    writer.add_channel(channel.schema_id, channel.topic, channel.message_encoding);
  for (const mcap::AttachmentIndex& place : contents.attachments) {
    mcap::Attachment attachment = log.file().read_attachment(place);
    if (edit.attachment(attachment)) writer.attach(attachment);
  }
  for (const mcap::ChunkPlace& chunk : contents.chunks) {
    log.file().for_each_message(chunk, [&](const mcap::Message& message) {
      CopiedMessage copy{contents.channels.at(message.channel_id).topic, message.log_time_ns,
                         message.publish_time_ns, std::string(message.data)};
      if (!edit.message(copy)) return;
      writer.write(message.channel_id, copy.log_time_ns, copy.publish_time_ns, copy.data);
    });
    writer.flush();
  }
  writer.finish();
  return output.bytes();
}

inline Verification verify(const Log& log, bool frames = true) {
  const Scenario scenario = Scenario::from_text(log.header().scenario_text, "log");
  World world(scenario);
  HashRenderer renderer(scenario);
  return verify(log, {scenario, world, frames ? &renderer : nullptr,
                      header_of(scenario, log.header().scenario_text)});
}

}  // namespace seam::scheduler::testing
