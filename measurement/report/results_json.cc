#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "measurement/report/figures_told.h"
#include "measurement/report/finite_or_null.h"
#include "measurement/report/headline.h"
#include "measurement/report/results.h"
#include "measurement/report/target_told.h"
#include "measurement/report/trust/trust_json.h"
#include "measurement/report/unnamed/unnamed_told.h"
#include "measurement/search/kept.h"
#include "measurement/search/looked_for.h"
#include "measurement/search/order.h"
#include "sim_core/base/error.h"

namespace seam::measurement {
namespace {

using nlohmann::ordered_json;

void add_noise(ordered_json& json, const Problem& problem) {
  ordered_json noise = ordered_json::object();
  bool estimated = false;
  for (const Channel& channel : problem.facts().channels) {
    noise[channel.name] = finite_or_null<ordered_json>(channel.noise);
    estimated = estimated || channel.estimated;
  }
  json.update({{"noise", noise}, {"noise_estimated", estimated}});
}

// Rows that a person left out, by reason.
void add_left_out(ordered_json& json, const Problem& problem) {
  size_t rows = 0;
  ordered_json reasons = ordered_json::array();
  for (const LeftOutRows& left : problem.facts().left_out) {
    rows += left.rows;
    reasons.push_back({{"reason", left.reason}, {"rows", left.rows}});
  }
  if (rows > 0) json["left_out"] = {{"rows", rows}, {"reasons", std::move(reasons)}};
}

void add_notes(ordered_json& json, const Problem& problem, const Model& model) {
  std::vector<std::string> notes = problem.facts().notes;
  for (const std::string& missed : problem.remarks(model)) notes.push_back(missed);
  if (!notes.empty()) json["notes"] = notes;
  add_left_out(json, problem);
}

ordered_json native_json(const Problem& problem, const Score& score) {
  ordered_json native = ordered_json::object();
  for (size_t c = 0; c < score.native.size(); ++c)
    if (score.native_count[c] > 0)
      native[problem.facts().channels[c].name] = finite_or_null<ordered_json>(score.native[c]);
  return native;
}

ordered_json free_json(const Problem& problem, const Assessment& assessment) {
  ordered_json list = ordered_json::array();
  for (const FreeError& error : free_errors(problem, assessment))
    list.push_back({{"over", error.over},
                    {"residual", error.residual},
                    {"rms", finite_or_null<ordered_json>(error.rms)},
                    {"at_end", finite_or_null<ordered_json>(error.last)},
                    {"n", error.count}});
  return list;
}

void add_free(ordered_json& json, const Problem& problem, const Assessment& assessment) {
  if (ordered_json list = free_json(problem, assessment); !list.empty())
    json["free_prediction"] = std::move(list);
}

void add_findings(ordered_json& json, const Problem& problem, const Assessment& assessment) {
  ordered_json list = ordered_json::array();
  for (const Finding& finding : problem.findings(assessment.model)) {
    ordered_json entry = {{"what", finding.what}, {"name", finding.name}};
    for (const auto& [name, value] : finding.values)
      entry[name] = finite_or_null<ordered_json>(value);
    entry["text"] = finding.text;
    list.push_back(std::move(entry));
  }
  if (!list.empty()) json["findings"] = std::move(list);
}

ordered_json structure_json(const std::vector<Structure>& structure) {
  ordered_json list = ordered_json::array();
  for (const Structure& s : structure) {
    list.push_back({{"residual", s.residual},
                    {"moment", s.moment},
                    {"covariate", s.covariate},
                    {"strength", finite_or_null<ordered_json>(s.strength)},
                    {"p_value", s.p_value},
                    {"explained", finite_or_null<ordered_json>(s.explained)}});
  }
  return list;
}

ordered_json outliers_json(const Problem& problem, const std::vector<Outlier>& outliers) {
  ordered_json list = ordered_json::array();
  for (const Outlier& o : outliers) {
    list.push_back(
        {{"file", problem.facts().file},
         {"line", o.line},
         {"channel", problem.facts().channels[problem.facts().channel_of[o.scalar]].name},
         {"residual", finite_or_null<ordered_json>(o.residual)}});
  }
  return list;
}

ordered_json parameters_json(const Assessment& assessment, const std::string& effect) {
  ordered_json json = ordered_json::object();
  const effects::ModelEffect* entry = assessment.model.find(effect);
  if (!entry) return json;
  for (size_t i = 0; i < entry->parameters.size(); ++i) {
    double sigma = NAN;
    bool at_bound = false;
    if (const auto k = index_of(assessment.unknowns, {effect, i})) {
      sigma = assessment.fit.sigma[*k];
      at_bound = assessment.fit.at_bound[*k];
    }
    ordered_json value{{"value", finite_or_null<ordered_json>(entry->parameters[i].value)},
                       {"sigma", finite_or_null<ordered_json>(sigma)}};
    if (at_bound) value["at_bound"] = true;
    json[entry->definition->parameters[i].name] = value;
  }
  return json;
}

std::string why(const SearchResult& result, const Candidate& candidate) {
  std::string text = candidate.effect->signature;
  if (!result.base_structure.empty() && candidate.significant) {
    const Structure& strongest = result.base_structure.front();
    text += fmt::format("; without it the {} of {} varies with {} ({:.3g} rms)", strongest.moment,
                        strongest.residual, strongest.covariate, strongest.strength);
  }
  return text;
}

ordered_json not_testable_json(const std::vector<NotTestable>& list) {
  ordered_json json = ordered_json::array();
  for (const NotTestable& n : list)
    json.push_back({{"effect", n.effect}, {"parameter", n.parameter}, {"why", n.why}});
  return json;
}

ordered_json baseline_json(const Problem& problem, const Assessment& base) {
  ordered_json json = {{"error", finite_or_null<ordered_json>(base.error)},
                       {"native", native_json(problem, base.held)},
                       {"noise_floor", 1.0}};
  add_free(json, problem, base);
  return json;
}

ordered_json candidates_json(const SearchResult& result, const Assessment& before,
                             const std::vector<Candidate>& candidates) {
  ordered_json list = ordered_json::array();
  int rank = 0;
  for (const Candidate& c : candidates) {
    const Assessment& after = c.grown.assessment;
    ordered_json entry = {{"effect", c.effect->name},
                          {"rank", ++rank},
                          {"error", finite_or_null<ordered_json>(after.error)},
                          {"gain", finite_or_null<ordered_json>(gain_of(before, after.error))},
                          {"p_value", c.p_value},
                          {"significant", c.significant || c.trace},
                          {"log_likelihood_gain", finite_or_null<ordered_json>(c.gain_ll)},
                          {"parameters", parameters_json(after, c.effect->name)},
                          {"indistinguishable_from", c.indistinguishable_from}};
    for (const auto& companion : c.companions)
      entry["with"][companion->name] = parameters_json(after, companion->name);
    if (c.at_bound) entry["at_bound"] = true;
    if (c.found) entry["found"] = true;
    if (!c.stands_in_for.empty()) entry["stands_in_for"] = c.stands_in_for;
    entry["why"] = why(result, c);
    list.push_back(entry);
  }
  return list;
}

ordered_json of_first_look(const SearchResult& result) {
  std::vector<Candidate> candidates = result.first.candidates;
  std::erase_if(candidates, [](const Candidate& c) { return c.trace; });
  return candidates_json(result, result.base.assessment, candidates);
}

// What is significant but not material.
void add_traces(ordered_json& json, double material, const ordered_json& structure,
                const ordered_json& candidates) {
  json["material"] = material;
  json["traces"] = {{"structure", structure}, {"candidates", candidates}};
}

std::string without_newline(std::string line) {
  if (line.ends_with('\n')) line.pop_back();
  return line;
}

std::string dumped(const ordered_json& json) {
  return json.dump(1) + "\n";
}

}  // namespace

double gain_of(const Assessment& before, double after) {
  const double excess = before.error * before.error - 1;
  const auto n = static_cast<double>(std::max<int64_t>(1, before.held.n));
  if (excess < 3 * std::sqrt(2 / n)) return std::numeric_limits<double>::quiet_NaN();
  return 1 - (after * after - 1) / excess;
}

int64_t observations_used(const Problem& problem) {
  const Facts& facts = problem.facts();
  if (facts.channels.size() < 2) return static_cast<int64_t>(count_used(problem));
  std::vector<char> used(facts.rows(), 0);
  for (size_t i = 0; i < facts.scalars(); ++i) {
    if (!problem.left_out(i)) used[facts.row_of[i]] = 1;
  }
  return std::count(used.begin(), used.end(), 1);
}

std::string compare_json(const Problem& problem, const CompareResult& result,
                         const Doubts& doubts) {
  ordered_json json = {
      {"format", "seam-compare/1"},
      {"headline", without_newline(with_questions(headline(problem, result), doubts))},
      {"doubts", doubts},
      {"kind", problem.facts().kind()},
      {"n", count_used(problem)},
      {"observations", observations_used(problem)},
      {"groups", problem.facts().groups.size()}};
  json.update(baseline_json(problem, result.base.assessment));
  add_noise(json, problem);
  json["structure"] = structure_json(result.structure);
  add_traces(json, result.material, structure_json(result.traces), ordered_json::array());
  json["outliers"] = outliers_json(problem, result.outliers);
  json["outlier_share"] = result.outlier_share;
  add_findings(json, problem, result.base.assessment);
  add_notes(json, problem, result.base.assessment.model);
  add_figures(json, problem, result.base.assessment);
  return dumped(json);
}

// What was looked for beside the effects, with what came of it.
void add_looked_for(ordered_json& json, const Problem& problem, const SearchResult& result) {
  ordered_json& list = json["looked_for"] = ordered_json::array();
  for (const LookedFor& entry : looked_for(problem, result)) {
    ordered_json one = {{"what", entry.what}, {"of", entry.covariates}, {"outcome", entry.outcome}};
    if (!entry.why.empty()) one["why"] = entry.why;
    list.push_back(std::move(one));
  }
}

std::string looks_json(const SearchResult& result) {
  return dumped({{"candidates", of_first_look(result)},
                 {"not_testable", not_testable_json(result.first.not_testable)}});
}

std::string diagnose_json(const Problem& problem, const SearchResult& result,
                          const Doubts& doubts) {
  const Assessment& base = result.base.assessment;
  ordered_json json = {
      {"format", "seam-diagnose/1"},
      {"headline", without_newline(with_questions(diagnose_headline(problem, result), doubts))},
      {"doubts", doubts},
      {"kind", problem.facts().kind()},
      {"n", problem.facts().rows()},
      {"residuals", count_used(problem)},
      {"groups", problem.facts().groups.size()},
      {"verdict", result.verdict}};
  json["baseline"] = baseline_json(problem, base);
  add_noise(json, problem);
  json["candidates"] = of_first_look(result);
  add_unnamed(json, result);
  add_looked_for(json, problem, result);
  add_trust(json, trust_in(problem, result));
  const bool unexplained = result.verdict == "unexplained_structure";
  json["structure"] = structure_json(unexplained ? result.remaining : result.base_structure);
  json["structure_of"] = unexplained ? "explanation" : "given";
  add_traces(json, result.material, structure_json(traces_told(result)),
             candidates_json(result, base, traces_of(result.first.candidates)));
  ordered_json explanation = ordered_json::array();
  for (const Step& step : result.steps)
    explanation.push_back(
        {{"effect", step.effect}, {"error_after", finite_or_null<ordered_json>(step.error_after)}});
  json["explanation"] = {{"steps", explanation},
                         {"error", finite_or_null<ordered_json>(result.best.assessment.error)}};
  add_free(json["explanation"], problem, result.best.assessment);
  add_findings(json["explanation"], problem, result.best.assessment);
  json["not_testable"] = not_testable_json(result.first.not_testable);
  json["outliers"] = outliers_json(problem, result.outliers);
  json["outlier_share"] = result.outlier_share;
  add_notes(json, problem, result.best.assessment.model);
  add_figures(json, problem, base);
  json["advice"] = advice_for(problem, result);
  return dumped(json);
}

// Traces that stay in the model, and the value that each moves most.
ordered_json kept_json(const SearchResult& result) {
  ordered_json list = ordered_json::array();
  for (const KeptTrace& kept : result.kept) {
    list.push_back({{"effect", kept.effect},
                    {"parameters", parameters_json(result.best.assessment, kept.effect)},
                    {"moves", moved_value(result, kept)},
                    {"by_errors", kept.errors}});
  }
  return list;
}

std::string discover_json(const Problem& problem, const SearchResult& result,
                          const Doubts& doubts) {
  ordered_json json = {
      {"format", "seam-discover/1"},
      {"headline", without_newline(with_questions(discover_headline(problem, result), doubts))},
      {"doubts", doubts},
      {"kind", problem.facts().kind()},
      {"verdict",
       result.verdict == "unexplained_structure" ? "unexplained_structure" : "adequate"}};
  ordered_json steps = ordered_json::array();
  for (const Step& step : result.steps) {
    steps.push_back({{"effect", step.effect},
                     {"parameters", parameters_json(result.best.assessment, step.effect)},
                     {"parameters_when_added", parameters_json(step.after, step.effect)},
                     {"error_before", finite_or_null<ordered_json>(step.error_before)},
                     {"error_after", finite_or_null<ordered_json>(step.error_after)},
                     {"indistinguishable_from", step.indistinguishable_from},
                     {"doubts", step.doubts}});
  }
  json["steps"] = steps;
  json["kept"] = kept_json(result);
  add_unnamed(json, result);
  add_looked_for(json, problem, result);
  add_trust(json, trust_in(problem, result));
  json["error"] = finite_or_null<ordered_json>(result.best.assessment.error);
  json["baseline"] = baseline_json(problem, result.base.assessment);
  json["native"] = native_json(problem, result.best.assessment.held);
  add_free(json, problem, result.best.assessment);
  add_findings(json, problem, result.best.assessment);
  add_noise(json, problem);
  json["structure"] = structure_json(result.remaining);
  add_traces(json, result.material, structure_json(result.remaining_traces),
             candidates_json(result, result.best.assessment, result.last_traces));
  json["not_testable"] = not_testable_json(result.first.not_testable);
  json["outliers"] = outliers_json(problem, result.outliers);
  json["outlier_share"] = result.outlier_share;
  add_notes(json, problem, result.best.assessment.model);
  add_target(json, problem, result.best.assessment.model);
  add_figures(json, problem, result.best.assessment);
  json["advice"] = advice_for(problem, result);
  return dumped(json);
}

std::string add_json(const Problem& problem, const AddResult& result, const std::string& format,
                     const Doubts& doubts) {
  ordered_json parameters = ordered_json::object();
  for (const auto& [name, value] : result.parameters) {
    parameters[name] = {{"value", finite_or_null<ordered_json>(value.value)},
                        {"sigma", value.sigma ? finite_or_null<ordered_json>(*value.sigma)
                                              : ordered_json(nullptr)}};
  }
  ordered_json json = {{"format", format},
                       {"doubts", doubts},
                       {"effect", result.effect},
                       {"replaced", result.replaced},
                       {"parameters", parameters},
                       {"error_before", finite_or_null<ordered_json>(result.error_before)},
                       {"error_after", finite_or_null<ordered_json>(result.error_after)},
                       {"not_testable", not_testable_json(result.not_testable)}};
  add_noise(json, problem);
  add_notes(json, problem, result.model);
  add_target(json, problem, result.model);
  add_figures(json, problem, result.assessment);
  return dumped(json);
}

}  // namespace seam::measurement
