// How often verdicts were right on sets of the benchmark, by kind and verdict. Made by
// `benchmark/run.py trust` from answers to sets of all sorts and to those of `outside`.
#pragma once

namespace seam::measurement {

struct TrustRow {
  const char* kind;
  const char* verdict;  // nothing, named, unexplained
  int sets, right;
};

inline constexpr TrustRow kTrust[] = {
    {"joints", "nothing", 10, 10},       {"joints", "named", 33, 31},
    {"joints", "unexplained", 41, 38},   {"landmarks", "nothing", 5, 5},
    {"landmarks", "named", 14, 14},      {"landmarks", "unexplained", 27, 25},
    {"odometry", "nothing", 10, 10},     {"odometry", "named", 30, 30},
    {"odometry", "unexplained", 43, 41}, {"photometry", "nothing", 3, 3},
    {"photometry", "named", 8, 8},       {"photometry", "unexplained", 19, 19},
    {"points", "nothing", 11, 5},        {"points", "named", 18, 16},
    {"points", "unexplained", 35, 35},
};

}  // namespace seam::measurement
