// What is said of other people's columns before they are used: units that cannot be meant, clocks
// that jump or run backwards.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "app/import/draft/request.h"
#include "app/import/draft/set_draft.h"

namespace seam::app {

// "file:line" (or the like) of a row.
using RowPlace = std::function<std::string(size_t row)>;

// The user's unit, else that at the end of the column's name (stamp_ms), else seconds.
int64_t time_unit_ns(const ImportRequest& request, const std::string& column);

// The unit that a column's name has at its end: "angle [deg]", "angle_rad", "range (mm)"; empty
// where it has none of these.
std::string unit_in(const std::string& column, const std::vector<std::string>& units);
std::string angle_unit_in(const std::string& column);
std::string length_unit_in(const std::string& column);

// Throws where a time is before the one above it, and where the usual step is longer than
// `most_step_s` or shorter than a microsecond while the user named no unit. Warns of steps that are
// much longer than the usual one.
void check_times(const std::vector<int64_t>& ns, const RowPlace& place,
                 const ImportRequest& request, double most_step_s, SetDraft& draft);

// Turns angles into radians by the user's unit. Where he named none, values beyond a few turns are
// an error: degrees look like that. Throws for what is not finite.
void to_radians(std::vector<double>& values, const std::string& quantity, const RowPlace& place,
                const ImportRequest& request, SetDraft& draft);

}  // namespace seam::app
