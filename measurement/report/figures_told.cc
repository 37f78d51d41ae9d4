#include "measurement/report/figures_told.h"

#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <utility>

#include "measurement/report/curves/curves_told.h"
#include "measurement/report/finite_or_null.h"

namespace seam::measurement {

using nlohmann::ordered_json;

std::vector<Figure> figures_told(const Problem& problem, const Assessment& assessment) {
  std::vector<Figure> figures = problem.figures(assessment.model);
  const Fit& fit = assessment.fit;
  const size_t n = assessment.unknowns.size();
  // By figure and unknown: the change by one error.
  std::vector<std::vector<double>> change(figures.size(), std::vector<double>(n, 0));
  std::vector<char> untold(figures.size(), 0);
  constexpr double kStep = 0.01;  // Of an error.
  for (size_t k = 0; k < n && !figures.empty(); ++k) {
    if (!(fit.sigma[k] > 0)) continue;
    const auto& [effect, parameter] = assessment.unknowns[k];
    const auto& known = assessment.model.find(effect)->definition->parameters[parameter];
    // What the data do not tell leaves each figure that depends on it untold.
    const bool told = std::isfinite(fit.sigma[k]);
    double step = kStep * (told ? fit.sigma[k] : known.scale);
    if (fit.value[k] + step > known.max) step = -step;
    Model moved = assessment.model;
    moved.set_value(effect, parameter, fit.value[k] + step);
    const std::vector<Figure> there = problem.figures(moved);
    if (there.size() != figures.size()) continue;
    for (size_t f = 0; f < figures.size(); ++f) {
      const double by = there[f].value - figures[f].value;
      if (told) change[f][k] = by / step * fit.sigma[k];
      if (!told && by != 0) untold[f] = 1;
    }
  }
  for (size_t f = 0; f < figures.size(); ++f) {
    double variance = 0;
    for (size_t i = 0; i < n; ++i) {
      for (size_t k = 0; k < n; ++k) {
        const double own =
            std::sqrt(fit.covariance[i * n + i]) * std::sqrt(fit.covariance[k * n + k]);
        if (change[f][i] == 0 || change[f][k] == 0 || !(own > 0)) continue;
        variance += change[f][i] * change[f][k] * fit.covariance[i * n + k] / own;
      }
    }
    figures[f].sigma = untold[f] ? std::numeric_limits<double>::infinity() : std::sqrt(variance);
  }
  return figures;
}

FigureTable figure_table(const Problem& problem, const Assessment& assessment) {
  FigureTable table = problem.facts().figures;
  if (table.title.empty()) return table;
  const bool measured = !table.figures.empty();
  // Where nothing is measured beside the model, what it states is no result.
  for (Figure& figure : figures_told(problem, assessment)) {
    if (measured || figure.sigma > 0) table.figures.push_back(std::move(figure));
  }
  return table;
}

std::string figures_text(const Problem& problem, const Assessment& assessment) {
  const FigureTable table = figure_table(problem, assessment);
  if (table.figures.empty()) return "";
  std::string text = fmt::format("{} ({}with standard errors):\n", table.title,
                                 table.curve.empty() ? "" : "by the standard's formulas, ");
  for (const Figure& figure : table.figures) {
    const std::string error = std::isfinite(figure.sigma)
                                  ? fmt::format("+- {:<8.2g} {}", figure.sigma, figure.unit)
                                  : "not determined by these data";
    text += fmt::format("  {:24s} {:10.{}g} {}\n", figure.name, figure.value,
                        table.curve.empty() ? 6 : 5, error);
  }
  return text;
}

void add_figures(ordered_json& json, const Problem& problem, const Assessment& assessment) {
  add_curves(json, problem, assessment.model);
  const FigureTable table = figure_table(problem, assessment);
  if (table.figures.empty()) return;
  ordered_json figures = ordered_json::array(), curve = ordered_json::array();
  for (const Figure& figure : table.figures) {
    figures.push_back({{"name", figure.name},
                       {"unit", figure.unit},
                       {"value", finite_or_null<ordered_json>(figure.value)},
                       {"sigma", finite_or_null<ordered_json>(figure.sigma)}});
  }
  for (const FigurePoint& point : table.curve) {
    curve.push_back({{"light", point.light},
                     {"signal_dn", point.signal_dn},
                     {"snr", finite_or_null<ordered_json>(point.snr)},
                     {"sigma", finite_or_null<ordered_json>(point.sigma)},
                     {"expected", finite_or_null<ordered_json>(point.expected)}});
  }
  json["figures"] = {{"title", table.title}, {"figures", figures}, {"snr_curve", curve}};
}

}  // namespace seam::measurement
