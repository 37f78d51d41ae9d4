// Writes the log of a run as it goes: everything that a re-run needs, and hashes to check it by.
// The run's own thread only notes what happened; encoding, compression and writing are done in
// another one, a chunk at a time, so that a log hardly slows a run.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "mcap/io.h"
#include "mcap/writer.h"
#include "scheduler/log/batches.h"
#include "scheduler/log/field_sums.h"
#include "scheduler/log/inputs_hash.h"
#include "scheduler/log/log_records.h"
#include "scheduler/log/printed_line.h"
#include "scheduler/loop/observer.h"
#include "sim_core/world/world.h"

namespace seam::scheduler {

struct RecorderOptions {
  SimDuration snapshot_period = SimDuration::from_ns(5'000'000'000);
  // At most this much simulated time is lost when the process dies.
  SimDuration chunk_period = SimDuration::from_ns(500'000'000);
  bool pictures = false;    // Each frame as a PNG.
  bool transforms = false;  // Poses of bodies and heads as foxglove.FrameTransforms.
  bool scene = false;       // Field, ball and robots as foxglove.SceneUpdate.
  int zstd_level = 3;
};

class Recorder final : public SimulationObserver {
 public:
  // `output` and `world` (the one that the run advances) must outlive the recorder, and nobody else
  // may use `output` before the run's end. What cannot be written is thrown with a later record or
  // at the end.
  Recorder(mcap::Output& output, const World& world, const RecorderOptions& options = {});

  void on_start(const RunHeader& header) override;
  void on_turn(SimTime time, const Turn& turn) override;
  void on_step(SimTime time, uint64_t step, const StateDigest& state) override;
  void on_frame(SimTime time, const FrameJob& job, const Frame& frame) override;
  void on_event(const SimulationEvent& event) override;
  void on_end(SimTime time, EndReason reason, uint64_t fingerprint) override;
  // Between the run's records, in the order of time.
  void note_printed(const PrintedLine& line);

 private:
  uint16_t add_channel(std::string_view topic, std::string_view message_name);
  StepRecord step_record(SimTime time, uint64_t step, const StateDigest& state);
  void note(Topic topic, SimTime time, LogRecord record);
  // In the writing thread.
  void write(Topic topic, SimTime time, LogRecord& record);
  void note_message(uint16_t channel, SimTime time, std::string bytes);
  void note_foxglove(SimTime time);
  void note_snapshot(SimTime time, uint64_t step);

  const World& world_;
  RecorderOptions options_;
  mcap::Writer writer_;
  std::vector<std::string> robots_;
  std::string header_bytes_;
  std::map<std::string, uint16_t, std::less<>> schemas_;  // By message name.
  std::vector<uint16_t> channels_;                        // By Topic.
  std::map<std::string, uint16_t> picture_channels_;      // By robot.
  uint16_t transforms_channel_ = 0;
  uint16_t scene_channel_ = 0;
  uint16_t printed_channel_ = 0;  // 0 until a line was printed; the writing thread's.
  bool scene_written_ = false;
  SimTime chunk_start_;
  std::optional<SimTime> last_snapshot_;
  uint64_t steps_ = 0;
  uint64_t frames_ = 0;
  FieldSums sums_;  // Of the last step.
  InputsHash inputs_;
  Batches batches_;  // They use the writer and what `on_start` sets: the last to be made, the first
                     // to go.
};

// The poses of a step record, from the world at its current step.
std::vector<float> poses_of(const World& world);
// The poses are recorded on each of these steps.
inline constexpr uint64_t kPoseEverySteps = 4;
// The field checks are recorded on each of these steps; odd, so that all four pairs of bits take
// turns.
inline constexpr uint64_t kCheckEverySteps = 17;
// Over 64-bit section hashes in order, and their lower halves.
uint64_t step_fingerprint(std::span<const uint64_t> section_hashes);

}  // namespace seam::scheduler
