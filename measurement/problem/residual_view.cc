#include "measurement/problem/residual_view.h"

#include <cmath>

namespace seam::measurement {
namespace {

// Scalars by row for one channel; -1 where it takes no part.
std::vector<int> scalars_by_row(const Facts& facts, const Evaluation& evaluation, int channel) {
  std::vector<int> scalar(facts.rows(), -1);
  for (size_t i = 0; i < facts.scalars(); ++i) {
    if (evaluation.used[i] && facts.channel_of[i] == channel)
      scalar[facts.row_of[i]] = static_cast<int>(i);
  }
  return scalar;
}

}  // namespace

const ResidualView::Channel* ResidualView::channel(const std::string& name) const {
  for (const Channel& channel : channels) {
    if (channel.name == name) return &channel;
  }
  return nullptr;
}

std::vector<double> ResidualView::covariate(const std::string& name) const {
  for (const auto& [known, values] : covariates) {
    if (known == name) return values;
  }
  const size_t star = name.find('*');
  if (star == std::string::npos) return {};
  std::vector<double> a = covariate(name.substr(0, star));
  const std::vector<double> b = covariate(name.substr(star + 1));
  if (a.empty() || b.empty()) return {};
  for (size_t i = 0; i < a.size(); ++i) a[i] *= b[i];
  return a;
}

ResidualView Problem::residual_view(const Model& model, const Groups& groups) const {
  return view_of(facts_, evaluate(model, groups));
}

ResidualView view_of(const Facts& facts, const Evaluation& evaluation) {
  ResidualView view;
  for (const Covariate& covariate : facts.covariates)
    view.covariates.emplace_back(covariate.name, covariate.values);
  std::vector<std::vector<int>> scalars;
  for (size_t c = 0; c < facts.channels.size(); ++c) {
    scalars.push_back(scalars_by_row(facts, evaluation, static_cast<int>(c)));
    ResidualView::Channel channel{.name = facts.channels[c].name};
    for (size_t row = 0; row < facts.rows(); ++row) {
      const int i = scalars[c][row];
      if (i < 0) continue;
      channel.residual.push_back(evaluation.residual[i]);
      channel.sigma.push_back(evaluation.sigma[i]);
      channel.row.push_back(static_cast<int>(row));
    }
    view.channels.push_back(std::move(channel));
  }
  for (const CombinedChannel& combined : facts.combined) {
    ResidualView::Channel channel{.name = combined.name};
    for (size_t row = 0; row < facts.rows(); ++row) {
      const int a = scalars[combined.channel_a][row], b = scalars[combined.channel_b][row];
      if (a < 0 || b < 0) continue;
      const double wa = combined.weight_a[row], wb = combined.weight_b[row];
      channel.residual.push_back(wa * evaluation.residual[a] + wb * evaluation.residual[b]);
      channel.sigma.push_back(std::hypot(wa * evaluation.sigma[a], wb * evaluation.sigma[b]));
      channel.row.push_back(static_cast<int>(row));
    }
    view.channels.push_back(std::move(channel));
  }
  return view;
}

}  // namespace seam::measurement
