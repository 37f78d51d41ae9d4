// What a camera on a swinging head sees, by formula: the other side of the measured bias.
#pragma once

#include <vector>

namespace seam::tools {

// The head's pan is amplitude * sin(2 pi t / period).
struct Swing {
  double amplitude_rad = 1.5;
  double period_s = 4;

  double pan_rad(double time_s) const;
  double rate_radps(double time_s) const;
};

// The pan angles that a camera locked to the swing ever sees: `frames` a swing, the first `phase`
// frame periods after the swing's start.
std::vector<double> locked_angles(const Swing& swing, int frames, double phase);

// At how many of them a landmark at a bearing from the body lies within the view. Of all the views
// of it that there are, a locked camera gathers but these, again and again.
int locked_views(const Swing& swing, int frames, double phase, double bearing_rad,
                 double half_view_rad);

// Error of a bearing taken with the head's angle at the frame's stamp although the row was exposed
// `row_middle_s` later: while the head turns left the landmark is put too far right, and the other
// way round. A whole swing's errors cancel only if both directions are seen equally often.
double stamp_bearing_error_rad(double pan_rate_radps, double row_middle_s);

// Spread of the mean of errors that have a part common to all sightings, a part that belongs to the
// view and returns in each swing, and a part that is new in each frame.
struct ErrorParts {
  double common = 0, view = 0, frame = 0;  // Standard deviations.
};
double locked_bias(const ErrorParts& parts, double views, double swings);

}  // namespace seam::tools
