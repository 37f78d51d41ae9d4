#include "tools/viewer/view_data.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "app/logs/replay_match.h"
#include "app/trust/tokens.h"
#include "render/ground_truth.h"
#include "scheduler/replay/frame_maker.h"
#include "sim_core/base/error.h"
#include "sim_core/base/hash.h"
#include "sim_core/base/image.h"
#include "tools/viewer/joint_series.h"
#include "tools/viewer/view_index.h"
#include "tools/viewer/view_pictures.h"
#include "tools/viewer/view_records.h"
#include "tools/viewer/view_scenery.h"

namespace seam::tools {
namespace {

using nlohmann::json;

constexpr size_t kMostFramesACall = 5000;
constexpr size_t kCachedFrames = 48;

const char* end_text(const std::optional<scheduler::EndRecord>& end) {
  constexpr const char* kWords[] = {"finished", "stopped", "aborted"};
  return end ? kWords[static_cast<int>(end->reason)] : "unknown";
}

}  // namespace

struct ViewData::Impl {
  explicit Impl(scheduler::Log opened, std::string log_id) : log(std::move(opened)), id(log_id) {
    index = index_log(log);
  }

  std::mutex mutex;
  scheduler::Log log;
  std::string id;
  ViewIndex index;
  bool has_joints = false;  // See joint_series.h.
  std::optional<app::ReplayMatch> match_;
  std::string info, events;  // Made when they are first asked for.
  struct Made {
    int robot;
    std::unique_ptr<const FrameJob> job;
    std::shared_ptr<const Frame> frame;
  };
  std::vector<Made> made;  // The last ones first.

  app::ReplayMatch& match() {
    if (!match_) match_.emplace(log);
    return *match_;
  }

  // The log's world runs again for it: when it is first asked for.
  void add_joints() {
    if (!std::exchange(has_joints, true)) add_joint_series(match(), index);
  }

  int robot(const Query& query) {
    const std::string id = text_of(query, "robot", "");
    const auto& robots = log.header().robots;
    const auto found = std::find(robots.begin(), robots.end(), id);
    if (found == robots.end()) throw NotFound("robot: there is no '" + id.substr(0, 80) + "'");
    return static_cast<int>(found - robots.begin());
  }

  RobotIndex& robot_index(const Query& query) {
    return index.robots[static_cast<size_t>(robot(query))];
  }

  // By `index`, or the last one whose stamp is at or before `t`; the first where none is.
  int64_t frame_index(const Query& query, int robot) {
    if (query.contains("index")) return integer_of(query, "index", 0);
    const Clock clock = scheduler::camera_clock(match().scenario(), robot);
    const SimTime time = SimTime::from_s(number_of(query, "t", 0));
    return std::max<int64_t>(0, clock.first_at_or_after(time + SimDuration::from_ns(1)) - 1);
  }

  using Clock = scheduler::Clock;

  const scheduler::FrameRecord* recorded(int robot, int64_t frame) const {
    for (const auto& record : index.robots[static_cast<size_t>(robot)].frames) {
      if (record.index == static_cast<uint64_t>(frame)) return &record;
    }
    return nullptr;
  }

  const Made& make(int robot, int64_t frame) {
    for (size_t i = 0; i < made.size(); ++i) {
      if (made[i].robot != robot || made[i].frame->frame_index != static_cast<uint64_t>(frame))
        continue;
      std::rotate(made.begin(), made.begin() + static_cast<ptrdiff_t>(i),
                  made.begin() + static_cast<ptrdiff_t>(i) + 1);
      return made.front();
    }
    if (frame < 0) throw NotFound("there is no frame before the first");
    const SimTime stamp = scheduler::camera_clock(match().scenario(), robot).tick(frame);
    if (stamp > log.end_time()) throw NotFound("the log ends before this frame");
    bool found = false;
    scheduler::make_frames(
        match().rewinder(), match().renderer(), robot, stamp, stamp,
        [&](const scheduler::FinishedFrame& finished) {
          made.insert(made.begin(),
                      {robot, std::make_unique<FrameJob>(*finished.job), finished.frame});
          found = true;
        });
    if (!found) throw NotFound("the log ends before this frame does");
    if (made.size() > kCachedFrames) made.pop_back();
    return made.front();
  }

  std::vector<std::string> stages() {
    std::vector<std::string> names = {"rgb", "ycrcb", "labels", "depth"};
    try {
      const Made& first = make(0, 0);
      for (const auto& stage : match().renderer().camera(0).stages(*first.job)) {
        if (std::find(names.begin(), names.end(), stage.name) == names.end()) {
          names.push_back(stage.name);
        }
      }
    } catch (const std::exception&) {
      // A log too short for a frame, or one that cannot be re-run, still has its other data.
    }
    return names;
  }
};

namespace {

// Damaged logs are shown too: as much of them as can be read.
scheduler::Log open_for_view(const std::string& path) {
  try {
    scheduler::Log log = scheduler::Log::open(path);
    index_log(log);
    return log;
  } catch (const InputError&) {
    return scheduler::Log::open(path, scheduler::LogAccess::scanned);
  }
}

}  // namespace

ViewData::ViewData(const std::string& path, std::string id)
    : impl_(std::make_unique<Impl>(open_for_view(path), std::move(id))) {}
ViewData::~ViewData() = default;

const scheduler::Log& ViewData::log() const {
  return impl_->log;
}

std::string ViewData::info() {
  const std::lock_guard lock(impl_->mutex);
  if (!impl_->info.empty()) return impl_->info;
  const scheduler::Log& log = impl_->log;
  const scheduler::RunHeader& header = log.header();
  const auto end = log.end();
  json info = {{"id", impl_->id},
               {"file", std::filesystem::path(log.name()).filename().string()},
               {"bytes", log.file().file_bytes()},
               {"scenario", header.scenario_name},
               {"scenario_text", app::shown_scenario(header.scenario_text, header.scenario_name)},
               {"seed", std::to_string(header.seed)},
               {"start_s", 0},
               {"end_s", log.end_time().s()},
               {"complete", log.file().contents().complete},
               {"end_reason", end_text(end)},
               {"fingerprint", end ? to_hex(end->fingerprint) : ""},
               {"joints", {"tilt", "pan", "roll"}},
               {"sections", header.sections},
               {"has_frames", log.has_pictures()},
               {"losses", json::array()},
               {"versions", json::object()}};
  for (const auto& [name, version] : header.versions) info["versions"][name] = version;
  for (const mcap::Loss& loss : log.file().contents().losses) info["losses"].push_back(loss.what);
  app::ReplayMatch& match = impl_->match();
  const Scenario& scenario = match.scenario();
  info["step_s"] = scenario.step.s();
  info["robots"] = robots_of(scenario);
  if (scenario.has_field)
    info["field"] = {{"length_m", 2 * scenario.field.half_length_m},
                     {"width_m", 2 * scenario.field.half_width_m}};
  const render::GlDevice* opengl = match.renderer().options().opengl;
  info["scenery"] = scenery_of(match.world(), opengl != nullptr ? &opengl->assets() : nullptr);
  info["stages"] = impl_->stages();
  return impl_->info = info.dump(-1, ' ', false, json::error_handler_t::replace);
}

std::string ViewData::truth(const Query& query) {
  const std::lock_guard lock(impl_->mutex);
  impl_->add_joints();
  const double from = number_of(query, "from", 0);
  const double to = std::min(number_of(query, "to", from + 10), from + 120);
  const auto every = static_cast<size_t>(std::max<int64_t>(1, integer_of(query, "every", 1)));
  const ViewIndex& index = impl_->index;
  const auto& robots = impl_->log.header().robots;
  json times = json::array(), ball = json::array(), poses = json::object();
  for (const std::string& robot : robots) poses[robot] = json::array();
  const auto begin = static_cast<size_t>(
      std::lower_bound(index.pose_t.begin(), index.pose_t.end(), from) - index.pose_t.begin());
  // Each n-th row of the whole run, so that calls side by side fit together.
  for (size_t row = begin; row < index.pose_t.size() && index.pose_t[row] < to; ++row) {
    if (row % every != 0) continue;
    const std::vector<float>& values = index.poses[row];
    times.push_back(index.pose_t[row]);
    for (size_t i = 0; i < robots.size(); ++i) {
      std::vector<float> numbers(values.begin() + static_cast<ptrdiff_t>(6 * i),
                                 values.begin() + static_cast<ptrdiff_t>(6 * i + 6));
      if (row < index.robots[i].cameras.size()) {
        const CameraPlace& camera = index.robots[i].cameras[row];
        numbers.insert(numbers.end(),
                       {camera.x_m, camera.y_m, camera.heading_rad, camera.elevation_rad});
      }
      poses[robots[i]].push_back(std::move(numbers));
    }
    ball.push_back(std::vector<float>(values.end() - 3, values.end()));
  }
  json truth = {{"t", std::move(times)}, {"robots", std::move(poses)}};
  if (impl_->match().scenario().ball.present) truth["ball"] = std::move(ball);
  return truth.dump();
}

std::string ViewData::state(const Query& query) {
  const std::lock_guard lock(impl_->mutex);
  const SimTime time = SimTime::from_s(number_of(query, "t", 0));
  const auto& times = impl_->index.step_times;
  const auto next = std::upper_bound(times.begin(), times.end(), time);
  if (next == times.begin()) throw NotFound("there is no step at or before this time");
  const SimTime step_time = *(next - 1);
  app::ReplayMatch& match = impl_->match();
  match.rewinder().to(step_time);
  json sections = json::array();
  for (const StateSection& section : match.world().sections()) {
    json fields = json::array();
    for (const auto& field : section.fields) {
      std::visit([&](auto value) { fields.push_back({field.name, value}); }, field.value);
    }
    sections.push_back(
        {{"name", section.name}, {"hash", to_hex(section.hash())}, {"fields", std::move(fields)}});
  }
  const auto row = static_cast<size_t>(next - times.begin()) - 1;
  return json{{"time_ns", std::to_string(step_time.ns())},
              {"step", match.rewinder().step()},
              {"fingerprint", to_hex(impl_->index.step_fingerprints[row])},
              {"sections", std::move(sections)}}
      .dump();
}

std::string ViewData::events(const Query&) {
  const std::lock_guard lock(impl_->mutex);
  std::string& made = impl_->events;
  if (made.empty()) made = events_of(impl_->index);
  return made;
}

std::string ViewData::find(const Query& query) {
  const std::lock_guard lock(impl_->mutex);
  return find_answer(impl_->log, query);
}

std::string ViewData::lanes(const Query& query) {
  const std::lock_guard lock(impl_->mutex);
  return lanes_of(impl_->robot_index(query), query, impl_->log.end_time().s()).dump();
}

std::string ViewData::steps(const Query& query) {
  const std::lock_guard lock(impl_->mutex);
  const double from = number_of(query, "from", 0);
  const double to = std::min(number_of(query, "to", from + 1), from + 10);
  json times = json::array();
  const auto& steps = impl_->index.step_times;
  auto step = std::lower_bound(steps.begin(), steps.end(), SimTime::from_s(from));
  for (; step != steps.end() && *step < SimTime::from_s(to); ++step) times.push_back(step->s());
  return json{{"t", std::move(times)}}.dump();
}

std::string ViewData::decisions(const Query& query) {
  const std::lock_guard lock(impl_->mutex);
  const double from = number_of(query, "from", 0);
  const double to = std::min(number_of(query, "to", from + 10), from + 60);
  return json{{"decisions", json_of(impl_->robot_index(query).decisions, from, to)}}.dump();
}

std::string ViewData::debug(const Query& query) {
  const std::lock_guard lock(impl_->mutex);
  const RobotIndex& robot = impl_->robot_index(query);
  const double from = number_of(query, "from", 0);
  const double to = number_of(query, "to", from + 10);
  auto entry = std::lower_bound(robot.debug.begin(), robot.debug.end(), from,
                                [](const DebugEntry& e, double t) { return e.t < t; });
  json items = json::array();
  for (; entry != robot.debug.end() && entry->t < to; ++entry) items.push_back(json_of(*entry));
  return json{{"items", std::move(items)}}.dump(-1, ' ', false, json::error_handler_t::replace);
}

std::string ViewData::series(const Query& query) {
  const std::lock_guard lock(impl_->mutex);
  impl_->add_joints();
  const RobotIndex& robot = impl_->robot_index(query);
  const std::string names = text_of(query, "names", "");
  if (names.empty()) {
    json all = json::array();
    for (const auto& [name, series] : robot.series) all.push_back(name);
    return json{{"names", std::move(all)}}.dump(-1, ' ', false, json::error_handler_t::replace);
  }
  const double from = number_of(query, "from", 0);
  const double to = number_of(query, "to", impl_->log.end_time().s());
  const auto points =
      static_cast<size_t>(std::clamp<int64_t>(integer_of(query, "points", 1000), 4, 20000));
  json out = json::object();
  for (size_t start = 0; start <= names.size();) {
    const size_t comma = std::min(names.find(',', start), names.size());
    const std::string name = names.substr(start, comma - start);
    start = comma + 1;
    const auto found = robot.series.find(name);
    if (found == robot.series.end())
      throw NotFound("names: there is no '" + name.substr(0, 80) + "'");
    const Series thin = thinned(found->second, from, to, points);
    out[name] = {{"t", thin.t}, {"values", thin.values}};
  }
  return json{{"series", std::move(out)}}.dump(-1, ' ', false, json::error_handler_t::replace);
}

std::string ViewData::frames(const Query& query) {
  const std::lock_guard lock(impl_->mutex);
  const int number = impl_->robot(query);
  const double from = number_of(query, "from", -1e9);
  const double to = number_of(query, "to", 9e9);
  json frames = json::array();
  bool more = false;
  for (const auto& frame : impl_->index.robots[static_cast<size_t>(number)].frames) {
    if (frame.stamp.s() < from || frame.stamp.s() > to) continue;
    if (frames.size() == kMostFramesACall) {
      more = true;
      break;
    }
    frames.push_back({{"index", frame.index},
                      {"t", frame.stamp.s()},
                      {"stamp_ns", std::to_string(frame.stamp.ns())},
                      {"recorded", impl_->log.has_pictures()},
                      {"fingerprint", to_hex(frame.fingerprint)}});
  }
  const scheduler::Clock clock = scheduler::camera_clock(impl_->match().scenario(), number);
  return json{
      {"frames", std::move(frames)},
      {"more", more},
      {"period_s", clock.settings().period.s() / static_cast<double>(clock.settings().divisor)}}
      .dump();
}

std::string ViewData::frame_rows(const Query& query) {
  const std::lock_guard lock(impl_->mutex);
  const int robot = impl_->robot(query);
  const Impl::Made& made = impl_->make(robot, impl_->frame_index(query, robot));
  json rows = json::array();
  for (size_t row = 0; row < made.frame->rows.size() && row < made.job->row_cameras.size(); ++row)
    rows.push_back(json_of(made.frame->rows[row], made.job->row_cameras[row]));
  return json{{"index", made.frame->frame_index},
              {"stamp_ns", std::to_string(made.frame->stamp.ns())},
              {"fingerprint", to_hex(made.frame->fingerprint)},
              {"rows", std::move(rows)}}
      .dump();
}

ViewPicture ViewData::frame(const Query& query) {
  const std::lock_guard lock(impl_->mutex);
  const int robot = impl_->robot(query);
  const int64_t index = impl_->frame_index(query, robot);
  const std::string stage = text_of(query, "stage", "rgb");
  const scheduler::FrameRecord* record = impl_->recorded(robot, index);
  if (stage == "rgb" && record != nullptr && impl_->log.has_pictures()) {
    if (std::optional<std::string> png = impl_->log.picture(*record)) {
      return {std::move(*png),
              {{"X-Seam-Index", std::to_string(index)},
               {"X-Seam-Stamp-Ns", std::to_string(record->stamp.ns())},
               {"X-Seam-Recorded", "1"},
               {"X-Seam-Fingerprint", to_hex(record->fingerprint)},
               {"X-Seam-Matches", "-"}}};
    }
  }
  const Impl::Made& made = impl_->make(robot, index);
  const std::string matches =
      record == nullptr ? "-" : (record->fingerprint == made.frame->fingerprint ? "1" : "0");
  const std::optional<Image> image =
      picture_of_stage(stage, *made.job, *made.frame, impl_->match().renderer().camera(robot));
  if (!image) throw NotFound("stage: there is no '" + stage.substr(0, 80) + "'");
  return {encode_png(*image),
          {{"X-Seam-Index", std::to_string(index)},
           {"X-Seam-Stamp-Ns", std::to_string(made.frame->stamp.ns())},
           {"X-Seam-Recorded", "0"},
           {"X-Seam-Fingerprint", to_hex(made.frame->fingerprint)},
           {"X-Seam-Matches", matches}}};
}

}  // namespace seam::tools
