// Encoders with steps: whether a log's angles are multiples of one, and how a model then reads
// them.
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>

#include "effects/stages/noise.h"
#include "measurement/kinds/joints/joints.h"
#include "measurement/noise/value_steps.h"
#include "measurement/numerics/moments.h"
#include "sim_core/base/random.h"

namespace seam::measurement {
namespace {

constexpr double kSoftening = 0.05;  // Of a step.

// Noise that was estimated holds the rounding to steps: what is behind it, by rows between which
// the joint moves by a step at least. A slower one's rounding repeats itself and says nothing.
double noise_behind_steps(const JointLogs& set, double step_rad, double noise_rad) {
  constexpr size_t kFewest = 5, kEnough = 100;  // Rows in a row; together.
  std::vector<std::vector<double>> times, values;
  size_t rows = 0;
  for (const JointLog& log : set.logs) {
    size_t from = 0;
    for (size_t k = 1; k <= log.rows.size(); ++k) {
      if (k < log.rows.size() &&
          std::abs(log.measured_rad[k] - log.measured_rad[k - 1]) > 0.5 * step_rad)
        continue;
      if (k - from >= kFewest) {
        const auto part = [&](const std::vector<double>& all) {
          return std::vector<double>(all.begin() + static_cast<std::ptrdiff_t>(from),
                                     all.begin() + static_cast<std::ptrdiff_t>(k));
        };
        times.push_back(part(log.time_s)), values.push_back(part(log.measured_rad));
        rows += k - from;
      }
      from = k;
    }
  }
  if (rows < kEnough) return noise_rad;
  const double moving = noise_from_neighbours(times, values);
  return std::sqrt(std::max(0.0, moving * moving - step_rad * step_rad / 12));
}

// A joint at rest near an edge between steps goes over it and back as its noise has it: in one of
// three rows in a row with the chance p (1 - p), p being that of the upper step; over all places of
// the edge that is sigma / (sqrt(pi) step). At most so much, by how rests differ: each is one draw
// of the place. Infinite where it rests too seldom.
double noise_by_flicker(const JointLogs& set, double step_rad) {
  constexpr size_t kLeastRows = 20, kFewestRests = 10;
  constexpr double kWidest = 2.5;  // Steps of a rest: with its noise it may see three.
  constexpr double kAtAnEdge = 0.25;
  std::vector<double> shares = {kAtAnEdge};  // One more rest: that none of a few flickers is luck.
  for (const JointLog& log : set.logs) {
    const std::vector<double>& x = log.measured_rad;
    for (size_t from = 0, to = 0; from < x.size(); from = to) {
      double low = x[from], high = x[from];
      for (to = from + 1; to < x.size(); ++to) {
        low = std::min(low, x[to]), high = std::max(high, x[to]);
        if (high - low > kWidest * step_rad) break;
      }
      if (to - from < kLeastRows) continue;
      double back = 0;
      for (size_t k = from + 1; k + 1 < to; ++k) back += (x[k] - x[k - 1]) * (x[k + 1] - x[k]) < 0;
      shares.push_back(back / static_cast<double>(to - from - 2));
    }
  }
  if (shares.size() <= kFewestRests) return INFINITY;
  const double error = deviation_of(shares) / std::sqrt(static_cast<double>(shares.size()));
  return step_rad * std::sqrt(std::numbers::pi) * (mean_of(shares) + error);
}

}  // namespace

double step_of_angles(const JointLogs& set) {
  // Angles are written with 6 decimals by `seam measure`: what is no coarser is no encoder's.
  constexpr double kFinest_rad = 3e-5;
  std::map<std::string, std::vector<double>> angles;  // By joint: each may have an offset.
  for (const JointLog& log : set.logs) {
    std::vector<double>& all = angles[log.joint];
    all.insert(all.end(), log.measured_rad.begin(), log.measured_rad.end());
  }
  std::vector<std::vector<double>> series;
  for (auto& [joint, all] : angles) series.push_back(std::move(all));
  const double step_rad = step_of_values(series);
  return step_rad > kFinest_rad ? step_rad : 0;
}

void JointsProblem::look_for_steps() {
  std::vector<std::vector<double>> times, values;
  for (const JointLog& log : set_.logs) {
    times.push_back(log.time_s);
    values.push_back(log.measured_rad);
  }
  const double noise = facts_.channels[0].noise;
  const double scatter =
      facts_.channels[0].estimated ? noise : noise_from_neighbours(times, values);
  lattice_rad_ = step_of_angles(set_);
  // A fast joint goes another way than its neighbours' cubic, so that both estimates err upwards.
  behind_steps_rad_ = lattice_rad_ > 0 && facts_.channels[0].estimated
                          ? std::min(noise_behind_steps(set_, lattice_rad_, noise),
                                     noise_by_flicker(set_, lattice_rad_))
                          : noise;
  if (lattice_rad_ > 0) {
    largest_step_rad_ = lattice_rad_;
  } else if (scatter > 1.2 * noise) {
    largest_step_rad_ = 1.3 * std::sqrt(12 * (scatter * scatter - noise * noise));
  }
  if (lattice_rad_ == 0 || behind_steps_rad_ >= lattice_rad_) return;
  mark_shared_errors();
  constexpr double kFiner = 0.6;
  double behind = behind_steps_rad_;
  do {
    // The angle itself is known only so well, which softens the edges between steps.
    roundings_.emplace_back(lattice_rad_, std::hypot(behind, kSoftening * lattice_rad_));
    behind *= kFiner;
  } while (facts_.channels[0].estimated && behind > kSoftening * lattice_rad_);
}

// Of each stay on a step one row speaks, drawn by chance: the first would always lie behind the
// edge that the joint came over, the last before the next.
void JointsProblem::mark_shared_errors() {
  facts_.shares_error.assign(facts_.rows(), 1);
  for (const JointLog& log : set_.logs) {
    const std::vector<double>& x = log.measured_rad;
    for (size_t from = 0, to = 0; from < x.size(); from = to) {
      while (to < x.size() && std::abs(x[to] - x[from]) < 0.5 * lattice_rad_) ++to;
      const double place = uniform(RandomStream{}, log.rows[from]) * static_cast<double>(to - from);
      facts_.shares_error[log.rows[from + static_cast<size_t>(place)]] = 0;
    }
  }
}

JointsProblem::Reading JointsProblem::reading_of(const Model& model) const {
  effects::JointTrack track;
  effects::apply_encoder_effects(model, track);
  const double step = std::min(track.quantisation_step_rad, largest_step_rad_);
  const bool on_lattice = lattice_rad_ > 0 && step > 0.99 * lattice_rad_;
  const double noise = on_lattice ? behind_steps_rad_ : facts_.channels[0].noise;
  const double sigma = step == 0 ? noise : std::sqrt(noise * noise + step * step / 12);
  // No chance is above 1: an error that wanders would take the rounding of a joint at rest for its
  // own otherwise, and be likelier than the truth.
  const effects::Noise spread = effects::noise_of(model);
  if (!spread.joint.empty() || spread.command_sigma_s > 0)
    return {.sigma_rad = std::max(sigma, lattice_rad_ / std::sqrt(2 * std::numbers::pi))};
  if (!on_lattice || roundings_.empty()) return {.sigma_rad = sigma};
  return {.sigma_rad = roundings_.front().sigma_rad(), .rounded = roundings_.front()};
}

// Both estimates from the measurements alone err upwards: what they see of a joint that turns is
// its motion, too.
const RoundedAngle& JointsProblem::likeliest_rounding(const Evaluation& seen) const {
  double most = -std::numeric_limits<double>::infinity();
  const RoundedAngle* likeliest = &roundings_.front();
  for (const RoundedAngle& rounded : roundings_) {
    double likelihood = 0;
    for (size_t i = 0; i < facts_.rows(); ++i) {
      if (!seen.used[i]) continue;
      const double z = rounded.z(seen.residual[i]);
      likelihood -= 0.5 * z * z + std::log(rounded.sigma_rad());
    }
    if (likelihood > most) most = likelihood, likeliest = &rounded;
  }
  return *likeliest;
}

void JointsProblem::whiten_rounded(const RoundedAngle& rounded, Evaluation& evaluation) const {
  for (size_t i = 0; i < facts_.rows(); ++i) {
    if (evaluation.used[i]) evaluation.whitened[i] = rounded.z(evaluation.residual[i]);
  }
  evaluation.mean_square.assign(facts_.rows(), rounded.mean_square());
  evaluation.mean_square.resize(facts_.scalars(), 1);
}

void JointsProblem::bound_chances(Evaluation& evaluation) const {
  if (roundings_.empty() || !facts_.channels[0].estimated) return;
  const double least = lattice_rad_ / std::sqrt(2 * std::numbers::pi);
  for (size_t i = 0; i < facts_.rows(); ++i) {
    if (evaluation.used[i] && evaluation.sigma[i] < least)
      evaluation.log_det[facts_.group_of(i)] += 2 * std::log(least / evaluation.sigma[i]);
  }
}

std::vector<double> JointsProblem::change_of(const Model& model, const Evaluation& here,
                                             const Evaluation& there) const {
  std::vector<double> change(facts_.scalars(), 0);
  if (!there.valid) return change;
  // The one that `here` was whitened by.
  const auto rounded =
      std::find_if(roundings_.begin(), roundings_.end(), [&](const RoundedAngle& one) {
        return !here.mean_square.empty() && one.mean_square() == here.mean_square.front();
      });
  const bool is_rounded = rounded != roundings_.end() && reading_of(model).rounded;
  for (size_t i = 0; i < change.size(); ++i) {
    if (!here.used[i]) continue;
    // Edges between steps are narrower than what differences of parameters move.
    change[i] = is_rounded && i < facts_.rows()
                    ? rounded->slope(here.residual[i]) * (there.residual[i] - here.residual[i])
                    : there.whitened[i] - here.whitened[i];
  }
  return change;
}

}  // namespace seam::measurement
