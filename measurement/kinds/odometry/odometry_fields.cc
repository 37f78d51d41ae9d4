// Where causes without a name may act on a body that walks or drives, beside what its poses show by
// themselves: on its ways and its turns, in proportion, as a floor or a worn wheel does, and on how
// far it turns and slips aside on its way, as a slope or a pile of a carpet does.
#include <cmath>

#include "measurement/kinds/odometry/odometry.h"

namespace seam::measurement {

OdometryProblem::Walked OdometryProblem::stretched(const Walked& walked, const WalkRun& run,
                                                   const Stretch& by) {
  Walked out = walked;
  for (size_t k = 1; k < out.path.size(); ++k) {
    const size_t row = run.rows[k];
    const double way = 1 + by.way[row], turn = 1 + by.turn[row], aside = by.aside[row];
    WalkPose& step = out.steps[k];
    const double metres = std::hypot(step[0], step[1]);
    step = {step[0] * way - step[1] * aside, step[1] * way + step[0] * aside,
            step[2] * turn + by.turn_of_way[row] * metres};
    const effects::WalkState& before = out.path[k - 1];
    const WalkPose here = placed({before.x_m, before.y_m, before.theta_rad}, step);
    out.path[k].x_m = here[0], out.path[k].y_m = here[1], out.path[k].theta_rad = here[2];
  }
  return out;
}

std::vector<FieldPlace> OdometryProblem::field_places(const Model& model,
                                                      const Evaluation& here) const {
  constexpr double kStep = 1e-4;
  constexpr int kWay = 0, kTurn = 2;  // Where the channels of a place and of a heading stand.
  using ByRow = std::vector<double> Stretch::*;
  const size_t rows = facts_.rows();
  // By differences, so that starts and all that hangs together along a run follow.
  const auto moved_by = [this, model, rows, whitened = here.whitened](ByRow what, int channel,
                                                                      std::vector<double>& column) {
    const std::vector<double> none(rows, 0);
    Stretch stretch{none, none, none, none};
    for (size_t row = 0; row < rows; ++row) {
      if (scalar(row, channel) >= 0) (stretch.*what)[row] = kStep * column[scalar(row, channel)];
    }
    const Evaluation there = evaluate_walks(model, all_groups(), &stretch);
    for (size_t i = 0; i < column.size(); ++i)
      column[i] = there.valid ? (whitened[i] - there.whitened[i]) / kStep : 0;
  };
  std::vector<FieldPlace> places;
  const std::pair<ByRow, int> ways[] = {{&Stretch::way, kWay},
                                        {&Stretch::turn, kTurn},
                                        {&Stretch::turn_of_way, kTurn},
                                        {&Stretch::aside, kWay}};
  for (const auto& [what, channel] : ways) {
    const auto moves = [moved_by, what = what, channel = channel](std::vector<double>& column) {
      moved_by(what, channel, column);
    };
    std::vector<double> constant(facts_.scalars(), 0);
    for (size_t row = 0; row < rows; ++row) {
      if (scalar(row, channel) >= 0) constant[scalar(row, channel)] = 1;
    }
    const std::vector<double> slope = constant;
    moves(constant);
    double sum2 = 0;
    for (const double value : constant) sum2 += value * value;
    if (!(sum2 > 0)) continue;
    // The same everywhere, it moves the poses by the noise.
    const double unit = std::sqrt(static_cast<double>(constant.size()) / sum2);
    const auto arrives = [moves, unit](std::vector<double>& column) {
      moves(column);
      for (double& value : column) value *= unit;
    };
    for (const Covariate& covariate : facts_.covariates)
      places.push_back(
          {.slopes = {slope}, .covariates = {covariate}, .has_level = true, .arrives = arrives});
  }
  return places;
}

}  // namespace seam::measurement
