#include "app/logs/open_loop.h"

#include "app/logs/replay_match.h"
#include "sim_core/base/error.h"
#include "sim_core/base/image.h"

namespace seam::app {

using scheduler::Outcome;
using scheduler::Topic;

std::optional<scheduler::Turn> OpenLoop::decide(
    SimTime now, std::span<const std::shared_ptr<const scheduler::Observation>> observations) {
  std::optional<scheduler::Turn> logged = turns_.turn(now, observations);
  if (!logged) return std::nullopt;
  for (size_t i = 0; i < observations.size(); ++i) {
    if (observations[i]->robot != robot_) continue;
    if (!settle()) return std::nullopt;
    live_.ask(now, observations.subspan(i, 1));
    asked_ = {now, observations[i], logged->answers[i]};
  }
  return logged;
}

void OpenLoop::finish(SimTime now, const std::string& reason) {
  settle();
  live_.finish(now, reason);
}

bool OpenLoop::settle() {
  if (!asked_) return true;
  const Asked asked = *std::exchange(asked_, std::nullopt);
  const std::optional<scheduler::Turn> live = live_.answers({&asked.seen, 1});
  stopped_ |= !live;
  if (!live) return false;
  const scheduler::Answer& fed = live->answers.front();
  if (fed.outcome != Outcome::decided && fed.outcome != Outcome::resumed)
    throw InputError(fmt::format("the program did not decide at {}: {}", seconds(asked.time),
                                 fed.reason.empty() ? "it is gone" : fed.reason));
  // Where the robot was frozen in the log there is nothing to compare with.
  if (asked.logged.outcome == Outcome::decided || asked.logged.outcome == Outcome::resumed)
    on_decision_({*asked.seen, asked.logged, fed});
  return true;
}

OneRobotsFrames::OneRobotsFrames(const scheduler::Log& log, CameraRenderer& renderer, int robot)
    : log_(log), renderer_(renderer), robot_(robot) {
  if (!log.has_pictures()) return;
  scheduler::LogCursor cursor(log, {Topic::frame});
  while (const auto record = cursor.next()) {
    const auto& frame = std::get<scheduler::FrameRecord>(*record);
    if (frame.robot == robot) frames_.emplace(frame.index, frame);
  }
}

std::optional<std::string> OneRobotsFrames::picture(const FrameJob& job) {
  const auto record = frames_.find(job.frame_index);
  if (record == frames_.end()) return std::nullopt;
  const std::lock_guard lock(reading_);
  return log_.picture(record->second);
}

Frame OneRobotsFrames::render(int robot, const FrameJob& job, int worker) {
  if (robot != robot_)
    return {.robot = job.robot, .frame_index = job.frame_index, .stamp = job.stamp};
  std::optional<std::string> png = picture(job);
  if (!png) {
    ++drawn_;
    return renderer_.render(robot, job, worker);
  }
  const std::string name =
      fmt::format("{}: frame {} of {}", log_.name(), job.frame_index, job.robot);
  const Image image = decode_png(std::move(*png), name);
  const render::Renderer& camera = renderer_.camera(robot);
  if (image.channels != 3 || image.bits != 8 || image.width_px != camera.width_px() ||
      image.height_px != camera.height_px())
    throw InputError(fmt::format("{}: found a picture of {} x {} px, expected the camera's {} x {}",
                                 name, image.width_px, image.height_px, camera.width_px(),
                                 camera.height_px()));
  Frame frame{.robot = job.robot,
              .frame_index = job.frame_index,
              .stamp = job.stamp,
              .width_px = image.width_px,
              .height_px = image.height_px,
              .rows = job.schedule.rows,
              .rgb = {image.samples.begin(), image.samples.end()},
              .fingerprint = frames_.at(job.frame_index).fingerprint};
  renderer_.develop(robot, frame);
  ++from_log_;
  return frame;
}

}  // namespace seam::app
