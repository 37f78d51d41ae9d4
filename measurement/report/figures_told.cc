#include "measurement/report/figures_told.h"

#include <cmath>
#include <utility>

namespace seam::measurement {

std::vector<Figure> figures_told(const Problem& problem, const Assessment& assessment) {
  std::vector<Figure> figures = problem.figures(assessment.model);
  const Fit& fit = assessment.fit;
  const size_t n = assessment.unknowns.size();
  // By figure and unknown: the change by one error.
  std::vector<std::vector<double>> change(figures.size(), std::vector<double>(n, 0));
  constexpr double kStep = 0.01;  // Of an error.
  for (size_t k = 0; k < n && !figures.empty(); ++k) {
    if (!(fit.sigma[k] > 0) || !std::isfinite(fit.sigma[k])) continue;
    const auto& [effect, parameter] = assessment.unknowns[k];
    const auto& known = assessment.model.find(effect)->definition->parameters[parameter];
    double step = kStep * fit.sigma[k];
    if (fit.value[k] + step > known.max) step = -step;
    Model moved = assessment.model;
    moved.set_value(effect, parameter, fit.value[k] + step);
    const std::vector<Figure> there = problem.figures(moved);
    if (there.size() != figures.size()) continue;
    for (size_t f = 0; f < figures.size(); ++f)
      change[f][k] = (there[f].value - figures[f].value) / step * fit.sigma[k];
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
    figures[f].sigma = std::sqrt(variance);
  }
  return figures;
}

FigureTable figure_table(const Problem& problem, const Assessment& assessment) {
  FigureTable table = problem.facts().figures;
  if (table.figures.empty()) return table;
  for (Figure& figure : figures_told(problem, assessment))
    table.figures.push_back(std::move(figure));
  return table;
}

}  // namespace seam::measurement
