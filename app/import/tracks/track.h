// Where a robot was, as tables of other programs say it: columns of any names and units.
#pragma once

#include <array>
#include <limits>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "app/import/draft/request.h"
#include "app/import/draft/set_draft.h"
#include "app/import/files/text_table.h"

namespace seam::app {

struct TrackPose {
  int64_t ns = 0;
  double x_m = 0, y_m = 0, z_m = 0;
  double theta_rad = std::numeric_limits<double>::quiet_NaN();  // Where it is not stated.
  std::array<double, 3> up = {0, 0, 1};                         // The body's z axis.
  std::string place;                                            // "file:line".
};

struct Track {
  std::vector<TrackPose> poses;
  bool has_heights = false, has_headings = false;
  bool has_tilts = false;  // From quaternions.
};

// Where the columns of a table stand; -1: nowhere.
struct TrackColumns {
  int time = -1, x = -1, y = -1, z = -1, theta = -1;
  std::array<int, 4> q = {-1, -1, -1, -1};  // w, x, y, z.

  bool are_poses() const { return time >= 0 && x >= 0 && y >= 0; }
};

// The place of a quantity's column: by the user's name for it, else by the usual ones.
int column_of(const TextTable& table, const ImportRequest& request, const std::string& quantity,
              const std::vector<std::string>& usual);

// `time`: what the quantity of its column is called, by which users name it.
TrackColumns track_columns(const TextTable& table, const ImportRequest& request,
                           const std::string& time = "time");

// Appends the rows that state a place; rows without one are passed over.
void read_track(const TextTable& table, const TrackColumns& columns, const ImportRequest& request,
                const std::string& time, Track& track);

// Columns with a number in every row beside those that are taken (-1: no column), no constants and
// no counters of rows.
std::vector<size_t> numbers_beside(const TextTable& table, const std::set<int>& taken);
// Adds the names of those to `names`.
void name_beside(const TextTable& table, const std::set<int>& taken, std::set<std::string>& names);
// Says which columns the set does not hold, where there are some, and what follows.
void say_left_out(const std::set<std::string>& names, std::string_view follows, SetDraft& draft);
std::set<int> places_of(const TrackColumns& columns);

// The time of a row; throws beyond what differences of times hold (95 years about 1970).
int64_t time_in(const TextTable& table, size_t row, int column, int64_t unit_ns);

// Throws where a user's name for a quantity is no column of any of the tables.
void check_columns_met(const ImportRequest& request, const std::vector<TextTable>& tables);

// Units: the user's for the quantity, else his general one, else that at the end of the column's
// name, else SI.
int64_t time_unit_of(const ImportRequest& request, const std::string& quantity,
                     const std::string& column);
double metres_of(const ImportRequest& request, const std::string& quantity,
                 const std::string& column);
double radians_of(const ImportRequest& request, const std::string& quantity,
                  const std::string& column);

// Throws where a path with heights or tilts leaves the plane on which it is to be laid; `remedy`
// says what to do. Returns what is lost by the plane, in words; empty: nothing.
std::string laid_on_plane(const Track& track, const std::string& remedy);

}  // namespace seam::app
