// Simulated time: integer nanoseconds. An instant and a duration are different types, and neither
// converts from a bare number, so that seconds and nanoseconds cannot be mixed up silently.
#pragma once

#include <cmath>
#include <compare>
#include <cstdint>

namespace seam {

// A span of simulated time, may be negative.
class SimDuration {
 public:
  constexpr SimDuration() = default;
  static constexpr SimDuration from_ns(int64_t ns) { return SimDuration(ns); }
  // Rounded to the nearest nanosecond.
  static SimDuration from_s(double s) { return SimDuration(std::llround(s * 1e9)); }
  constexpr int64_t ns() const { return ns_; }
  constexpr double s() const { return static_cast<double>(ns_) * 1e-9; }
  constexpr auto operator<=>(const SimDuration&) const = default;

 private:
  explicit constexpr SimDuration(int64_t ns) : ns_(ns) {}
  int64_t ns_ = 0;
};

// An instant of simulated time; zero is the start of the run.
class SimTime {
 public:
  constexpr SimTime() = default;
  static constexpr SimTime from_ns(int64_t ns) { return SimTime(ns); }
  static SimTime from_s(double s) { return SimTime(std::llround(s * 1e9)); }
  constexpr int64_t ns() const { return ns_; }
  constexpr double s() const { return static_cast<double>(ns_) * 1e-9; }
  constexpr auto operator<=>(const SimTime&) const = default;

 private:
  explicit constexpr SimTime(int64_t ns) : ns_(ns) {}
  int64_t ns_ = 0;
};

constexpr SimDuration operator+(SimDuration a, SimDuration b) {
  return SimDuration::from_ns(a.ns() + b.ns());
}
constexpr SimDuration operator-(SimDuration a, SimDuration b) {
  return SimDuration::from_ns(a.ns() - b.ns());
}
constexpr SimDuration operator-(SimDuration a) {
  return SimDuration::from_ns(-a.ns());
}
constexpr SimDuration operator*(SimDuration a, int64_t n) {
  return SimDuration::from_ns(a.ns() * n);
}
constexpr SimDuration operator/(SimDuration a, int64_t n) {
  return SimDuration::from_ns(a.ns() / n);
}
constexpr SimTime operator+(SimTime t, SimDuration d) {
  return SimTime::from_ns(t.ns() + d.ns());
}
constexpr SimTime operator-(SimTime t, SimDuration d) {
  return SimTime::from_ns(t.ns() - d.ns());
}
constexpr SimDuration operator-(SimTime a, SimTime b) {
  return SimDuration::from_ns(a.ns() - b.ns());
}

}  // namespace seam
