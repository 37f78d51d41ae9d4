// What a user asks of an import, whatever the kind: files, and what the files do not say of
// themselves.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace seam::app {

struct ImportRequest {
  std::vector<std::filesystem::path> sources;
  // What a quantity is called in the files, by our name for it.
  std::map<std::string, std::string> names;
  std::vector<std::string> reversed;  // Joints whose measured angles get the other sign.
  // Rows in which a drive is off: a signal of the files, and its value there, NaN for none.
  std::optional<std::pair<std::string, double>> off_where;
  std::string unit;         // Of angles; empty: not given.
  std::string time_unit;    // Likewise.
  std::string length_unit;  // Likewise.
  // Of single quantities by our names for them, where the user said so; goes before the above.
  std::map<std::string, std::string> own_units;
  int board_columns = 0, board_rows = 0;  // Corners of a target; 0: not given.
  double spacing_m = 0;                   // Between them; 0: not given.
  std::string target;                     // What is on it: chessboard, circles; empty: not given.
  int width_px = 0, height_px = 0;        // Of the images; 0: not given.
  // Of a body on two wheels; 0: not given.
  double base_m = 0, radius_m = 0, metres_per_tick = 0;
  std::string camera;  // Which one, or which robot's.
  std::string part;    // Of what the files hold; empty: the first that is there.

  // Our names that the import asks for, all of them (ImportKind::quantities); empty: not checked.
  std::vector<std::string> quantities;

  // The file's name of a quantity: the user's, else empty.
  std::string name_of(const std::string& quantity) const;
  // The user's unit of a quantity: its own, else `general`.
  const std::string& unit_of(const std::string& quantity, const std::string& general) const;
};

// Throws UsageError where the user maps a name, or gives a unit to one, that the import `kind`
// never asks for.
void check_names(const ImportRequest& request, const std::string& kind);

// Factors to radians, to metres and to nanoseconds. Throw UsageError for an unknown unit.
double radians_in(const std::string& unit);       // rad, mrad, deg, turns, ticks:N (N a turn).
double metres_in(const std::string& unit);        // m, cm, mm, um, in.
int64_t nanoseconds_in(const std::string& unit);  // s, ms, us, ns.

}  // namespace seam::app
