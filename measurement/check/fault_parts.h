// What the faults of the single kinds are told with, and those of each kind (faults.h).
#pragma once

#include <initializer_list>
#include <map>
#include <numbers>
#include <string>
#include <vector>

#include "measurement/sets/set.h"

namespace seam::measurement {

using Rows = std::vector<size_t>;
using Numbers = std::vector<double>;

// Of a ratio that is 1 in good data: what it looks like; empty where it is near neither. Effects
// change it by tens of per cent.
std::string unit_of_ratio(double ratio, double factor, const char* unit, const char* instead);
// Degrees in a radian.
inline constexpr double kDegrees = 180 / std::numbers::pi;

double span_of(const Numbers& values);
Numbers at(const Numbers& values, const Rows& rows);
// Rows by what stands in these columns, those that the table lacks left out, in the table's order.
std::map<std::string, Rows> rows_by(const CsvTable& table, const std::vector<std::string>& columns);
std::string place(const CsvTable& table, size_t row);
bool has_all(const CsvTable& table, std::initializer_list<const char*> columns);

// What a command and the angle measured under it, row by row at even steps, say of each other: a
// copy, one ahead of its cause, two columns that count opposite ways. `acts`: whether the drive is
// on in a row. `joint` is its name in the sentences.
std::vector<std::string> faults_of_command(const Numbers& command, const Numbers& measured,
                                           const std::vector<char>& acts, const std::string& joint);
// Rows whose command is 0 although the drive is off there: the joint, which else stays close to its
// commands, stays away from 0 for longer than it would take to arrive. `acts` as above.
Rows rows_without_drive(const Numbers& command, const Numbers& measured,
                        const std::vector<char>& acts);

// Each adds sentences.
void joint_faults(const MeasurementSet& set, std::vector<std::string>& found);
void walk_faults(const MeasurementSet& set, std::vector<std::string>& found);
// Of a walk whose wheels are counted, `walk_faults`'s part.
void tick_faults(const CsvTable& table, std::vector<std::string>& found);
void landmark_faults(const MeasurementSet& set, std::vector<std::string>& found);
void point_faults(const MeasurementSet& set, std::vector<std::string>& found);
void range_faults(const MeasurementSet& set, std::vector<std::string>& found);
void picture_faults(const MeasurementSet& set, std::vector<std::string>& found);

}  // namespace seam::measurement
