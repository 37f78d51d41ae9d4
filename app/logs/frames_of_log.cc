#include "app/logs/frames_of_log.h"

#include <algorithm>

namespace seam::app {

FramesOfLog::FramesOfLog(scheduler::FrameRenderer& renderer, const scheduler::Log& log,
                         std::set<int> seen, UnseenFrames unseen,
                         const scheduler::MixedReport& report)
    : renderer_(renderer), seen_(std::move(seen)), unseen_(unseen), report_(report) {
  scheduler::LogCursor cursor(log, {scheduler::Topic::frame});
  while (const auto record = cursor.next()) {
    const auto& frame = std::get<scheduler::FrameRecord>(*record);
    if (!seen_.contains(frame.robot)) fingerprints_[{frame.robot, frame.index}] = frame.fingerprint;
  }
}

Frame FramesOfLog::render(int robot, const FrameJob& job, int worker) {
  if (seen_.contains(robot)) return renderer_.render(robot, job, worker);
  SimTime end = job.stamp;
  for (const SimTime instant : job.schedule.instants) end = std::max(end, instant);
  for (const RowWindow& row : job.schedule.rows) end = std::max(end, row.end);
  const auto logged = fingerprints_.find({robot, job.frame_index});
  // Until a decision is another one the world is the log's, and so is what its cameras see.
  const bool as_logged = logged != fingerprints_.end() && end.ns() <= report_.departs_ns;
  if (!as_logged && unseen_ == UnseenFrames::when_changed)
    return renderer_.render(robot, job, worker);
  Frame frame{.robot = job.robot,
              .frame_index = job.frame_index,
              .stamp = job.stamp,
              .rows = job.schedule.rows};
  if (logged != fingerprints_.end()) frame.fingerprint = logged->second;
  return frame;
}

}  // namespace seam::app
