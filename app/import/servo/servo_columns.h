// Which columns of a servo's log are what: by what the user says, or by habit.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "app/import/draft/request.h"
#include "app/import/files/signals.h"

namespace seam::app {

// What people call a quantity, the usual names first.
struct ServoNames {
  std::vector<std::string> times, commands, measured, efforts, voltages, gains, enabled;
};
const ServoNames& servo_names();
// The user's name of a quantity, else the usual ones.
std::vector<std::string> names_of(const ImportRequest& request, const std::string& quantity,
                                  const std::vector<std::string>& usual);
// Throws InputError: the signal that the user maps to a quantity is not in the log.
[[noreturn]] void fail_missing(const ImportRequest& request, const SignalLog& log,
                               const std::string& quantity);
// What stands behind a joint's name where the column is its torque.
const std::vector<std::string>& effort_ends();

// One joint's columns in a log.
struct JointColumns {
  std::string joint;
  size_t command = 0, measured = 0;
  std::optional<size_t> effort = {};  // The torque of its motor.
};

// The place of a quantity among the signals; throws InputError where neither the map nor habit
// finds it.
size_t servo_signal(const ImportRequest& request, const SignalLog& log, const std::string& quantity,
                    const std::vector<std::string>& usual);

// What the items of its lists are called by; empty where the log does not say it.
std::vector<std::string> joint_names_in(const SignalLog& log);

// By row: whether the drive is off there, as --off-where says.
std::vector<char> servo_off_rows(const ImportRequest& request, const SignalLog& log,
                                 const JointColumns& joint);

// Never empty: throws InputError where there is none.
std::vector<JointColumns> servo_joints(const ImportRequest& request, const SignalLog& log);

}  // namespace seam::app
