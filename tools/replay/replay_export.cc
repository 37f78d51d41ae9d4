// `seam replay export F --out DIR`: a log as CSV files and pictures.
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <map>
#include <optional>

#include "app/logs/joint_names.h"
#include "app/logs/replay_match.h"
#include "app/trust/tokens.h"
#include "sim_core/base/error.h"
#include "sim_core/base/hash.h"
#include "sim_core/base/output.h"
#include "sim_core/input/file_names.h"
#include "sim_core/input/shown_text.h"
#include "tools/command.h"
#include "tools/replay/replay.h"

namespace seam::tools {
namespace {

namespace fs = std::filesystem;
using scheduler::Answer;

struct ExportSettings {
  std::string file;
  std::string out;
};

// Text as one CSV cell.
std::string cell(const std::string& text) {
  if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
  return quoted + "\"";
}

// The decimal number of a time in seconds: 22.24, not 22.240000000000002.
double decimal_s(SimTime time) {
  return static_cast<double>(time.ns()) / 1e9;
}

// Where the robots are at any time, by running the log's world again; nothing where that cannot be.
class Places {
 public:
  explicit Places(const scheduler::Log& log) {
    try {
      match_.emplace(log);
      match_->rewinder();
    } catch (const InputError& error) {
      give_up(error);
    }
  }

  // The columns kPlaceColumns, blank where they are not known.
  std::string cells(SimTime time, int robot) {
    try {
      if (match_) return known_cells(match_->rewinder().to(time), static_cast<size_t>(robot));
    } catch (const InputError& error) {
      give_up(error);
    }
    return std::string(std::count(kPlaceColumns.begin(), kPlaceColumns.end(), ','), ',');
  }
  // Why places are blank; empty where none is.
  const std::string& trouble() const { return trouble_; }

  static constexpr std::string_view kPlaceColumns =
      "x_m,y_m,heading_rad,tilt_rad,pan_rad,roll_rad,ball_x_m,ball_y_m,ball_z_m";

 private:
  void give_up(const InputError& error) {
    trouble_ = error.what();
    match_.reset();
  }

  std::string known_cells(SimTime time, size_t robot) {
    const RobotTruth truth = match_->world().robot(robot, time);
    std::string line =
        fmt::format("{},{},{}", truth.pose.x_m, truth.pose.y_m, truth.pose.theta_rad);
    if (match_->scenario().robots[robot].body.tree.present())
      line += ",,,";
    else
      line += fmt::format(",{},{},{}", truth.joints_rad[kTilt], truth.joints_rad[kPan],
                          truth.joints_rad[kRoll]);
    if (!match_->scenario().ball.present) return line + ",,,";
    const Vec3 ball = match_->world().ball(time).p_W;
    return line + fmt::format(",{},{},{}", ball.x, ball.y, ball.z);
  }

  std::optional<app::ReplayMatch> match_;
  std::string trouble_;
};

class CsvFile {
 public:
  CsvFile(const fs::path& path, const std::string& header) : file_(path), text_(header + "\n") {}
  template <typename... Cells>
  void row(const Cells&... cells) {
    std::string line;
    ((line += line.empty() ? fmt::format("{}", cells) : fmt::format(",{}", cells)), ...);
    text_ += line + "\n";
    if (text_.size() > kBufferedBytes) flush();
  }
  void finish() {
    flush();
    file_.commit();
  }

 private:
  static constexpr size_t kBufferedBytes = 1 << 16;
  void flush() {
    file_.write(text_);
    text_.clear();
  }

  OutputFile file_;
  std::string text_;  // Not written yet.
};

const char* outcome_text(scheduler::Outcome outcome) {
  constexpr const char* kWords[] = {"decided", "frozen", "absent", "resumed", "abort"};
  return kWords[static_cast<int>(outcome)];
}

const char* kind_text(scheduler::EventKind kind) {
  constexpr const char* kWords[] = {"referee", "radio", "world", "policy", "fault", "debug"};
  return kWords[static_cast<int>(kind)];
}

class Exporter {
 public:
  Exporter(const scheduler::Log& log, const fs::path& folder)
      : log_(log),
        names_(log.header()),
        folder_(folder),
        places_(log),
        poses_(folder / "poses.csv",
               "time_ns,time_s,robot,x_m,y_m,heading_rad,tilt_rad,pan_rad,roll_rad"),
        ball_(folder / "ball.csv", "time_ns,time_s,x_m,y_m,z_m"),
        steps_(folder / "steps.csv", "time_ns,time_s,step,fingerprint"),
        decisions_(folder / "decisions.csv",
                   "time_ns,time_s,robot,sequence,frame,outcome,vx_mps,vy_mps,omega_radps,kick,"
                   "frame_requests,messages,reason," +
                       std::string(Places::kPlaceColumns)),
        joints_(folder / "joint_commands.csv",
                "time_ns,time_s,robot,offset_s,joint,angle_rad,speed_radps"),
        debug_(folder / "debug.csv", "time_ns,time_s,robot,name,kind,value"),
        frames_(folder / "frames.csv",
                "robot,frame,stamp_ns,stamp_s,end_ns,end_s,fingerprint,file"),
        events_(folder / "events.csv", "time_ns,time_s,kind,robot,name,detail") {}

  void operator()(const scheduler::RunHeader&) {}
  void operator()(const scheduler::SnapshotRecord&) {}
  void operator()(const scheduler::EndRecord&) {}

  void operator()(const scheduler::StepRecord& step) {
    steps_.row(step.time.ns(), decimal_s(step.time), step.step, to_hex(step.fingerprint));
    const auto& robots = log_.header().robots;
    if (step.poses.size() != 6 * robots.size() + 3) return;
    for (size_t i = 0; i < robots.size(); ++i) {
      const float* pose = &step.poses[6 * i];
      poses_.row(step.time.ns(), decimal_s(step.time), cell(robots[i]), pose[0], pose[1], pose[2],
                 pose[3], pose[4], pose[5]);
    }
    const float* ball = &step.poses[6 * robots.size()];
    ball_.row(step.time.ns(), decimal_s(step.time), ball[0], ball[1], ball[2]);
  }

  void operator()(const scheduler::TurnRecord& turn) {
    for (const Answer& answer : turn.turn.answers) write(turn.time, answer);
  }

  void operator()(const scheduler::FrameRecord& frame) {
    newest_frames_[frame.robot] = frame.index;
    const std::string& robot = log_.header().robots[static_cast<size_t>(frame.robot)];
    std::string name;
    if (const auto png = log_.has_pictures() ? log_.picture(frame) : std::nullopt) {
      name = fmt::format("{}_{:06}.png", robot, frame.index);
      write_file(name, *png);
    }
    frames_.row(cell(robot), frame.index, frame.stamp.ns(), decimal_s(frame.stamp), frame.time.ns(),
                decimal_s(frame.time), to_hex(frame.fingerprint), name);
  }

  void operator()(const scheduler::SimulationEvent& event) {
    events_.row(event.time.ns(), decimal_s(event.time), kind_text(event.kind), cell(event.robot),
                cell(event.name), cell(event.detail));
  }

  void write_file(const std::string& name, const std::string& bytes) {
    write_file_atomically(path_inside(folder_, name), bytes);
  }

  void finish() {
    for (CsvFile* file :
         {&poses_, &ball_, &steps_, &decisions_, &joints_, &debug_, &frames_, &events_})
      file->finish();
  }

  // Why poses at decisions are blank; empty where none is.
  const std::string& trouble() const { return places_.trouble(); }

 private:
  void write(SimTime time, const Answer& answer) {
    const std::string robot = cell(log_.header().robots[static_cast<size_t>(answer.robot)]);
    const RobotCommand& command = answer.decision.command;
    const auto walk = [&](double BodyVelocity::*part) {
      return command.walk ? fmt::format("{}", (*command.walk).*part) : std::string();
    };
    const auto frame = newest_frames_.find(answer.robot);
    const std::string newest =
        frame == newest_frames_.end() ? "" : fmt::format("{}", frame->second);
    decisions_.row(
        time.ns(), decimal_s(time), robot, answer.sequence, newest, outcome_text(answer.outcome),
        walk(&BodyVelocity::vx_mps), walk(&BodyVelocity::vy_mps), walk(&BodyVelocity::omega_radps),
        to_string(command.kick), answer.decision.frame_requests.size(),
        answer.decision.messages.size(), cell(answer.reason), places_.cells(time, answer.robot));
    for (const JointFrame& frame : command.joints) {
      for (const JointTarget& target : frame.targets) {
        joints_.row(time.ns(), decimal_s(time), robot, static_cast<double>(frame.offset.ns()) / 1e9,
                    cell(names_.of(static_cast<size_t>(answer.robot), target.joint)),
                    target.angle_rad, target.speed_radps);
      }
    }
    for (const scheduler::DebugItem& item : answer.decision.debug) write(time, robot, item);
  }

  void write(SimTime time, const std::string& robot, const scheduler::DebugItem& item) {
    using Kind = scheduler::DebugItem::Kind;
    if (item.kind == Kind::value) {
      debug_.row(time.ns(), decimal_s(time), robot, cell(item.name), "value", item.value);
    } else if (item.kind == Kind::text) {
      debug_.row(time.ns(), decimal_s(time), robot, cell(item.name), "text", cell(item.text));
    } else {
      debug_.row(time.ns(), decimal_s(time), robot, cell(item.name),
                 item.in_image ? "image" : "field", fmt::format("{}", fmt::join(item.points, " ")));
    }
  }

  const scheduler::Log& log_;
  const app::JointNames names_;
  fs::path folder_;
  Places places_;
  std::map<int, uint64_t> newest_frames_;  // Sent to a robot until now.
  CsvFile poses_, ball_, steps_, decisions_, joints_, debug_, frames_, events_;
};

void export_log(const ExportSettings& settings) {
  make_output_folder(settings.out);
  const scheduler::Log log = scheduler::Log::open(settings.file);
  Exporter exporter(log, settings.out);
  exporter.write_file("scenario.yaml", app::shown_scenario(log.header().scenario_text, log.name()));
  using scheduler::Topic;
  scheduler::LogCursor cursor(log, {Topic::turn, Topic::step, Topic::frame, Topic::event});
  uint64_t records = 0;
  while (const auto record = cursor.next()) {
    std::visit(exporter, *record);
    ++records;
  }
  exporter.finish();
  if (!exporter.trouble().empty())
    std::printf("decisions.csv has blank places: %s\n", shown(exporter.trouble()).c_str());
  std::printf("%s: %llu records as CSV%s\n", settings.out.c_str(),
              static_cast<unsigned long long>(records),
              log.has_pictures() ? " and pictures"
                                 : "; the log holds no pictures: seam replay frames makes them");
}

}  // namespace

void add_replay_export(app::Command replay) {
  app::Command command = replay.add_subcommand(
      "export", "Writes poses, decisions, frames and events as CSV, and the pictures of the log");
  auto settings = std::make_shared<ExportSettings>();
  command.add_option("F", settings->file, "The log").required();
  command.add_option("--out", settings->out, "Folder to write to").required();
  command.footer("Example: seam replay export match.mcap --out match");
  command.callback([settings] { export_log(*settings); });
}

}  // namespace seam::tools
