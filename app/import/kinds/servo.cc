// `seam import servo`: logs of commanded and measured angles, as CSV, JSON or NPZ.
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "app/import/draft/checks.h"
#include "app/import/draft/reversal.h"
#include "app/import/files/signals.h"
#include "app/import/kinds/kinds.h"
#include "app/import/servo/servo_columns.h"
#include "app/import/servo/servo_join.h"
#include "app/import/servo/servo_words.h"
#include "sim_core/base/error.h"

namespace seam::app {
namespace {

using Names = std::vector<std::string>;
constexpr const char* kEnabled = "torque_enable";
constexpr const char* kEffort = "effort_nm";

class ServoImport {
 public:
  ServoImport(const ImportRequest& request, SetDraft& draft)
      : request_(request), draft_(draft), reversal_(request_) {}
  void run();

 private:
  size_t time_in(const SignalLog& log) const {
    return servo_signal(request_, log, "time", servo_names().times);
  }
  void add_log(const SignalLog& log, const std::vector<JointColumns>& joints,
               const std::string& run);
  void add_rows(const SignalLog& log, const std::string& run, const JointColumns& joint,
                const std::vector<size_t>& rows, size_t time);
  void look_at(const std::vector<double>& command, const std::vector<double>& measured,
               const RowPlace& place);
  void look_at_words();
  void keep_ours();
  void keep_others();
  std::string cell(const SignalLog& log, const JointColumns& joint, const std::string& column,
                   size_t row, bool off) const;
  void write();

  ImportRequest request_;
  SetDraft& draft_;
  Reversal reversal_;
  std::vector<SignalLog> logs_;
  std::vector<std::vector<JointColumns>> joints_of_;  // By log.
  std::vector<std::string> extra_;       // Columns beside ours, by their name in the set.
  std::map<std::string, Names> called_;  // What they are called in the files.
  std::map<std::string, int> place_;     // Of these columns, in the log that is being added.
  std::set<std::string> taken_;          // Signals with a use of their own, by name.
  std::vector<std::vector<std::string>> rows_;
  std::set<std::string> runs_, joints_;
  std::set<std::string> named_units_;  // Of angles, where columns say them.
  size_t repeated_ = 0, stale_ = 0, off_ = 0;
};

// What the pair of columns says of itself: a command that is the measurement, or follows it.
void ServoImport::look_at(const std::vector<double>& command, const std::vector<double>& measured,
                          const RowPlace& place) {
  const size_t n = command.size();
  if (n < 20) return;
  const auto [least, most] = std::minmax_element(measured.begin(), measured.end());
  if (*most - *least < 1e-9) {
    draft_.warn(fmt::format("{}: the joint never moves in this run", place(0)));
    return;
  }
  if (command == measured)
    throw InputError(
        fmt::format("{}: command and measurement are equal in every row: the command column is "
                    "really the measurement, expected what was asked of the servo (--map)",
                    place(0)));
}

std::string ServoImport::cell(const SignalLog& log, const JointColumns& joint,
                              const std::string& column, size_t row, bool off) const {
  if (column == kEffort) {
    // Torques count the way that the angles do.
    const auto& reversed = request_.reversed;
    const bool turned = std::find(reversed.begin(), reversed.end(), joint.joint) != reversed.end();
    const double effort = joint.effort ? log.values[*joint.effort][row] : NAN;
    return std::isfinite(effort) ? exact(turned ? -effort : effort) : "";
  }
  if (off && column == kEnabled) return "0";
  if (column == kEnabled && called_.at(column).empty()) return "1";
  const int at = place_.at(column);
  double value = NAN;
  if (at >= 0) {
    value = log.values[static_cast<size_t>(at)][row];
  } else {
    for (const std::string& name : called_.at(column)) {
      const auto constant = log.constants.find(name);
      if (constant != log.constants.end()) value = constant->second;
    }
  }
  return std::isfinite(value) ? exact(value) : "";
}

void ServoImport::add_rows(const SignalLog& log, const std::string& run, const JointColumns& joint,
                           const std::vector<size_t>& rows, size_t time) {
  const int64_t unit = time_unit_ns(request_, log.full_names[time]);
  std::vector<int64_t> ns;
  std::vector<double> command, measured;
  std::vector<size_t> kept;
  const std::vector<char> off = servo_off_rows(request_, log, joint);
  const RowPlace place = [&](size_t i) { return log.places[kept[i]]; };
  for (const size_t row : rows) {
    const double t = log.values[time][row];
    kept.push_back(row);
    if (!std::isfinite(t) || std::abs(t) * static_cast<double>(unit) > 9e18)
      throw InputError(
          fmt::format("{}: {}: found '{}', expected a time", log.places[row], log.names[time], t));
    // A double holds the milliseconds and so on of an epoch to less than a microsecond.
    const bool is_exact = !log.exact_ns.empty() && unit == nanoseconds_in("s");
    const int64_t at =
        is_exact ? log.exact_ns[time][row] : std::llround(t * static_cast<double>(unit));
    if (!ns.empty() && at == ns.back()) {
      ++repeated_;
      kept.pop_back();
      continue;
    }
    ns.push_back(at);
    const double asked = log.values[joint.command][row];
    // Where the drive is off no command is needed: the last one stays.
    const bool holds = off[row] != 0 && !std::isfinite(asked);
    command.push_back(!holds ? asked : command.empty() ? 0 : command.back());
    measured.push_back(log.values[joint.measured][row]);
  }
  check_times(ns, place, request_, 0.5, draft_);
  const auto in_radians = [&](std::vector<double>& values, size_t column) {
    ImportRequest own = request_;
    if (own.unit.empty()) own.unit = angle_unit_in(log.full_names[column]);
    if (own.unit != request_.unit && own.unit != "rad") named_units_.insert(own.unit);
    to_radians(values, log.names[column], place, own, draft_);
  };
  in_radians(command, joint.command);
  in_radians(measured, joint.measured);
  reversal_.apply(joint.joint, command, measured);
  look_at(command, measured, place);
  size_t longest = 0, same = 0;
  for (size_t i = 0; i < ns.size(); ++i) {
    same = i > 0 && measured[i] == measured[i - 1] && command[i] != command[i - 1] ? same + 1 : 0;
    longest = std::max(longest, same);
    std::vector<std::string> cells = {run, seconds_text(ns[i]), joint.joint, exact(command[i]),
                                      exact(measured[i])};
    const bool is_off = off[kept[i]] != 0;
    off_ += is_off ? 1 : 0;
    for (const std::string& column : extra_)
      cells.push_back(cell(log, joint, column, kept[i], is_off));
    rows_.push_back(std::move(cells));
  }
  stale_ = std::max(stale_, longest);
  joints_.insert(joint.joint);
}

void ServoImport::add_log(const SignalLog& log, const std::vector<JointColumns>& joints,
                          const std::string& run) {
  const size_t time = time_in(log);
  std::string of_run = request_.name_of("run");
  // As learning robots' data sets call it.
  if (of_run.empty()) of_run = log.find({"episode_index"}) >= 0 ? "episode_index" : "run";
  const std::string of_joint =
      request_.name_of("joint").empty() ? "joint" : request_.name_of("joint");
  const auto words_of = [&](const std::string& name) {
    const auto words = log.texts.find(name);
    return [&log, at = log.find({name}),
            words = words == log.texts.end() ? nullptr : &words->second](size_t row) {
      if (words != nullptr && row < words->size()) return csv_word((*words)[row]);
      return at < 0 ? "" : exact(log.values[static_cast<size_t>(at)][row]);
    };
  };
  const auto run_in = words_of(of_run), joint_in = words_of(of_joint);
  place_.clear();
  for (const std::string& column : extra_) place_[column] = log.find(called_.at(column));
  for (const JointColumns& joint : joints) {
    // In the order in which they first appear.
    std::vector<std::pair<std::pair<std::string, std::string>, std::vector<size_t>>> parts;
    std::map<std::pair<std::string, std::string>, size_t> place;
    for (size_t row = 0; row < log.rows(); ++row) {
      const std::pair key{run_in(row), joint_in(row)};
      const auto [found, is_new] = place.try_emplace(key, parts.size());
      if (is_new) parts.push_back({key, {}});
      parts[found->second].second.push_back(row);
    }
    for (const auto& [key, rows] : parts) {
      JointColumns one = joint;
      one.joint = csv_word(key.second.empty() ? joint.joint : key.second);
      const std::string name = key.first.empty()  ? run
                               : logs_.size() > 1 ? run + "-" + key.first
                                                  : key.first;
      runs_.insert(name);
      add_rows(log, name, one, rows, time);
    }
  }
}

void ServoImport::write() {
  std::vector<std::string> columns = {"run", "time_s", "joint", "command_rad", "measured_rad"};
  columns.insert(columns.end(), extra_.begin(), extra_.end());
  measurement::CsvWriter table(columns);
  for (const auto& row : rows_) table.row(row);
  draft_.kind = "joints";
  draft_.group = "run";
  draft_.effects = "  ideal_servo: {}\n";
  draft_.add_table("joints", table);
  draft_.did(fmt::format("{} rows of {} runs of joint {}", rows_.size(), runs_.size(),
                         fmt::join(joints_, ", ")));
  reversal_.finish(joints_, draft_);
  if (request_.off_where)
    draft_.did(fmt::format("torque_enable 0 in {} rows of {} (--off-where)", off_, rows_.size()));
  for (const std::string& unit : named_units_)
    draft_.did(fmt::format("angles from {} to rad, as their columns are named", unit));
  if (!request_.unit.empty() && request_.unit != "rad")
    draft_.did(fmt::format("angles from {} to rad", request_.unit));
  if (!extra_.empty()) draft_.did(fmt::format("kept beside them: {}", fmt::join(extra_, ", ")));
  if (repeated_ > 0)
    draft_.warn(fmt::format("{} rows repeat the time of the row above: left out", repeated_));
  if (stale_ >= 20)
    draft_.warn(
        fmt::format("the measured angle stands still over {} rows while the command moves: "
                    "a reading that repeats, or a joint that is stuck",
                    stale_));
  draft_.could_not_know("the noise of the angles: it is estimated from neighbouring rows");
  if (!called_.contains("voltage_v"))
    draft_.could_not_know("the supply: taken as constant (--map voltage=NAME)");
  if (!called_.contains("kp"))
    draft_.could_not_know("the controller's gain: taken as constant (--map kp=NAME)");
  if (runs_.size() < 4)
    draft_.could_not_know(fmt::format("what other runs show: {} {} few to hold out", runs_.size(),
                                      runs_.size() == 1 ? "run is" : "runs are"));
}

// What counts rows in a learning robot's data set, and what is sensed beside its joints.
bool is_of_data_set(const std::string& name) {
  for (const char* prefix : {"observation.", "action.", "next."})
    if (name.starts_with(prefix)) return true;
  for (const char* count : {"episode_index", "frame_index", "index", "task_index", "time_ns"})
    if (name == count) return true;
  return false;
}

void ServoImport::look_at_words() {
  for (const SignalLog& log : logs_) {
    look_for_words(request_, log, "kp", servo_names().gains, draft_);
    look_for_words(request_, log, "voltage", servo_names().voltages, draft_);
    look_for_words(request_, log, kEnabled, servo_names().enabled, draft_);
    joints_of_.push_back(servo_joints(request_, log));
    look_at_efforts(request_, log, joints_of_.back(), draft_);
  }
}

// What a model reads beside the angles.
void ServoImport::keep_ours() {
  const auto keep = [&](const std::string& ours, const std::string& quantity, const Names& usual,
                        const SignalLog& log) {
    const Names names = names_of(request_, quantity, usual);
    const bool constant = std::any_of(names.begin(), names.end(), [&](const std::string& name) {
      return log.constants.contains(name);
    });
    if (log.find(names) < 0 && !constant) return;
    if (!called_.contains(ours)) extra_.push_back(ours);
    called_[ours] = names;
    taken_.insert(names.begin(), names.end());
  };
  for (const SignalLog& log : logs_) {
    keep("kp", "kp", servo_names().gains, log);
    keep("voltage_v", "voltage", servo_names().voltages, log);
    keep(kEnabled, kEnabled, servo_names().enabled, log);
  }
  for (const auto& [ours, quantity] :
       {std::pair("kp", "kp"), {"voltage_v", "voltage"}, {kEnabled, kEnabled}}) {
    if (!request_.name_of(quantity).empty() && !called_.contains(ours))
      fail_missing(request_, logs_.front(), quantity);
  }
  if (request_.off_where && !called_.contains(kEnabled)) {
    extra_.emplace_back(kEnabled);
    called_[kEnabled] = {};
  }
}

// All else that has a number in every row.
void ServoImport::keep_others() {
  for (const Names& names : {servo_names().times, servo_names().commands, servo_names().measured})
    taken_.insert(names.begin(), names.end());
  for (const auto& [quantity, name] : request_.names) taken_.insert(name);
  for (size_t i = 0; i < logs_.size(); ++i) {
    const SignalLog& log = logs_[i];
    for (const JointColumns& joint : joints_of_[i]) {
      taken_.insert({log.names[joint.command], log.names[joint.measured]});
      if (!joint.effort) continue;
      taken_.insert(log.names[*joint.effort]);
      if (called_.try_emplace(kEffort, Names{log.names[*joint.effort]}).second)
        extra_.emplace_back(kEffort);
    }
    taken_.insert(log.names[time_in(log)]);
  }
  for (const SignalLog& log : logs_) {
    for (size_t c = 0; c < log.names.size(); ++c) {
      const std::string& name = log.names[c];
      const bool whole = std::all_of(log.values[c].begin(), log.values[c].end(),
                                     [](double value) { return std::isfinite(value); });
      const bool ours = name.find('[') != std::string::npos || name.ends_with("_ctrl") ||
                        name.ends_with("_qpos") || name == "run" || name == "joint";
      if (!whole || ours || is_of_data_set(name) || taken_.contains(name) ||
          called_.contains(csv_word(name)))
        continue;
      extra_.push_back(csv_word(name));
      called_[csv_word(name)] = {name};
    }
  }
}

void ServoImport::run() {
  ServoLogs found = servo_logs(request_, draft_);
  logs_ = std::move(found.logs), request_ = std::move(found.request);
  look_at_words();
  keep_ours();
  keep_others();
  std::set<std::string> stems;
  for (size_t i = 0; i < logs_.size(); ++i) {
    std::string stem = csv_word(found.runs[i]);
    if (!stems.insert(stem).second) stem = fmt::format("{}-{}", stem, i);
    add_log(logs_[i], joints_of_[i], stem);
  }
  write();
}

}  // namespace

void import_servo(const ImportRequest& request, SetDraft& draft) {
  ServoImport(request, draft).run();
}

}  // namespace seam::app
