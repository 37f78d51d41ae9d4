#include "measurement/kinds/landmarks/landmark_noise.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <tuple>

#include "measurement/noise/draw.h"
#include "measurement/noise/hidden_errors.h"
#include "sim_core/base/maths.h"

namespace seam::measurement {
namespace {

using Share = HiddenErrors::Share;

// The hidden errors of the rows of one run and one group.
class ErrorsOfRun {
 public:
  ErrorsOfRun(const effects::Noise& noise, HiddenErrors& errors) : noise_(noise), errors_(errors) {
    for (const effects::Wander& wander : noise.heading) heading_.push_back(add(wander));
  }

  const std::vector<Share>& of_range(int landmark) {
    return of(range_, landmark, noise_.range, noise_.range_bias_variance, {});
  }
  const std::vector<Share>& of_bearing(int landmark) {
    return of(bearing_, landmark, noise_.bearing, noise_.bearing_bias_variance, heading_);
  }

 private:
  Share add(const effects::Wander& wander) {
    return {.hidden = errors_.add(wander.sigma * wander.sigma, wander.tau_s)};
  }
  const std::vector<Share>& of(std::map<int, std::vector<Share>>& known, int landmark,
                               const std::vector<effects::Wander>& wanders, double bias_variance,
                               const std::vector<Share>& common) {
    const auto [found, is_new] = known.try_emplace(landmark, common);
    if (!is_new) return found->second;
    for (const effects::Wander& wander : wanders) found->second.push_back(add(wander));
    if (bias_variance > 0)
      found->second.push_back({.hidden = errors_.add(bias_variance, kLasting)});
    return found->second;
  }

  const effects::Noise& noise_;
  HiddenErrors& errors_;
  std::vector<Share> heading_;
  std::map<int, std::vector<Share>> range_, bearing_;
};

}  // namespace

std::vector<std::vector<int>> rows_of_errors(const LandmarkData& data, const Facts& facts) {
  std::map<std::pair<int, int>, std::vector<int>> rows;
  for (size_t row = 0; row < data.stamp_s.size(); ++row)
    rows[{data.walk_of_row[row], facts.group_of_row[row]}].push_back(static_cast<int>(row));
  std::vector<std::vector<int>> all;
  for (auto& [key, list] : rows) {
    std::stable_sort(list.begin(), list.end(),
                     [&](int a, int b) { return data.stamp_s[a] < data.stamp_s[b]; });
    all.push_back(std::move(list));
  }
  return all;
}

std::vector<Displacement> whiten_landmarks(const LandmarkData& data, const Facts& facts,
                                           const std::vector<std::vector<int>>& rows_of_errors,
                                           const effects::Noise& noise, const JitterSlopes& jitter,
                                           const PlaceSlopes& places,
                                           const std::vector<CommonSlopes>& common,
                                           const Groups& groups, Evaluation& evaluation) {
  std::optional<FewErrors> tail;
  if (!noise.range_tail.none())
    tail.emplace(FewErrors::Sort::exponential, noise.range_tail.fraction, noise.range_tail.size);
  HiddenErrors errors;
  const bool displaced = noise.place_variance > 0;
  // Of each landmark's x, followed by that of its y.
  std::vector<int> place_of_landmark;
  for (size_t k = 0; displaced && k < data.landmarks.size(); ++k) {
    place_of_landmark.push_back(errors.add(noise.place_variance, kLasting));
    errors.add(noise.place_variance, kLasting);
  }
  std::vector<int> delay_of_landmark;
  const bool delayed = noise.delay_variance > 0;
  for (size_t k = 0; delayed && k < data.landmarks.size(); ++k)
    delay_of_landmark.push_back(errors.add(noise.delay_variance, kLasting));
  std::vector<int> unknown;
  for (size_t k = 0; k < common.size(); ++k) unknown.push_back(errors.add(1, kLasting));
  std::vector<ErrorsOfRun> runs;
  std::vector<int> own_latency;
  std::vector<std::pair<int, size_t>> order;  // Rows with the run that they are of.
  for (const std::vector<int>& rows : rows_of_errors) {
    if (!groups[facts.group_of_row[rows.front()]]) continue;
    for (const int row : rows) order.emplace_back(row, runs.size());
    runs.emplace_back(noise, errors);
    own_latency.push_back(jitter ? errors.add(1, 0) : -1);
  }
  // Runs that share the landmarks' places or delays are one part, whose residuals come in order of
  // time.
  if (displaced || delayed)
    std::stable_sort(order.begin(), order.end(), [&](const auto& a, const auto& b) {
      return data.stamp_s[a.first] < data.stamp_s[b.first];
    });
  std::vector<Share> shares;
  for (const auto& [row, run] : order) {
    const int landmark = data.landmark_of_row[row];
    const std::array<double, 2> late = jitter ? jitter(row) : std::array<double, 2>{};
    const auto moved = displaced ? places(row) : std::array<std::array<double, 2>, 2>{};
    for (size_t c = 0; c < 2; ++c) {
      if (data.scalars[row][c] < 0) continue;
      shares = c == 0 ? runs[run].of_range(landmark) : runs[run].of_bearing(landmark);
      if (jitter) shares.push_back({own_latency[run], late[c]});
      for (int axis = 0; displaced && axis < 2; ++axis)
        shares.push_back({place_of_landmark[landmark] + axis, moved[c][axis]});
      if (delayed && c == 0) shares.push_back({delay_of_landmark[landmark], 1});
      for (size_t k = 0; k < common.size(); ++k)
        shares.push_back({unknown[k], common[k][static_cast<size_t>(data.scalars[row][c])]});
      errors.observe(static_cast<size_t>(data.scalars[row][c]), data.stamp_s[row], shares,
                     c == 0 && tail ? &*tail : nullptr);
    }
  }
  const std::vector<HiddenErrors::Learnt> learnt = errors.learn(facts, evaluation);
  std::vector<Displacement> displacements(displaced || delayed ? data.landmarks.size() : 0);
  for (size_t k = 0; k < place_of_landmark.size(); ++k) {
    const int x = place_of_landmark[k];
    displacements[k].mean_m = {learnt[x].mean, learnt[x + 1].mean};
    displacements[k].covariance_m2 = {learnt[x].variance, learnt[x + 1].variance,
                                      learnt[x].with_next};
  }
  for (size_t k = 0; k < delay_of_landmark.size(); ++k) {
    const auto& [mean, variance, next] = learnt[delay_of_landmark[k]];
    displacements[k].delay_m = mean, displacements[k].delay_variance_m2 = variance;
  }
  return displacements;
}

LandmarkErrors draw_landmark_errors(const LandmarkData& data, const effects::Noise& noise,
                                    RandomStream stream) {
  const size_t n = data.stamp_s.size();
  LandmarkErrors errors{std::vector<double>(n, 0), std::vector<double>(n, 0)};
  // Rows of a run, and of a landmark's track in it, in order of time.
  std::map<std::pair<int, int>, std::vector<size_t>> tracks;
  std::map<int, std::vector<size_t>> runs;
  for (size_t row = 0; row < n; ++row) {
    tracks[{data.walk_of_row[row], data.landmark_of_row[row]}].push_back(row);
    runs[data.walk_of_row[row]].push_back(row);
  }
  const auto wander = [&](const char* name, const std::vector<effects::Wander>& wanders,
                          const std::vector<size_t>& rows, std::vector<double>& into) {
    for (size_t w = 0; w < wanders.size(); ++w)
      add_wander(wanders[w], data.stamp_s, rows, stream.child(name).child(w), into);
  };
  for (const auto& [run, rows] : runs) wander("heading", noise.heading, rows, errors.bearing_rad);
  for (const auto& [track, rows] : tracks) {
    wander("range", noise.range, rows, errors.range_m);
    wander("bearing", noise.bearing, rows, errors.bearing_rad);
    const double range = std::sqrt(noise.range_bias_variance) *
                         normal(stream.child("range_bias"), rows.front()),
                 bearing = std::sqrt(noise.bearing_bias_variance) *
                           normal(stream.child("bearing_bias"), rows.front());
    for (const size_t row : rows) errors.range_m[row] += range, errors.bearing_rad[row] += bearing;
  }
  for (size_t row = 0; row < n; ++row) {
    if (uniform(stream.child("tail"), row) < noise.range_tail.fraction)
      errors.range_m[row] -=
          noise.range_tail.size * maths::log(uniform(stream.child("tail_size"), row));
  }
  return errors;
}

}  // namespace seam::measurement
