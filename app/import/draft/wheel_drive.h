// A drive of a body on two wheels, as files of other programs log it: what the wheels say, and
// where the body was.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "app/import/draft/request.h"
#include "app/import/draft/set_draft.h"
#include "app/import/draft/walk_draft.h"

namespace seam::app {

// What the columns of wheels hold.
enum class WheelReading {
  each_row,         // Since the row before.
  counter,          // Since some start: the differences of rows count.
  speed,            // Measured: half of each of two rows acts between them.
  commanded_speed,  // From the row's time on until the next row.
};

struct WheelRow {
  int64_t ns = 0;
  std::array<double, 2> value{};  // Left, right; in the file's unit.
  std::string run, place;         // "file:line".
};

struct Drive {
  std::vector<WheelRow> rows;
  std::vector<std::array<double, 2>> since;  // By row, what the wheels turned since the one before.
  std::vector<char> begins;                  // By row, whether a run begins there.
  std::vector<PlanarPose> poses;             // Measured, in order of time.
  int64_t longest_gap_ns = 500'000'000;      // Between poses; across longer ones nobody knows.
};

// Fills `since` and `begins`: wraps of counters are undone, a run begins where one was reset.
// Returns what was mended, in words; empty: nothing.
std::string read_wheels(WheelReading reading, Drive& drive);

// What the body did over stretches of half a second and more.
struct Stretch {
  double forward_m = 0, turn_rad = 0;
  std::array<double, 2> wheels{};
};
std::vector<Stretch> stretches_of(const Drive& drive);

// The share of the body's motion that is not proportional to what its wheels say: forward times
// turning; 1 where they say nothing.
double not_told_by_wheels(const std::vector<Stretch>& stretches);

// The pose at a time, between the two measured about it; none beyond the ends and across gaps.
bool pose_at(const Drive& drive, int64_t ns, PlanarPose& pose);

// By how much the clock of the poses must be put forward so that the body moves when its wheels
// turn.
struct ClockShift {
  int64_t ns = 0;
  double correlation = 0;  // Of what wheels and poses say of the motion, at this shift.
  double other = 0;        // The best one clearly elsewhere.
};
ClockShift best_clock_shift(const Drive& drive);

// Writes the set; the nominal model's numbers are the request's, or estimated and free.
// `metres_per_value`: what the file's unit says of a wheel's value; 0: nothing.
void draft_drive(const Drive& drive, const ImportRequest& request, double metres_per_value,
                 SetDraft& draft);

}  // namespace seam::app
