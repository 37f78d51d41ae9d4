#include "measurement/suggest/along.h"

#include <algorithm>
#include <cmath>

#include "measurement/judge/decisions.h"

namespace seam::measurement {
namespace {

size_t index_in(const std::vector<std::string>& names, const std::string& name) {
  return static_cast<size_t>(std::find(names.begin(), names.end(), name) - names.begin());
}

// The one that the vocabulary is about; null where there is none, or one of each of several joints.
const FieldPlace* place_of(const Vocabulary& vocabulary, const std::vector<FieldPlace>& places) {
  const FieldPlace* found = nullptr;
  for (const FieldPlace& place : places) {
    const bool is_it = static_cast<bool>(place.arrives) == vocabulary.place.arrives &&
                       place.slopes.size() == vocabulary.place.outputs.size() &&
                       place.covariates.size() == vocabulary.place.variables.size();
    if (!is_it) continue;
    if (found != nullptr) return nullptr;
    found = &place;
  }
  return found;
}

}  // namespace

std::vector<double> values_of(const Vocabulary& vocabulary, const Facts& facts,
                              const std::string& variable) {
  const auto other = vocabulary.covariates.find(variable);
  const std::string& name = other == vocabulary.covariates.end() ? variable : other->second;
  for (const Covariate& covariate : facts.covariates) {
    if (covariate.name == name) return covariate.values;
  }
  return {};
}

std::optional<Along> along_channel(const Vocabulary& vocabulary, const Problem& problem,
                                   const Evaluation& here, const Term& carrier,
                                   const std::string& variable) {
  const auto channel = vocabulary.channels.find(carrier.pieces[0].output);
  if (carrier.pieces.size() > 1 || carrier.pieces[0].text != "@" ||
      channel == vocabulary.channels.end())
    return std::nullopt;
  const Facts& facts = problem.facts();
  const std::vector<double> values = values_of(vocabulary, facts, variable);
  if (values.empty()) return std::nullopt;
  Along along;
  for (size_t i = 0; i < facts.scalars(); ++i) {
    if (!here.used[i] || facts.channels[facts.channel_of[i]].name != channel->second ||
        !std::isfinite(values[facts.row_of[i]]))
      continue;
    along.scalars.push_back(i);
    along.at.push_back(values[facts.row_of[i]]);
    along.weight.push_back(-1 / here.sigma[i]);
  }
  return along.at.size() < kLeastForWaves ? std::nullopt : std::optional(std::move(along));
}

std::optional<Along> along_place(const Vocabulary& vocabulary,
                                 const std::vector<FieldPlace>& places, const Facts& facts,
                                 const Evaluation& here, const Term& carrier,
                                 const std::string& variable) {
  const FieldPlace* place = place_of(vocabulary, places);
  if (place == nullptr || carrier.pieces.size() > 1) return std::nullopt;
  const auto& [arrives, variables, outputs] = vocabulary.place;
  const size_t output = index_in(outputs, carrier.pieces[0].output);
  const size_t of_variable = index_in(variables, variable);
  if (output == outputs.size() || of_variable == variables.size()) return std::nullopt;
  const std::string& text = carrier.pieces[0].text;
  const bool by_sign = text == "sign(rate) * @";
  const size_t rate = index_in(variables, "rate");
  if (by_sign ? rate == variables.size() : text != "@") return std::nullopt;
  Along along;
  for (size_t i = 0; i < facts.scalars(); ++i) {
    const double slope = place->slopes[output][i];
    const auto row = static_cast<size_t>(facts.row_of[i]);
    const double at = place->covariates[of_variable].values[row];
    if (slope == 0 || !std::isfinite(at)) continue;
    along.scalars.push_back(i);
    along.at.push_back(at);
    along.weight.push_back(by_sign ? std::copysign(slope, place->covariates[rate].values[row])
                                   : slope);
  }
  if (along.at.size() < kLeastForWaves) return std::nullopt;
  along.arrives = [place_arrives = place->arrives, scalars = along.scalars,
                   used = here.used](std::vector<double>& changes) {
    std::vector<double> column(used.size(), 0);
    for (size_t k = 0; k < scalars.size(); ++k) column[scalars[k]] = changes[k];
    if (place_arrives) place_arrives(column);
    for (size_t k = 0; k < scalars.size(); ++k)
      changes[k] = used[scalars[k]] ? column[scalars[k]] : 0;
  };
  return along;
}

Along along_changes(const Evaluation& here, const std::vector<double>& alone,
                    const std::vector<double>& by_variable) {
  Along along;
  if (alone.empty() || by_variable.empty()) return along;
  double largest = 0;
  for (const double value : alone) largest = std::max(largest, std::abs(value));
  for (size_t i = 0; i < alone.size(); ++i) {
    if (!here.used[i] || std::abs(alone[i]) < kLeastActing * largest) continue;
    along.scalars.push_back(i);
    along.at.push_back(by_variable[i] / alone[i]), along.weight.push_back(alone[i]);
  }
  return along;
}

}  // namespace seam::measurement
