#include "measurement/report/curves/curves_told.h"

#include <fmt/format.h>

#include <cmath>

#include "measurement/problem/curves.h"

namespace seam::measurement {
namespace {

using nlohmann::json;
using nlohmann::ordered_json;

std::vector<Curve> curves_of(const Problem& problem, const Model& model) {
  const auto* has = dynamic_cast<const HasCurves*>(&problem);
  return has == nullptr ? std::vector<Curve>{} : has->curves(model);
}

bool can_be_drawn(double value) {
  return std::isfinite(value) && value > 0;
}

// A line through points on logarithmic axes; gaps where there is no value.
json line_of(const std::string& name, const Curve& curve, double (*value)(const CurvePoint&)) {
  json points = json::array();
  for (const CurvePoint& point : curve.points) {
    if (const double y = value(point); can_be_drawn(y))
      points.push_back({std::log10(point.at), std::log10(y)});
  }
  return {{"name", name}, {"points", std::move(points)}};
}

}  // namespace

void add_curves(ordered_json& json, const Problem& problem, const Model& model) {
  const std::vector<Curve> curves = curves_of(problem, model);
  if (curves.empty()) return;
  ordered_json list = ordered_json::array();
  for (const Curve& curve : curves) {
    ordered_json points = ordered_json::array();
    for (const CurvePoint& point : curve.points) {
      points.push_back({{"at", point.at},
                        {"value", point.value},
                        {"sigma", point.sigma},
                        {"expected", std::isfinite(point.expected) ? ordered_json(point.expected)
                                                                   : ordered_json(nullptr)}});
    }
    list.push_back({{"title", curve.title},
                    {"of", curve.of},
                    {"at_name", curve.at_name},
                    {"at_unit", curve.at_unit},
                    {"unit", curve.unit},
                    {"points", std::move(points)}});
  }
  json["curves"] = std::move(list);
}

std::string curves_text(const Problem& problem, const Model& model) {
  std::string text;
  for (const Curve& curve : curves_of(problem, model)) {
    const CurvePoint* farthest = nullptr;
    double most = 0;
    for (const CurvePoint& point : curve.points) {
      if (!can_be_drawn(point.value) || !can_be_drawn(point.expected)) continue;
      const double apart = std::abs(point.value - point.expected) / point.sigma;
      if (farthest != nullptr && apart <= most) continue;
      farthest = &point, most = apart;
    }
    if (farthest == nullptr) continue;
    text += fmt::format("  {}: {:.3g} {} {} {:.3g} {}, the model has {:.3g}: {:.3g} times\n",
                        curve.title, farthest->value, curve.unit, curve.at_name, farthest->at,
                        curve.at_unit, farthest->expected, farthest->value / farthest->expected);
  }
  return text.empty() ? text : "where curve and model are most standard errors apart:\n" + text;
}

void append_curves(const Problem& problem, const Model& before, const Model* after, json& plots) {
  const std::vector<Curve> given = curves_of(problem, before);
  const std::vector<Curve> found = after ? curves_of(problem, *after) : std::vector<Curve>{};
  for (size_t c = 0; c < given.size(); ++c) {
    const Curve& curve = given[c];
    json lines = json::array();
    lines.push_back(line_of("measured", curve, [](const CurvePoint& p) { return p.value; }));
    lines.push_back(
        line_of("less its error", curve, [](const CurvePoint& p) { return p.value - p.sigma; }));
    lines.push_back(
        line_of("and its error", curve, [](const CurvePoint& p) { return p.value + p.sigma; }));
    const auto expected = [](const CurvePoint& p) { return p.expected; };
    lines.push_back(line_of("model given", curve, expected));
    if (c < found.size()) lines.push_back(line_of("model found", found[c], expected));
    plots["series"].push_back({{"title", curve.title},
                               {"x", fmt::format("log10 {} ({})", curve.at_name, curve.at_unit)},
                               {"y", fmt::format("log10 deviation ({})", curve.unit)},
                               {"lines", std::move(lines)}});
  }
}

}  // namespace seam::measurement
