// A measurement set made of a formula, for tests of fits: y = f(x) + noise, x known without error,
// so that each answer can be computed in another way.
#pragma once

#include <cmath>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "effects/model.h"
#include "measurement/problem/problem.h"
#include "sim_core/base/random.h"

namespace seam::measurement {

class MadeProblem : public Problem {
 public:
  // The values of all effects' parameters, in the model's order.
  using Formula = std::function<double(const std::vector<double>& parameters, double x)>;

  // Parameters of `spread` effects add their squares to the variance instead.
  MadeProblem(std::vector<double> x, double noise, Formula formula)
      : x_(std::move(x)), y_(x_.size()), formula_(std::move(formula)) {
    facts_.channels = {{.name = "y", .noise = noise}};
    facts_.groups = {"all"};
    for (size_t i = 0; i < x_.size(); ++i) {
      facts_.line_of_row.push_back(static_cast<int>(i));
      facts_.group_of_row.push_back(0);
      facts_.time_of_row.push_back(static_cast<double>(i));
      facts_.row_of.push_back(static_cast<int>(i));
      facts_.channel_of.push_back(0);
    }
  }

  // Observes this truth with the noise of this stream.
  void observe(const Model& truth, RandomStream stream) {
    const auto [mean, variance] = predict(truth);
    for (size_t i = 0; i < x_.size(); ++i)
      y_[i] = mean[i] + std::sqrt(variance) * normal(stream, i);
  }
  void take(std::vector<double> y) { y_ = std::move(y); }
  // Deals the rows out to as many groups, in turn, so that each sees the whole range.
  void deal_into(size_t groups) {
    group_rows(groups, [&](size_t row) { return row % groups; });
  }
  // Cuts them into as many groups of one stretch each.
  void cut_into(size_t groups) {
    group_rows(groups, [&](size_t row) { return row * groups / x_.size(); });
  }
  const std::vector<double>& x() const { return x_; }
  const std::vector<double>& y() const { return y_; }

  Evaluation evaluate(const Model& model, const Groups& groups,
                      const Evaluation* = nullptr) const override {
    const auto [mean, variance] = predict(model);
    Evaluation out;
    out.sigma.assign(x_.size(), std::sqrt(variance));
    for (size_t i = 0; i < x_.size(); ++i) {
      out.residual.push_back(y_[i] - mean[i]);
      out.valid = out.valid && std::isfinite(mean[i]);
    }
    whiten_diagonal(*this, groups, out);
    return out;
  }
  void check_model(const Model&) const override {}

 private:
  void group_rows(size_t groups, const std::function<size_t(size_t row)>& group_of) {
    facts_.groups.clear();
    for (size_t g = 0; g < groups; ++g) facts_.groups.push_back("g" + std::to_string(g));
    for (size_t row = 0; row < x_.size(); ++row)
      facts_.group_of_row[row] = static_cast<int>(group_of(row));
  }
  std::pair<std::vector<double>, double> predict(const Model& model) const {
    std::vector<double> parameters;
    double variance = facts_.channels[0].noise * facts_.channels[0].noise;
    for (const auto& effect : model.effects()) {
      for (const double value : effect.values()) {
        if (effect.definition->spread_only)
          variance += value * value;
        else
          parameters.push_back(value);
      }
    }
    std::vector<double> mean;
    for (const double x : x_) mean.push_back(formula_(parameters, x));
    return {std::move(mean), variance};
  }

  std::vector<double> x_, y_;
  Formula formula_;
};

// An effect of these parameters, without hooks.
inline std::shared_ptr<const EffectDefinition> made_effect(
    const std::string& name, std::vector<effects::Parameter> parameters, bool spread_only = false) {
  auto effect = std::make_shared<EffectDefinition>();
  effect->name = name;
  effect->parameters = std::move(parameters);
  effect->spread_only = spread_only;
  return effect;
}

// A model of one effect at these values.
inline Model made_model(const std::shared_ptr<const EffectDefinition>& effect,
                        const std::vector<double>& values) {
  Model model;
  std::vector<effects::ParameterValue> all;
  for (const double value : values) all.push_back({.value = value});
  model.set(effect, all);
  return model;
}

inline std::vector<double> evenly(double first, double last, size_t count) {
  std::vector<double> x;
  for (size_t i = 0; i < count; ++i)
    x.push_back(first + (last - first) * static_cast<double>(i) / static_cast<double>(count - 1));
  return x;
}

}  // namespace seam::measurement
