#include "tools/viewer/view_index.h"

#include <fmt/format.h>

#include <algorithm>

#include "app/logs/joint_names.h"
#include "tools/viewer/kept_ends.h"

namespace seam::tools {
namespace {

using scheduler::Answer;

// Beyond this a log of a talkative behaviour would not fit into memory.
constexpr size_t kMaxDebugItems = 500'000;
constexpr size_t kMostPrinted = 200'000;

void add(Series& series, double t, double value) {
  series.t.push_back(t);
  series.values.push_back(value);
}

class Indexer {
 public:
  Indexer(const scheduler::Log& log, ViewIndex& index) : index_(index), joints_(log.header()) {
    index_.robots.resize(log.header().robots.size());
    debug_.assign(index_.robots.size(), KeptEnds<DebugEntry>(kMaxDebugItems));
  }

  void finish() {
    for (size_t robot = 0; robot < debug_.size(); ++robot)
      index_.robots[robot].debug =
          debug_[robot].take([](const DebugEntry& before, uint64_t left_out) {
            DebugEntry note{.t = before.t};
            note.item.name = "viewer";
            note.item.text = fmt::format("{} values and texts from here on are left out", left_out);
            return note;
          });
  }

  void operator()(const scheduler::RunHeader&) {}
  void operator()(const scheduler::SnapshotRecord&) {}
  void operator()(const scheduler::EndRecord&) {}
  void operator()(const scheduler::SimulationEvent& event) { index_.events.push_back(event); }
  void operator()(const scheduler::FrameRecord& frame) {
    index_.robots[static_cast<size_t>(frame.robot)].frames.push_back(frame);
  }

  void operator()(const scheduler::StepRecord& step) {
    index_.step_times.push_back(step.time);
    index_.step_fingerprints.push_back(step.fingerprint);
    if (step.poses.size() != 6 * index_.robots.size() + 3) return;
    index_.pose_t.push_back(step.time.s());
    index_.poses.push_back(step.poses);
    for (size_t robot = 0; robot < index_.robots.size(); ++robot) {
      const size_t fields = joints_.lacks_head(robot) ? 3 : 6;
      for (size_t field = 0; field < fields; ++field) {
        add(index_.robots[robot].series[std::string(scheduler::kPoseFields[field])], step.time.s(),
            static_cast<double>(step.poses[6 * robot + field]));
      }
    }
  }

  void operator()(const scheduler::TurnRecord& turn) {
    for (const Answer& answer : turn.turn.answers) {
      // A decoded turn may name a robot that the header does not have.
      if (static_cast<size_t>(answer.robot) >= index_.robots.size()) continue;
      take(turn.time, answer);
    }
  }

 private:
  // Frames that are finished at an instant are sent with that instant's observation.
  static std::optional<uint64_t> newest_frame(const RobotIndex& robot, SimTime time) {
    const auto sent = std::find_if(robot.frames.rbegin(), robot.frames.rend(),
                                   [&](const auto& frame) { return frame.time <= time; });
    if (sent == robot.frames.rend()) return std::nullopt;
    return sent->index;
  }

  void take(SimTime time, const Answer& answer) {
    const double t = time.s();
    const auto place = static_cast<size_t>(answer.robot);
    RobotIndex& robot = index_.robots[place];
    const std::optional<uint64_t> frame_index = newest_frame(robot, time);
    robot.decisions.push_back({t, frame_index});
    const RobotCommand& command = answer.decision.command;
    if (command.walk) {
      add(robot.series["command.vx_m_s"], t, command.walk->vx_mps);
      add(robot.series["command.vy_m_s"], t, command.walk->vy_mps);
      add(robot.series["command.omega_rad_s"], t, command.walk->omega_radps);
    }
    for (const JointFrame& frame : command.joints) {
      for (const JointTarget& target : frame.targets) {
        const std::string joint = joints_.of(place, target.joint);
        add(robot.series["command." + joint + "_rad"], t + frame.offset.s(), target.angle_rad);
      }
    }
    for (const scheduler::DebugItem& item : answer.decision.debug) {
      if (item.kind == scheduler::DebugItem::Kind::value) {
        add(robot.series["debug." + item.name], t, item.value);
      }
      debug_[place].push({t, item, item.frame_index ? item.frame_index : frame_index});
    }
  }

  ViewIndex& index_;
  std::vector<KeptEnds<DebugEntry>> debug_;  // By robot.
  const app::JointNames joints_;
};

}  // namespace

ViewIndex index_log(const scheduler::Log& log) {
  using scheduler::Topic;
  ViewIndex index;
  Indexer indexer(log, index);
  scheduler::LogCursor cursor(log, {Topic::step, Topic::turn, Topic::frame, Topic::event});
  while (const auto record = cursor.next()) std::visit(indexer, *record);
  scheduler::PrintedCursor printed(log);
  indexer.finish();
  KeptEnds<scheduler::PrintedLine> lines(kMostPrinted);
  while (auto line = printed.next()) lines.push(std::move(*line));
  index.printed = lines.take([](const scheduler::PrintedLine& before, uint64_t left_out) {
    return scheduler::PrintedLine{before.time, before.robot,
                                  fmt::format("({} lines from here on are left out)", left_out)};
  });
  return index;
}

Series thinned(const Series& series, double from_s, double to_s, size_t points) {
  const auto begin = std::lower_bound(series.t.begin(), series.t.end(), from_s);
  const auto end = std::upper_bound(begin, series.t.end(), to_s);
  const auto first = static_cast<size_t>(begin - series.t.begin());
  const auto last = static_cast<size_t>(end - series.t.begin());
  Series out;
  if (last - first <= points) {
    out.t.assign(begin, end);
    out.values.assign(series.values.begin() + static_cast<ptrdiff_t>(first),
                      series.values.begin() + static_cast<ptrdiff_t>(last));
    return out;
  }
  const size_t buckets = std::max<size_t>(1, points / 4);
  for (size_t bucket = 0; bucket < buckets; ++bucket) {
    const size_t a = first + (last - first) * bucket / buckets;
    const size_t b = first + (last - first) * (bucket + 1) / buckets;
    if (a == b) continue;
    const auto values = series.values.begin();
    const auto [least, greatest] =
        std::minmax_element(values + static_cast<ptrdiff_t>(a), values + static_cast<ptrdiff_t>(b));
    std::vector<size_t> kept = {a, static_cast<size_t>(least - values),
                                static_cast<size_t>(greatest - values), b - 1};
    std::sort(kept.begin(), kept.end());
    kept.erase(std::unique(kept.begin(), kept.end()), kept.end());
    for (const size_t i : kept) add(out, series.t[i], series.values[i]);
  }
  return out;
}

}  // namespace seam::tools
