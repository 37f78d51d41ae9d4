// A number that cannot be used is an error where it arises: of a formula with a root of something
// negative, a division by zero or a factor of 1e300 the reader learns which effect it was, not
// which library gave up on it later. Stages look at what leaves them, formulas one by one; those of
// a fit, which tries what may not work, take such numbers as they come.
#pragma once

#include <string>

namespace seam::effects {

// Angles (rad), speeds (m/s, rad/s) and ranges (m) beyond this are no body's.
inline constexpr double kLargestOutput = 1e6;
// Pixels, gains and DN beyond this are no image's; single precision still holds them.
inline constexpr double kLargestOfImage = 1e30;

// False for what is not a number, infinite, or too large.
inline bool usable(double value, double largest = kLargestOutput) {
  return value >= -largest && value <= largest;
}

// "effect 'x' gives q = nan at ...", InputError.
[[noreturn]] void fail_with(const std::string& effect, const std::string& output, double value,
                            const std::string& where);

// A number in a message; a NaN without its sign, which depends on the processor.
std::string number_shown(double value);

// "robot 'red1' at 1.25 s" for such a message.
std::string robot_at(const std::string& robot, double t_s);

}  // namespace seam::effects
