#include "scheduler/loop/frame_pipeline.h"

#include <algorithm>
#include <utility>

#include "sim_core/base/error.h"

namespace seam::scheduler {

namespace {

// Requests of one robot that wait for their frames.
constexpr size_t kMaxRequests = 64;
// Finished frames that nobody has collected (a robot that decides rarely): beyond this the loop
// waits for the oldest, so that memory stays bounded.
constexpr size_t kMaxPending = 64;

}  // namespace

FramePipeline::FramePipeline(const World& world, FrameRenderer& renderer, EventQueue& queue,
                             bool camera_at_rows, std::function<void(FinishedFrame)> on_finished)
    : world_(world),
      renderer_(renderer),
      queue_(queue),
      camera_at_rows_(camera_at_rows),
      on_finished_(std::move(on_finished)),
      pool_(renderer) {
  const Scenario& scenario = world.scenario();
  for (size_t i = 0; i < scenario.robots.size(); ++i) {
    const RobotSpec& robot = scenario.robots[i];
    const RandomStream stream = camera_stream(scenario, robot);
    Camera camera;
    camera.clock = Clock(clock_settings(robot.camera), stream.child("clock"));
    camera.noise = stream.child("noise");
    camera.X_LC = renderer.mount(static_cast<int>(i));
    cameras_.push_back(std::move(camera));
  }
}

bool FramePipeline::wanted(const Camera& camera, SimTime stamp) const {
  return camera.all || std::any_of(camera.requests.begin(), camera.requests.end(),
                                   [&](const FrameRequest& r) { return r.after <= stamp; });
}

void FramePipeline::request(int robot, const FrameRequest& request, SimTime now) {
  Camera& camera = cameras_[robot];
  switch (request.which) {
    case FrameRequest::Which::all:
      camera.all = true;
      break;
    case FrameRequest::Which::none:
      camera.all = false;
      camera.requests.clear();
      break;
    case FrameRequest::Which::next:
      if (camera.requests.size() < kMaxRequests) camera.requests.push_back(request);
      break;
  }
  arm(robot, now);
}

void FramePipeline::arm(int robot, SimTime now) {
  Camera& camera = cameras_[robot];
  if (camera.armed || (!camera.all && camera.requests.empty())) return;
  SimTime earliest = now;
  if (!camera.all) {
    SimTime after = camera.requests.front().after;
    for (const FrameRequest& request : camera.requests) after = std::min(after, request.after);
    earliest = std::max(now, after);
  }
  // A frame whose first row is exposed before its stamp (a negative line delay) begins earlier
  // than its tick; so the search starts at the tick before and looks at the light's own instants.
  int64_t tick = std::max(camera.next_tick, camera.clock.first_at_or_after(earliest) - 1);
  while (true) {
    const SimTime stamp = camera.clock.tick(tick);
    if (wanted(camera, stamp)) {
      RowSchedule schedule = renderer_.schedule(robot, static_cast<uint64_t>(tick), stamp);
      SEAM_CHECK(!schedule.instants.empty() && !schedule.rows.empty(), "robot {} tick {}", robot,
                 tick);
      if (schedule.instants.front() >= now) {
        InProgress frame = begin(robot, tick, stamp, std::move(schedule));
        if (frame.samples.front().time >= now) {
          camera.next_tick = tick + 1;
          camera.armed = true;
          for (FrameRequest& request : camera.requests)
            if (request.after <= stamp) --request.count;
          std::erase_if(camera.requests, [](const FrameRequest& r) { return r.count == 0; });
          push_next(robot, frame);
          camera.in_progress.push_back(std::move(frame));
          return;
        }
      }
    }
    ++tick;
  }
}

FramePipeline::InProgress FramePipeline::begin(int robot, int64_t tick, SimTime stamp,
                                               RowSchedule schedule) const {
  const Camera& camera = cameras_[robot];
  InProgress frame;
  frame.job = std::make_unique<FrameJob>();
  FrameJob& job = *frame.job;
  job.robot = world_.scenario().robots[robot].id;
  job.frame_index = static_cast<uint64_t>(tick);
  job.stamp = stamp;
  job.schedule = std::move(schedule);
  job.scenery = world_.scenery();
  job.background = world_.background();
  job.lighting = world_.lighting();
  job.camera_noise = camera.noise;
  job.frame_noise = camera.noise.child("frame").child(job.frame_index);
  job.instants.resize(job.schedule.instants.size());
  for (size_t i = 0; i < job.schedule.instants.size(); ++i)
    frame.samples.push_back({job.schedule.instants[i], static_cast<int>(i), -1});
  frame.end = frame.samples.back().time;
  for (const RowWindow& row : job.schedule.rows) frame.end = std::max(frame.end, row.end);
  if (camera_at_rows_) {
    job.row_cameras.resize(job.schedule.rows.size());
    for (size_t r = 0; r < job.schedule.rows.size(); ++r) {
      const RowWindow& row = job.schedule.rows[r];
      frame.samples.push_back({row.start + (row.end - row.start) / 2, -1, static_cast<int>(r)});
    }
    std::stable_sort(frame.samples.begin(), frame.samples.end(),
                     [](const Sample& a, const Sample& b) { return a.time < b.time; });
  }
  return frame;
}

void FramePipeline::push_next(int robot, InProgress& frame) {
  frame.event = cameras_[robot].events++;
  const auto source = static_cast<uint32_t>(robot + 1);
  if (frame.next < frame.samples.size())
    queue_.push({frame.samples[frame.next].time, Phase::sample_light, source, frame.event});
  else
    queue_.push({frame.end, Phase::finish_frames, source, frame.event});
}

void FramePipeline::record(int robot, InProgress& frame, const Sample& sample) {
  const auto viewer = static_cast<size_t>(robot);
  const Pose& X_LC = cameras_[robot].X_LC;
  if (sample.row >= 0)
    frame.job->row_cameras[sample.row] = world_.camera_link_pose(viewer, sample.time) * X_LC;
  else
    frame.job->instants[sample.instant] = world_.view_of(viewer, sample.time, X_LC);
}

void FramePipeline::sample(int robot, const EventKey& key) {
  Camera& camera = cameras_[robot];
  const auto found = std::find_if(camera.in_progress.begin(), camera.in_progress.end(),
                                  [&](const InProgress& f) { return f.event == key.sequence; });
  SEAM_CHECK(found != camera.in_progress.end(), "no frame for {}", to_string(key));
  while (found->next < found->samples.size() && found->samples[found->next].time == key.time)
    record(robot, *found, found->samples[found->next++]);
  push_next(robot, *found);
  if (!std::exchange(found->begun, true)) {
    camera.armed = false;
    arm(robot, key.time);
  }
}

void FramePipeline::finish(int robot, const EventKey& key) {
  Camera& camera = cameras_[robot];
  const auto found = std::find_if(camera.in_progress.begin(), camera.in_progress.end(),
                                  [&](const InProgress& f) { return f.event == key.sequence; });
  SEAM_CHECK(found != camera.in_progress.end(), "no frame for {}", to_string(key));
  std::unique_ptr<const FrameJob> job = std::move(found->job);
  camera.in_progress.erase(found);
  ++camera.uncollected;
  std::future<Frame> frame = pool_.submit(robot, *job);
  pending_.push_back({robot, key.time, std::move(job), std::move(frame)});
  if (pending_.size() > kMaxPending) collect_first();
}

void FramePipeline::collect_first() {
  Pending first = std::move(pending_.front());
  pending_.pop_front();
  --cameras_[first.robot].uncollected;
  auto frame = std::make_shared<const Frame>(first.frame.get());
  on_finished_({first.robot, first.time, std::move(first.job), std::move(frame)});
}

void FramePipeline::collect(int robot) {
  while (cameras_[robot].uncollected > 0) collect_first();
}

void FramePipeline::collect_all() {
  while (!pending_.empty()) collect_first();
}

}  // namespace seam::scheduler
