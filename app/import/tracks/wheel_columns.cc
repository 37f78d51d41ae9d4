#include "app/import/tracks/wheel_columns.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <numbers>

#include "app/import/draft/checks.h"
#include "app/import/tracks/track.h"
#include "sim_core/base/error.h"

namespace seam::app {
namespace {

using Words = std::vector<std::string>;

std::string in_small(std::string text) {
  for (char& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return text;
}

// The names as they stand, then with a unit of speed at their ends.
Words with_units(Words names) {
  const size_t plain = names.size();
  for (const char* unit :
       {"_mps", "_m_s", "_mmps", "_mm_s", "_radps", "_rad_s", "_degps", "_deg_s", "_rpm"}) {
    for (size_t i = 0; i < plain; ++i) names.push_back(names[i] + unit);
  }
  return names;
}

// What people call a wheel's column, {} the side.
Words wheel_names(const std::string& side, const std::string& letter) {
  static const Words kTurned = {
      "{}_ticks",       "ticks_{}",    "{}_tick",     "tick_{}",           "{}_encoder",
      "encoder_{}",     "{}_enc",      "enc_{}",      "{}_count",          "count_{}",
      "{}_counts",      "counts_{}",   "{}_pulses",   "pulses_{}",         "{}_wheel",
      "wheel_{}",       "delta_{}",    "{}_delta",    "{}_position",       "{}_pos",
      "pos_{}",         "{}_angle",    "angle_{}",    "{}_wheel_position", "{}_wheel_angle",
      "{}_wheel_ticks", "{}_distance", "distance_{}", "{}wheel",           "{}ticks",
      "enc{}",          "{}enc",       "d{}"};
  static const Words kSpeeds = {"{}_speed",
                                "speed_{}",
                                "{}_vel",
                                "vel_{}",
                                "{}_velocity",
                                "velocity_{}",
                                "{}_wheel_speed",
                                "{}_wheel_vel",
                                "{}_wheel_velocity",
                                "wheel_speed_{}",
                                "wheel_vel_{}",
                                "v_{}",
                                "v{}",
                                "w_{}",
                                "omega_{}",
                                "rpm_{}",
                                "{}_rpm",
                                "{}_mps",
                                "{}_radps",
                                "cmd_{}",
                                "{}_cmd"};
  Words names;
  for (const Words* patterns : {&kTurned, &kSpeeds}) {
    for (const std::string& pattern : *patterns) {
      for (const std::string& word : {side, letter})
        names.push_back(fmt::format(fmt::runtime(pattern), word));
    }
  }
  names.push_back(side);
  return with_units(names);
}

// A unit of speed at the end of a name, to a way or an angle in a second; 0: none.
struct SpeedUnit {
  double metres = 0, radians = 0;
};
SpeedUnit speed_unit_in(std::string name) {
  name = in_small(std::move(name));
  while (!name.empty() && (name.back() == ']' || name.back() == ')')) name.pop_back();
  constexpr double kDegree = std::numbers::pi / 180;
  for (const auto& [end, unit] :
       std::initializer_list<std::pair<const char*, SpeedUnit>>{{"rad/s", {0, 1}},
                                                                {"radps", {0, 1}},
                                                                {"rad_s", {0, 1}},
                                                                {"rad_per_s", {0, 1}},
                                                                {"deg/s", {0, kDegree}},
                                                                {"degps", {0, kDegree}},
                                                                {"deg_s", {0, kDegree}},
                                                                {"dps", {0, kDegree}},
                                                                {"rpm", {0, std::numbers::pi / 30}},
                                                                {"mm/s", {1e-3, 0}},
                                                                {"mmps", {1e-3, 0}},
                                                                {"mm_s", {1e-3, 0}},
                                                                {"cm/s", {1e-2, 0}},
                                                                {"cmps", {1e-2, 0}},
                                                                {"cm_s", {1e-2, 0}},
                                                                {"m/s", {1, 0}},
                                                                {"mps", {1, 0}},
                                                                {"_m_s", {1, 0}},
                                                                {"ticks/s", {0, 0}}}) {
    if (name.ends_with(end)) return unit;
  }
  return {};
}

bool has_word(const std::string& name, const Words& words) {
  return std::any_of(words.begin(), words.end(),
                     [&](const std::string& word) { return name.find(word) != std::string::npos; });
}

// By the user's word for a quantity, else by the column's name, else SI.
double of_speed(const ImportRequest& request, const std::string& quantity,
                const std::string& column, bool angular) {
  const bool ticks = angular && request.unit.starts_with("ticks:");
  const std::string said = request.unit_of(quantity, !angular ? request.length_unit
                                                     : ticks  ? ""
                                                              : request.unit);
  if (!said.empty()) return angular ? radians_in(said) : metres_in(said);
  const SpeedUnit unit = speed_unit_in(column);
  const double factor = angular ? unit.radians : unit.metres;
  return factor > 0 ? factor : 1;
}

}  // namespace

MotionColumns motion_columns(const TextTable& table, const ImportRequest& request) {
  MotionColumns columns;
  if (table.columns().empty()) return columns;
  const auto column = [&](const std::string& quantity, const Words& usual) {
    return column_of(table, request, quantity, usual);
  };
  columns.time = track_columns(table, request).time;
  columns.run = column("run", {"run", "trial", "run_id", "trial_id", "lap"});
  columns.left = column("left", wheel_names("left", "l"));
  columns.right = column("right", wheel_names("right", "r"));
  columns.vx = column("vx", with_units({"vx_cmd_mps", "vx_cmd", "cmd_vx", "vx", "v_x", "linear_x",
                                        "linear.x", "cmd_vel.linear.x", "cmd_linear", "v_cmd",
                                        "cmd_v", "v", "lin_vel", "linear_velocity", "linear_vel",
                                        "forward_velocity", "speed", "velocity", "vel"}));
  columns.omega = column("omega", with_units({"omega_cmd_radps",
                                              "omega_cmd",
                                              "cmd_omega",
                                              "omega",
                                              "angular_z",
                                              "angular.z",
                                              "cmd_vel.angular.z",
                                              "cmd_angular",
                                              "w_cmd",
                                              "cmd_w",
                                              "wz",
                                              "w",
                                              "ang_vel",
                                              "angular_velocity",
                                              "angular_vel",
                                              "yaw_rate",
                                              "yawrate",
                                              "turn_rate",
                                              "heading_rate",
                                              "rot_vel",
                                              "vtheta",
                                              "gyro_z"}));
  columns.vy = column("vy", with_units({"vy_cmd_mps", "vy_cmd", "cmd_vy", "vy", "v_y", "linear_y",
                                        "linear.y", "cmd_vel.linear.y"}));
  return columns;
}

std::array<double, 3> motion_in(const TextTable& table, const MotionColumns& columns, bool wheels,
                                size_t row, const ImportRequest& request) {
  const auto number = [&](int column) {
    return column < 0 ? 0 : table.number_or_blank(row, static_cast<size_t>(column));
  };
  if (wheels) return {number(columns.left), number(columns.right), 0};
  const auto name = [&](int column) {
    return column < 0 ? "" : table.full_name(static_cast<size_t>(column));
  };
  return {of_speed(request, "vx", name(columns.vx), false) * number(columns.vx),
          of_speed(request, "omega", name(columns.omega), true) * number(columns.omega),
          of_speed(request, "vy", name(columns.vy), false) * number(columns.vy)};
}

WheelUnit wheel_unit(const TextTable& table, const MotionColumns& columns,
                     const ImportRequest& request) {
  WheelUnit unit;
  if (columns.left < 0) return unit;
  const std::string name = in_small(table.full_name(static_cast<size_t>(columns.left)));
  const SpeedUnit speed = speed_unit_in(name);
  unit.is_speed = speed.metres > 0 || speed.radians > 0 ||
                  has_word(name, {"speed", "vel", "rpm", "/s", "v_", "w_", "omega"}) ||
                  name == "vl" || name == "vleft";
  unit.is_commanded = has_word(name, {"cmd", "command", "target", "desired", "setpoint", "ref"});
  // A command of a wheel is how fast it is to turn.
  unit.is_speed = unit.is_speed || unit.is_commanded;
  unit.is_each_row = has_word(name, {"delta", "diff", "increment"});
  unit.is_counter = !unit.is_each_row && has_word(name, {"total", "cumul", "accum"});
  const std::string said =
      request.unit_of("left", request.unit.starts_with("ticks:") ? request.unit : "");
  const bool of_length =
      said == "m" || said == "cm" || said == "mm" || said == "um" || said == "in";
  if (of_length) unit.metres = metres_in(said);
  if (!said.empty() && !of_length) unit.radians = radians_in(said);
  if (!said.empty()) return unit;
  const std::string length = length_unit_in(name), angle = angle_unit_in(name);
  unit.metres = speed.metres > 0 ? speed.metres : length.empty() ? 0 : metres_in(length);
  unit.radians = speed.radians > 0 ? speed.radians : angle.empty() ? 0 : radians_in(angle);
  return unit;
}

double metres_per_value(const WheelUnit& unit, const ImportRequest& request) {
  if (unit.metres > 0) return unit.metres;
  if (request.radius_m > 0 && unit.radians > 0) return request.radius_m * unit.radians;
  if (request.radius_m > 0)
    throw UsageError(
        "--radius needs the unit of the wheels' turns: --unit left=ticks:N (N a turn), rad or deg");
  return 0;
}

}  // namespace seam::app
