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
    {"joints", "nothing", 4, 4},         {"joints", "named", 13, 12},
    {"joints", "unexplained", 14, 14},   {"landmarks", "nothing", 2, 2},
    {"landmarks", "named", 6, 6},        {"landmarks", "unexplained", 9, 9},
    {"odometry", "nothing", 4, 4},       {"odometry", "named", 12, 12},
    {"odometry", "unexplained", 15, 15}, {"photometry", "nothing", 2, 2},
    {"photometry", "named", 6, 6},       {"photometry", "unexplained", 6, 6},
    {"points", "nothing", 5, 4},         {"points", "named", 15, 12},
    {"points", "unexplained", 10, 10},
};

}  // namespace seam::measurement
