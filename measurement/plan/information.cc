#include "measurement/plan/information.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "measurement/fitting/parameter_space.h"

namespace seam::measurement {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

Columns columns_at(const Problem& problem, const Model& model, const std::vector<Unknown>& unknowns,
                   const Evaluation& here) {
  Columns out{.unknowns = unknowns};
  out.by = problem.jacobian(model, unknowns, problem.all_groups(), here);
  const ParameterSpace space(model, unknowns);
  const VectorXd place = space.place(model);
  for (size_t k = 0; k < unknowns.size(); ++k) {
    // A limit that never binds: the kind gives the derivative by its reciprocal.
    const double slope = space[k].slope(place[static_cast<Index>(k)]);
    out.slope.push_back(slope);
    if (!std::isfinite(slope) || slope == 1) continue;
    for (double& value : out.by[k]) value *= slope;
  }
  return out;
}

std::vector<double> shift_of(const Evaluation& without, const Evaluation& with) {
  std::vector<double> shift(without.whitened.size(), 0);
  for (size_t i = 0; i < shift.size() && i < with.whitened.size(); ++i)
    shift[i] = without.whitened[i] - with.whitened[i];
  return shift;
}

bool errors_are_independent(const Problem& problem, const Evaluation& here) {
  const Facts& facts = problem.facts();
  if (!here.mean_square.empty() || here.whitened.size() != facts.scalars() ||
      here.shared_log_det != 0)
    return false;
  std::vector<double> sum(facts.groups.size(), 0);
  for (size_t i = 0; i < facts.scalars(); ++i) {
    if (here.used[i]) sum[static_cast<size_t>(facts.group_of(i))] += 2 * std::log(here.sigma[i]);
  }
  constexpr double kRounding = 1e-6;
  for (size_t g = 0; g < sum.size() && g < here.log_det.size(); ++g) {
    if (!(std::abs(sum[g] - here.log_det[g]) <= kRounding * (1 + std::abs(sum[g])))) return false;
  }
  return true;
}

Columns spread_columns_at(const Problem& problem, const Model& model,
                          const std::vector<Unknown>& unknowns) {
  constexpr double kStep = 0.01, kLeastStep = 1e-4;  // Of itself, and of what is typical of it.
  Columns out{.unknowns = unknowns};
  const ParameterSpace space(model, unknowns);
  const VectorXd place = space.place(model);
  const auto groups = problem.all_groups();
  for (size_t k = 0; k < unknowns.size(); ++k) {
    const double z = place[static_cast<Index>(k)];
    const double step = std::max(kStep * std::abs(z), kLeastStep * space[k].scale);
    const double low = std::max(z - step, space[k].min), high = std::min(z + step, space[k].max);
    const auto below = problem.evaluate(space.with(model, k, low), groups);
    const auto above = problem.evaluate(space.with(model, k, high), groups);
    std::vector<double>& column = out.by.emplace_back(above.sigma.size(), 0);
    for (size_t i = 0; i < column.size() && i < below.sigma.size(); ++i) {
      if (above.used[i] && below.used[i])
        column[i] = std::numbers::sqrt2 * std::log(above.sigma[i] / below.sigma[i]) / (high - low);
    }
    out.slope.push_back(space[k].slope(z));
  }
  return out;
}

std::vector<double> spread_shift_of(const Evaluation& without, const Evaluation& with) {
  std::vector<double> shift(without.sigma.size(), 0);
  for (size_t i = 0; i < shift.size() && i < with.sigma.size(); ++i) {
    if (without.used[i] && with.used[i])
      shift[i] = std::numbers::sqrt2 * std::log(without.sigma[i] / with.sigma[i]);
  }
  return shift;
}

namespace {

PartInformation nothing(size_t columns) {
  const auto n = static_cast<Index>(columns);
  return {MatrixXd::Zero(n, n), VectorXd::Zero(n)};
}

// By group, or by block where one group alone is cut into blocks that are held out in turn.
struct Parts {
  std::vector<size_t> of_scalar;
  std::vector<char> trained;  // Of each part.
};

Parts parts_of(const Problem& problem) {
  const Facts& facts = problem.facts();
  Parts parts{.of_scalar = std::vector<size_t>(facts.scalars())};
  const bool blocks = facts.groups.size() == 1 && !problem.blocks().empty();
  const bool one_fold = !blocks && problem.folds().size() == 1;
  for (size_t i = 0; i < facts.scalars(); ++i)
    parts.of_scalar[i] = static_cast<size_t>(blocks ? problem.blocks()[i] : facts.group_of(i));
  parts.trained.assign(blocks ? problem.block_count() : facts.groups.size(), 0);
  for (size_t g = 0; one_fold && g < facts.groups.size(); ++g)
    parts.trained[g] = !problem.folds().front()[g];
  return parts;
}

}  // namespace

EffectLook look_of(const Problem& problem, const Evaluation& here, const Columns& columns,
                   const std::vector<double>& shift, size_t base, double repeats) {
  const Facts& facts = problem.facts();
  const size_t count = columns.by.size();
  const Parts parts = parts_of(problem);
  std::vector<PartInformation> of_part(parts.trained.size(), nothing(count));
  EffectLook look{.base = base};
  look.movement.assign(facts.channels.size(), nothing(count).information);
  std::vector<double> moved(facts.channels.size(), 0);
  VectorXd row(static_cast<Index>(count));
  for (size_t i = 0; i < facts.scalars(); ++i) {
    if (!here.used[i]) continue;
    for (size_t k = 0; k < count; ++k) row[static_cast<Index>(k)] = columns.by[k][i];
    PartInformation& part = of_part[parts.of_scalar[i]];
    part.information += repeats * row * row.transpose();
    part.score -= repeats * shift[i] * row;
    if (parts.trained[parts.of_scalar[i]]) continue;
    look.movement[facts.channel_of[i]] += row * row.transpose();
    ++moved[facts.channel_of[i]];
    look.residuals += repeats;
  }
  for (size_t c = 0; c < moved.size(); ++c)
    if (moved[c] > 0) look.movement[c] /= moved[c];
  for (size_t p = 0; p < of_part.size(); ++p) {
    if (!parts.trained[p]) {
      look.held.push_back(std::move(of_part[p]));
    } else if (look.in_turn()) {
      look.trained = std::move(of_part[p]);
    } else {
      look.trained.information += of_part[p].information;
      look.trained.score += of_part[p].score;
    }
  }
  return look;
}

}  // namespace seam::measurement
