#include "measurement/report/report_plots.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <numeric>

#include "sim_core/base/error.h"
#include "sim_core/base/random.h"

namespace seam::measurement {
namespace {

using nlohmann::json;

struct Sums {
  size_t n = 0;
  double x = 0, r = 0, r2 = 0, s2 = 0;
};

json bin_of(const Sums& sums, double low, double high) {
  const double n = static_cast<double>(sums.n), mean = sums.r / n;
  const double scatter =
      sums.n > 1 ? std::sqrt(std::max(0.0, (sums.r2 - n * mean * mean) / (n - 1))) : NAN;
  return {{"low", six_digits(low)},           {"high", six_digits(high)},
          {"centre", six_digits(sums.x / n)}, {"n", sums.n},
          {"mean", six_digits(mean)},         {"mean_sigma", six_digits(std::sqrt(sums.s2) / n)},
          {"scatter", six_digits(scatter)},   {"formal", six_digits(std::sqrt(sums.s2 / n))}};
}

}  // namespace

json six_digits(double value) {
  if (!std::isfinite(value)) return nullptr;
  return std::strtod(fmt::format("{:.6g}", value).c_str(), nullptr);
}

std::vector<size_t> some_of(size_t count, size_t most) {
  const size_t k = std::max<size_t>(1, (count + most - 1) / most);
  std::vector<size_t> some;
  for (size_t first = 0; first < count; first += k) {
    const double lot = uniform({.seed = 1, .stream = 0}, first);
    some.push_back(first +
                   static_cast<size_t>(lot * static_cast<double>(std::min(k, count - first))));
  }
  return some;
}

json residual_plot(const ResidualView& view, const Structure& structure, bool tested,
                   const std::string& stage) {
  // Where the mean was averaged over repeats, single values show the spread.
  const ResidualView::Channel* channel =
      structure.moment == "spread" ? view.channel(structure.residual + " spread") : nullptr;
  if (!channel) channel = view.channel(structure.residual);
  const std::vector<double> covariate = view.covariate(structure.covariate);
  if (!channel || covariate.empty()) return nullptr;
  std::vector<size_t> order;
  for (size_t i = 0; i < channel->row.size(); ++i) {
    if (std::isfinite(covariate[channel->row[i]])) order.push_back(i);
  }
  if (order.size() < 8) return nullptr;
  const auto x = [&](size_t i) { return covariate[channel->row[i]]; };
  std::stable_sort(order.begin(), order.end(), [&](size_t a, size_t b) { return x(a) < x(b); });

  const size_t bins = std::clamp<size_t>(order.size() / 20, 4, 24);
  const size_t size = (order.size() + bins - 1) / bins;
  json list = json::array();
  Sums sums;
  double low = x(order[0]);
  for (size_t k = 0; k < order.size(); ++k) {
    const size_t i = order[k];
    // Equal values stay together: signs and labels get a bin each.
    if (sums.n >= size && x(i) != x(order[k - 1])) {
      list.push_back(bin_of(sums, low, x(order[k - 1])));
      sums = {};
      low = x(i);
    }
    const double r = channel->residual[i], s = channel->sigma[i];
    sums = {sums.n + 1, sums.x + x(i), sums.r + r, sums.r2 + r * r, sums.s2 + s * s};
  }
  list.push_back(bin_of(sums, low, x(order.back())));

  json sample = json::array();
  if (stage == "before") {
    for (const size_t i : some_of(channel->row.size(), 1000)) {
      if (std::isfinite(x(i)))
        sample.push_back({six_digits(x(i)), six_digits(channel->residual[i])});
    }
  }
  json plot = {{"residual", structure.residual}, {"covariate", structure.covariate},
               {"moment", structure.moment},     {"stage", stage},
               {"bins", std::move(list)},        {"sample", std::move(sample)}};
  if (tested) {
    plot["strength"] = six_digits(structure.strength);
    plot["p_value"] = structure.p_value;
  }
  return plot;
}

json arrow_plot(const ResidualView& view, const std::string& stage) {
  const ResidualView::Channel *u = view.channel("u_px"), *v = view.channel("v_px");
  const std::vector<double> column = view.covariate("column"), row = view.covariate("row");
  if (!u || !v || column.empty() || row.empty()) return nullptr;
  std::vector<double> dv(column.size(), NAN);
  for (size_t i = 0; i < v->row.size(); ++i) dv[v->row[i]] = v->residual[i];
  json items = json::array();
  for (const size_t i : some_of(u->row.size(), 600)) {
    const int at = u->row[i];
    if (!std::isfinite(dv[at])) continue;
    items.push_back({six_digits(column[at]), six_digits(row[at]), six_digits(u->residual[i]),
                     six_digits(dv[at])});
  }
  return {{"stage", stage}, {"plane", "image_px"}, {"unit", "px"}, {"items", std::move(items)}};
}

json image_map(const ResidualView& view, const std::string& stage) {
  const ResidualView::Channel* dn = view.channel("dn");
  const std::vector<double> column = view.covariate("column"), row = view.covariate("row");
  if (!dn || dn->row.empty() || column.empty() || row.empty()) return nullptr;
  const double width = *std::max_element(column.begin(), column.end()) + 1;
  const double height = *std::max_element(row.begin(), row.end()) + 1;
  const int columns = static_cast<int>(std::min(44.0, width)),
            rows = static_cast<int>(std::min(36.0, height));
  std::vector<double> sum(static_cast<size_t>(columns) * rows, 0), count(sum.size(), 0);
  for (size_t i = 0; i < dn->row.size(); ++i) {
    const int at = dn->row[i];
    const int c =
        std::clamp(static_cast<int>((column[at] + 0.5) / width * columns), 0, columns - 1);
    const int r = std::clamp(static_cast<int>((row[at] + 0.5) / height * rows), 0, rows - 1);
    sum[static_cast<size_t>(r) * columns + c] += dn->residual[i];
    count[static_cast<size_t>(r) * columns + c] += 1;
  }
  json values = json::array();
  for (size_t i = 0; i < sum.size(); ++i)
    values.push_back(count[i] > 0 ? six_digits(sum[i] / count[i]) : json(nullptr));
  return {{"stage", stage},      {"title", "Mean residual"},
          {"unit", "dn"},        {"columns", columns},
          {"rows", rows},        {"width_px", width},
          {"height_px", height}, {"values", std::move(values)}};
}

void append_histograms(const ResidualView& view, size_t channels, const std::string& stage,
                       json& list) {
  constexpr double kReach = 6, kWidth = 0.25;
  constexpr int kBins = static_cast<int>(2 * kReach / kWidth);
  for (size_t c = 0; c < std::min(channels, view.channels.size()); ++c) {
    const ResidualView::Channel& channel = view.channels[c];
    if (channel.residual.size() < 20) continue;
    std::vector<int> counts(kBins, 0);
    for (size_t i = 0; i < channel.residual.size(); ++i) {
      const double z = channel.residual[i] / channel.sigma[i];
      if (!std::isfinite(z)) continue;
      // What lies beyond is counted in the last bins: it must not vanish.
      ++counts[std::clamp(
          static_cast<int>(std::floor((std::clamp(z, -kReach, kReach) + kReach) / kWidth)), 0,
          kBins - 1)];
    }
    json edges = json::array();
    for (int i = 0; i <= kBins; ++i) edges.push_back(-kReach + i * kWidth);
    list.push_back({{"residual", channel.name},
                    {"stage", stage},
                    {"edges", std::move(edges)},
                    {"counts", counts}});
  }
}

}  // namespace seam::measurement
