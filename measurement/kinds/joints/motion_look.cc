#include "measurement/kinds/joints/motion_look.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <complex>
#include <iterator>
#include <limits>
#include <utility>

#include "effects/stages/servo.h"
#include "measurement/fitting/parameter_space.h"
#include "measurement/kinds/joints/torque/two_columns.h"
#include "measurement/numerics/damped_step.h"
#include "measurement/numerics/linear_algebra.h"
#include "measurement/numerics/robust.h"
#include "sim_core/base/maths.h"

namespace seam::measurement {
namespace {

using Complex = std::complex<double>;

constexpr size_t kMostInstants = 1500, kLeastMoving = 30;
// Into so many pieces the time over which an acceleration is seen is cut: more where a command
// steps in it.
constexpr size_t kPieces = 4, kMostPieces = 8;

// Standard error of the second derivative of a parabola through 2 reach + 1 even samples.
double acceleration_error(double noise_rad, size_t reach, double dt_s) {
  const auto n = static_cast<double>(2 * reach + 1);
  return noise_rad * std::sqrt(720 / (n * (n * n - 1) * (n * n - 4))) / (dt_s * dt_s);
}

// The last row before this time.
size_t last_before(const JointLog& log, double t_s) {
  const auto next = std::lower_bound(log.time_s.begin(), log.time_s.end(), t_s);
  return next == log.time_s.begin() ? 0 : static_cast<size_t>(next - log.time_s.begin()) - 1;
}

// Whether the command makes most of its way from one row to the next, or the drive is switched.
bool steps_between(const JointLog& log, size_t first, size_t last) {
  double largest = 0, low = log.command_rad[first], high = low;
  for (size_t k = first; k < last; ++k) {
    if (log.enabled[k] != log.enabled[k + 1]) return true;
    const double next = log.command_rad[k + 1];
    largest = std::max(largest, std::abs(next - log.command_rad[k]));
    low = std::min(low, next), high = std::max(high, next);
  }
  return largest > 0.5 * (high - low);
}

double cost_of(const std::vector<double>& misses, double size) {
  double sum = 0;
  for (const double miss : misses) sum += std::log1p(miss * miss / (size * size));
  return std::isfinite(sum) ? sum : std::numeric_limits<double>::infinity();
}

}  // namespace

std::vector<SeenMotion> seen_motion(const JointLog& log, size_t stride, double noise_rad) {
  std::vector<SeenMotion> seen;
  const size_t n = log.time_s.size();
  if (n < 8) return seen;
  std::vector<double> steps;
  for (size_t k = 1; k < n; ++k) steps.push_back(log.time_s[k] - log.time_s[k - 1]);
  const double dt_s = median_of(steps);
  // Over more rows what happens between them is lost.
  size_t reach = 2;
  constexpr double kGoodEnough_radps2 = 2;
  while (reach < 12 && acceleration_error(noise_rad, reach, dt_s) > kGoodEnough_radps2) ++reach;
  const size_t width = 2 * reach + 1;
  Eigen::MatrixXd powers(width, 3);
  Eigen::VectorXd angles(width);
  for (size_t k = reach; k + reach < n; k += stride) {
    const double span_s = 0.5 * (log.time_s[k + reach] - log.time_s[k - reach]);
    for (size_t j = 0; j < width; ++j) {
      const double t = (log.time_s[k - reach + j] - log.time_s[k]) / span_s;
      powers.row(static_cast<Eigen::Index>(j)) << 1, t, t * t;
      angles[static_cast<Eigen::Index>(j)] = log.measured_rad[k - reach + j];
    }
    const Eigen::Vector3d c =
        solve_symmetric(powers.transpose() * powers, powers.transpose() * angles);
    seen.push_back({.row = k,
                    .reach = reach,
                    .q_rad = c[0],
                    .w_radps = c[1] / span_s,
                    .a_radps2 = 2 * c[2] / (span_s * span_s),
                    .reach_s = span_s,
                    .rest_radps = 4 * noise_rad / span_s});
  }
  return seen;
}

MotionLook::MotionLook(const JointLogs& set, const std::vector<char>& chosen, double noise_rad,
                       bool without_friction) {
  size_t rows = 0;
  for (size_t i = 0; i < set.logs.size(); ++i) rows += chosen[i] ? set.logs[i].rows.size() : 0;
  const size_t stride = std::max<size_t>(1, rows / kMostInstants);
  for (size_t i = 0; i < set.logs.size(); ++i) {
    if (!chosen[i]) continue;
    const JointLog& log = set.logs[i];
    for (const SeenMotion& at : seen_motion(log, stride, noise_rad))
      instants_.push_back(instant_of(log, at));
  }
  if (!without_friction) return;
  std::vector<Instant> moving;
  std::copy_if(instants_.begin(), instants_.end(), std::back_inserter(moving),
               [](const Instant& at) { return at.moves; });
  if (moving.size() >= kLeastMoving) instants_ = std::move(moving);
}

// The curvature of a parabola through even samples is a mean of the acceleration, with the weights
// (1 - x^2)^2 over their reach: the second integral of Legendre's polynomial of degree 2. The
// commands hold from row to row, so that a step of theirs stands at its place in this mean.
MotionLook::Instant MotionLook::instant_of(const JointLog& log, const SeenMotion& at) {
  Instant instant{.log = &log,
                  .a_radps2 = at.a_radps2,
                  .rest_radps = at.rest_radps,
                  .reach_s = at.reach_s,
                  .moves = std::abs(at.w_radps) > at.rest_radps};
  const size_t first = at.row - at.reach;
  const bool steps = steps_between(log, first, at.row + at.reach);
  const size_t pieces = std::min(2 * at.reach, steps ? kMostPieces : kPieces);
  for (size_t piece = 0; piece < pieces; ++piece) {
    const double from_s = log.time_s[first + 2 * at.reach * piece / pieces];
    const double to_s = log.time_s[first + 2 * at.reach * (piece + 1) / pieces];
    const double at_s = 0.5 * (from_s + to_s), dt_s = at_s - log.time_s[at.row];
    const double x = dt_s / at.reach_s, inside = std::max(0.0, 1 - x * x);
    const double q_rad = at.q_rad + dt_s * (at.w_radps + 0.5 * dt_s * at.a_radps2);
    instant.pieces.push_back({.at_s = at_s,
                              .weight = inside * inside * (to_s - from_s),
                              .state = {q_rad, at.w_radps + dt_s * at.a_radps2},
                              .cos_q = maths::cos(q_rad),
                              .sin_q = maths::sin(q_rad),
                              .row = last_before(log, at_s)});
    instant.weights += instant.pieces.back().weight;
  }
  return instant;
}

std::vector<double> MotionLook::misses(const Model& model) const {
  const effects::ServoModel servo = effects::servo_of(model);
  const effects::HangingLoad load(servo.torque);
  std::vector<double> misses;
  misses.reserve(instants_.size());
  for (const Instant& at : instants_) {
    const JointLog& log = *at.log;
    double sum = 0;
    for (const Piece& piece : at.pieces) {
      const size_t given =
          servo.latency_s == 0 ? piece.row : last_before(log, piece.at_s - servo.latency_s);
      const effects::MotorInput input{.command_rad = log.command_rad[given],
                                      .kp = log.kp[given],
                                      .voltage = log.voltage[piece.row],
                                      .strength = servo.torque.strength_at(log.warmer_k[piece.row]),
                                      .enabled = log.enabled[given] != 0,
                                      .t_s = piece.at_s};
      const double load_radps2 = load.at(piece.state.q_rad, piece.cos_q, piece.sin_q) -
                                 effects::push_on(servo, input, piece.state);
      sum += piece.weight * effects::motor_acceleration(servo.torque, input, piece.state,
                                                        load_radps2, at.rest_radps);
    }
    misses.push_back(at.a_radps2 - sum / at.weights);
  }
  return misses;
}

double MotionLook::descend(Model& model, const std::vector<Unknown>& unknowns) const {
  if (instants_.empty()) return std::numeric_limits<double>::infinity();
  const ParameterSpace space(model, unknowns);
  const auto rows = static_cast<Eigen::Index>(instants_.size());
  Eigen::VectorXd place = space.place(model);
  std::vector<double> here = misses(model);
  // Rows beside a step of the command fit no smooth motion: they count less the more they miss.
  const auto size_of = [](const std::vector<double>& list) {
    return std::max(2 * robust_sigma(list), 1e-9);
  };
  double size = size_of(here), cost = cost_of(here, size);
  const auto look = [&] {
    size = size_of(here), cost = cost_of(here, size);
    Eigen::MatrixXd jacobian(rows, place.size());
    Eigen::VectorXd residual(rows);
    Eigen::VectorXd weight(rows);
    for (Eigen::Index k = 0; k < rows; ++k) {
      const double share = here[static_cast<size_t>(k)] / size;
      weight[k] = 1 / std::sqrt(1 + share * share) / size;
      residual[k] = weight[k] * here[static_cast<size_t>(k)];
    }
    for (Eigen::Index i = 0; i < place.size(); ++i) {
      const Coordinate& c = space[static_cast<size_t>(i)];
      double step = 1e-4 * std::max(c.scale, std::abs(place[i]));
      if (place[i] + step > c.max) step = -step;
      const auto there = misses(space.with(model, static_cast<size_t>(i), place[i] + step));
      for (Eigen::Index k = 0; k < rows; ++k)
        jacobian(k, i) =
            weight[k] * (there[static_cast<size_t>(k)] - here[static_cast<size_t>(k)]) / step;
    }
    Parabola parabola = parabola_of(jacobian, residual);
    parabola.held = space.box().held(place, parabola.gradient);
    return parabola;
  };
  const auto move = [&](const Eigen::VectorXd& by) {
    const Eigen::VectorXd next = space.box().inside(place + by);
    const auto there = misses(space.at(model, next));
    const double lower = cost_of(there, size);
    if (!(lower < cost)) return false;
    place = next, here = there, cost = lower;
    model = space.at(model, place);
    return true;
  };
  measurement::descend({.look = look,
                        .move = move,
                        .height = [&] { return 0.5 * cost; },
                        .worth = [&] { return Worth{.gain = 1e-4 * cost}; }},
                       {.start = 1e-3, .attempts = 6}, 15);
  return this->cost(model);
}

double MotionLook::cost(const Model& model) const {
  constexpr double kUnit_radps2 = 5;
  return cost_of(misses(model), kUnit_radps2);
}

std::vector<double> MotionLook::torque_waves(const Model& model, double least, double most,
                                             double step, size_t count) const {
  const std::vector<double> missed = misses(model);
  const double size = std::max(2 * robust_sigma(missed), 1e-9);
  struct Part {
    double weight, way_rad;  // Half the way of the piece.
    Complex at, turn;
  };
  struct Row {
    double miss, trust;
    std::vector<Part> parts;
  };
  std::vector<Row> rows;
  for (size_t i = 0; i < instants_.size(); ++i) {
    const Instant& at = instants_[i];
    if (!at.moves || !std::isfinite(missed[i])) continue;
    Row row{missed[i], 1 / (1 + missed[i] * missed[i] / (size * size)), {}};
    const auto pieces = static_cast<double>(at.pieces.size());
    for (const Piece& piece : at.pieces) {
      const double q = piece.state.q_rad;
      row.parts.push_back({piece.weight / at.weights,
                           piece.state.w_radps * at.reach_s / pieces,
                           {maths::cos(least * q), maths::sin(least * q)},
                           {maths::cos(step * q), maths::sin(step * q)}});
    }
    rows.push_back(std::move(row));
  }
  std::vector<double> gains;
  for (double waves = least; waves <= most; waves += step) {
    double ss = 0, sc = 0, cc = 0, with_s = 0, with_c = 0;
    for (Row& row : rows) {
      Complex mean = 0;
      for (Part& part : row.parts) {
        // What of a wave is left in the mean over a piece.
        const double turned = waves * part.way_rad;
        mean += part.weight * std::max(0.0, 1 - turned * turned / 6) * part.at;
        part.at *= part.turn;
      }
      const double s = mean.imag(), c = mean.real();
      ss += row.trust * s * s, sc += row.trust * s * c, cc += row.trust * c * c;
      with_s += row.trust * s * row.miss, with_c += row.trust * c * row.miss;
    }
    gains.push_back(least_squares(ss, sc, cc, with_s, with_c).gain);
  }
  std::vector<size_t> peaks;
  for (size_t i = 0; i < gains.size(); ++i) {
    const bool above =
        (i == 0 || gains[i] >= gains[i - 1]) && (i + 1 == gains.size() || gains[i] > gains[i + 1]);
    if (above && gains[i] > 0) peaks.push_back(i);
  }
  std::stable_sort(peaks.begin(), peaks.end(),
                   [&](size_t a, size_t b) { return gains[a] > gains[b]; });
  peaks.resize(std::min(peaks.size(), count));
  std::vector<double> strongest;
  for (const size_t i : peaks) strongest.push_back(least + static_cast<double>(i) * step);
  return strongest;
}

}  // namespace seam::measurement
