// How a body moved, as columns of any names and units say it.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "app/import/draft/request.h"
#include "app/import/files/text_table.h"

namespace seam::app {

// Where the columns stand; -1: nowhere.
struct MotionColumns {
  int time = -1, run = -1, left = -1, right = -1, vx = -1, vy = -1, omega = -1;

  bool are_wheels() const { return time >= 0 && left >= 0 && right >= 0; }
  bool are_velocities() const { return time >= 0 && vx >= 0 && omega >= 0; }
};

MotionColumns motion_columns(const TextTable& table, const ImportRequest& request);

// Of a row: left and right as they stand and 0, or vx, omega and vy in SI; NaN where blank.
std::array<double, 3> motion_in(const TextTable& table, const MotionColumns& columns, bool wheels,
                                size_t row, const ImportRequest& request);

// What the wheels' columns say by their names and by the user's units.
struct WheelUnit {
  bool is_speed = false, is_commanded = false;
  bool is_counter = false, is_each_row = false;
  double metres = 0;   // Of one value, of a way; 0: not said.
  double radians = 0;  // Of one value, of a turn; 0: not said.
};

WheelUnit wheel_unit(const TextTable& table, const MotionColumns& columns,
                     const ImportRequest& request);

// The way of a wheel for each value; 0 where nobody says it.
double metres_per_value(const WheelUnit& unit, const ImportRequest& request);

}  // namespace seam::app
