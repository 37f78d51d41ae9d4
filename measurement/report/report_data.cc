#include "measurement/report/report_data.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>

#include "effects/registry.h"
#include "measurement/report/curves/curves_told.h"
#include "measurement/report/data_pictures.h"
#include "measurement/report/finite_or_null.h"
#include "measurement/report/lens_map.h"
#include "measurement/report/report_plots.h"
#include "measurement/report/target_told.h"
#include "sim_core/base/error.h"

namespace seam::measurement {

nlohmann::json effects_json(const effects::Model& model) {
  using nlohmann::json;
  json effects = json::object();
  for (const effects::ModelEffect& effect : model.effects()) {
    json& parameters = effects[effect.definition->name] = json::object();
    for (size_t i = 0; i < effect.parameters.size(); ++i) {
      const effects::ParameterValue& value = effect.parameters[i];
      parameters[effect.definition->parameters[i].name] = {
          {"value", finite_or_null<json>(value.value)},
          {"sigma", value.sigma ? finite_or_null<json>(*value.sigma) : json(nullptr)},
          {"free", value.free}};
    }
  }
  return effects;
}
namespace {

using nlohmann::json;

// The models that a page lays beside each other, each with the structure of its own residuals.
struct Stages {
  const Assessment* before = nullptr;
  std::vector<Structure> before_structure;
  const Assessment* after = nullptr;  // May be missing.
  std::vector<Structure> after_structure;
  std::vector<std::string> added;  // Effects of `after` that `before` lacks.
};

json model_json(const Model& model, const std::string& file) {
  return {{"name", model.name()}, {"file", file}, {"effects", effects_json(model)}};
}

json data_json(const Problem& problem, const Assessment& before, const std::string& folder) {
  const Facts& facts = problem.facts();
  const Groups shown = problem.scored_groups();
  json noise = json::object();
  bool estimated = false;
  for (const Channel& channel : facts.channels) {
    noise[channel.name] = finite_or_null<json>(channel.noise);
    estimated = estimated || channel.estimated;
  }
  json data = {{"folder", folder},
               {"title", facts.title},
               {"kind", facts.kind()},
               {"fingerprint", facts.fingerprint},
               {"n", observations_used(problem)},
               {"residuals", std::max(before.held.n, static_cast<int64_t>(count_used(problem)))},
               {"groups", facts.groups.size()},
               {"held_out_n", before.held.n},
               {"held_out_groups", std::count(shown.begin(), shown.end(), 1)},
               {"noise", std::move(noise)},
               {"noise_from", estimated ? "estimated" : "file"}};
  if (facts.width_px > 0)
    data["image"] = {{"width_px", facts.width_px}, {"height_px", facts.height_px}};
  return data;
}

// One cause shows in many places: of each residual two plots against a covariate and two against a
// product tell more than many of one; residuals made of two others come last.
std::vector<Structure> chosen_for_plots(const Facts& facts,
                                        const std::vector<Structure>& structures) {
  constexpr size_t kMost = 8;
  std::vector<Structure> chosen;
  std::set<std::string> seen;
  std::map<std::string, int> alike;
  for (const bool combined : {false, true}) {
    for (const Structure& structure : structures) {
      const bool native =
          std::any_of(facts.channels.begin(), facts.channels.end(),
                      [&](const Channel& channel) { return channel.name == structure.residual; });
      // Labels have no order to be plotted along.
      if (native == combined || structure.covariate == "frame" || structure.covariate == "point")
        continue;
      const bool product = structure.covariate.find('*') != std::string::npos;
      int& same = alike[structure.residual + structure.moment + (product ? "*" : "")];
      // What moves the mean widens the spread too: one plot of it is enough.
      const bool spread = structure.moment == "spread";
      if (chosen.size() == kMost || same == (combined || spread ? 1 : 2)) continue;
      if (!seen.insert(structure.residual + " " + structure.covariate + " " + structure.moment)
               .second)
        continue;
      chosen.push_back(structure);
      ++same;
    }
  }
  return chosen;
}

bool same_look(const Structure& a, const Structure& b) {
  return a.residual == b.residual && a.covariate == b.covariate && a.moment == b.moment;
}

// The model given beside the one found, where the search found a step.
Stages stages_of(const SearchResult& result) {
  Stages stages{.before = &result.base.assessment, .before_structure = result.base_structure};
  if (result.steps.empty()) return stages;
  stages.after = &result.best.assessment;
  stages.added = result.best.added;
  stages.after_structure = result.remaining;
  return stages;
}

// What to plot of both models: what the last one leaves, then what the first one lacks.
std::vector<Structure> looks_of(const Facts& facts, const Stages& stages) {
  constexpr size_t kMost = 8;
  std::vector<Structure> looks = chosen_for_plots(facts, stages.after_structure);
  looks.resize(std::min(looks.size(), kMost / 2));
  for (const Structure& other : chosen_for_plots(facts, stages.before_structure)) {
    const bool is_there = std::any_of(
        looks.begin(), looks.end(), [&](const Structure& look) { return same_look(look, other); });
    if (!is_there && looks.size() < kMost) looks.push_back(other);
  }
  return looks;
}

// `found` is the structure of this stage's own residuals.
void append_stage(const Problem& problem, const ResidualView& view, const std::string& stage,
                  const std::vector<Structure>& looks, const std::vector<Structure>& found,
                  json& plots) {
  for (const Structure& look : looks) {
    const auto own = std::find_if(found.begin(), found.end(),
                                  [&](const Structure& s) { return same_look(s, look); });
    const bool tested = own != found.end();
    json plot = residual_plot(view, tested ? *own : look, tested, stage);
    if (!plot.is_null()) plots["residuals"].push_back(std::move(plot));
  }
  if (json arrows = arrow_plot(view, stage); !arrows.is_null())
    plots["arrows"].push_back(std::move(arrows));
  if (json map = image_map(view, stage); !map.is_null()) plots["maps"].push_back(std::move(map));
  if (!plots.contains("histograms")) plots["histograms"] = json::array();
  append_histograms(view, problem.facts().channels.size(), stage, plots["histograms"]);
}

// What held-out groups lose without each effect that was fitted or added, the rest refitted. The
// log-likelihood counts, which judges effects of the mean and of the spread alike: an error in
// noise units falls where a spread grows to cover what is missing.
json leave_one_out(const Problem& problem, const Assessment& whole,
                   const std::vector<std::string>& added) {
  constexpr size_t kMost = 8;
  json list = json::array();
  for (const effects::ModelEffect& effect : whole.model.effects()) {
    const std::string& name = effect.definition->name;
    const bool fitted = std::any_of(whole.unknowns.begin(), whole.unknowns.end(),
                                    [&](const Unknown& u) { return u.effect == name; });
    const bool new_here = std::find(added.begin(), added.end(), name) != added.end();
    if ((!fitted && !new_here) || list.size() == kMost) continue;
    Model without = whole.model;
    without.remove(name);
    std::vector<Unknown> unknowns = whole.unknowns;
    std::erase_if(unknowns, [&](const Unknown& u) { return u.effect == name; });
    try {
      problem.check_model(without);
    } catch (const InputError&) {
      continue;  // The model means nothing without it (a projection).
    }
    const Assessment rest = assess(problem, without, unknowns);
    if (!rest.valid) continue;
    list.push_back({{"effect", name},
                    {"log_likelihood_lost", finite_or_null<json>(whole.held_ll() - rest.held_ll())},
                    {"error_with", finite_or_null<json>(whole.error)},
                    {"error_without", finite_or_null<json>(rest.error)}});
  }
  return list;
}

std::string document(const Problem& problem, const ReportHeader& header, const Stages& stages,
                     const std::string& result) {
  json plots = json::object();
  const std::vector<Structure> looks = looks_of(problem.facts(), stages);
  const Groups groups = problem.scored_groups();
  const ResidualView before = problem.residual_view(stages.before->model, groups);
  append_stage(problem, before, "before", looks, stages.before_structure, plots);
  std::optional<ResidualView> after;
  if (stages.after) {
    after = problem.residual_view(stages.after->model, groups);
    append_stage(problem, *after, "after", looks, stages.after_structure, plots);
  }
  MeasurementSet set = MeasurementSet::open(header.data_folder);
  set.left_out = header.left_out;
  append_data_pictures(problem, set, before, after ? &*after : nullptr, plots);
  append_curves(problem, stages.before->model, stages.after ? &stages.after->model : nullptr,
                plots);
  const Assessment& shown = stages.after ? *stages.after : *stages.before;
  const Facts& facts = problem.facts();
  if (facts.width_px > 0 && !shown.unknowns.empty()) {
    const auto maps = error_maps(shown, facts.width_px, facts.height_px);
    // Values that move no place in the image leave a computation's last digits: no picture of them.
    const bool any = std::any_of(maps.begin(), maps.end(), [](const LensMap& map) {
      return map.largest_px() > kLeastShift_px;
    });
    if (any)
      plots["lens_error"] = maps_json(maps, stages.after ? "after" : "before", "Standard error");
  }
  if (json target = target_arrows(problem, shown.model); !target.empty())
    plots["target"] = std::move(target);
  if (json worth = leave_one_out(problem, shown, stages.added); !worth.empty())
    plots["leave_one_out"] = std::move(worth);
  const json report = {{"format", "seam-report/1"},
                       {"title", problem.facts().title},
                       {"command", header.command},
                       {"version", SEAM_VERSION},
                       {"model", model_json(stages.before->model, header.model_file)},
                       {"data", data_json(problem, *stages.before, header.data_folder)},
                       {"result", json::parse(result)},
                       {"plots", std::move(plots)}};
  return report.dump();
}

}  // namespace

std::string compare_report(const Problem& problem, const CompareResult& result,
                           const ReportHeader& header) {
  return document(problem, header,
                  {.before = &result.base.assessment, .before_structure = result.structure},
                  compare_json(problem, result, header.doubts));
}

std::string diagnose_report(const Problem& problem, const SearchResult& result,
                            const ReportHeader& header) {
  return document(problem, header, stages_of(result),
                  diagnose_json(problem, result, header.doubts));
}

std::string discover_report(const Problem& problem, const SearchResult& result,
                            const ReportHeader& header) {
  return document(problem, header, stages_of(result),
                  discover_json(problem, result, header.doubts));
}

std::string models_report(const std::vector<LensMap>& maps, const std::string& a,
                          const std::string& b, const ReportHeader& header) {
  return json{{"format", "seam-report/1"},
              {"title", fmt::format("{} and {}", a, b)},
              {"command", header.command},
              {"version", SEAM_VERSION},
              {"result", json::parse(models_json(maps, a, b))},
              {"plots", {{"lens_error", maps_json(maps, "after", "Difference")}}}}
      .dump();
}

std::string history_json(const Model& model) {
  json versions = json::array();
  for (const effects::HistoryStep& step : model.history()) {
    json parameters = json::object();
    for (const auto& [name, value] : step.parameters) {
      parameters[name] = {
          {"value", finite_or_null<json>(value.value)},
          {"sigma", value.sigma ? finite_or_null<json>(*value.sigma) : json(nullptr)}};
    }
    versions.push_back({{"version", versions.size() + 1},
                        {"effect", step.effect.empty() ? json(nullptr) : json(step.effect)},
                        {"parameters", std::move(parameters)},
                        {"data", step.data},
                        {"fingerprint", step.data_fingerprint},
                        {"error_before", finite_or_null<json>(step.error_before)},
                        {"error_after", finite_or_null<json>(step.error_after)}});
  }
  return json{{"format", "seam-history/1"},
              {"model", model.name()},
              {"versions", std::move(versions)}}
             .dump(2) +
         "\n";
}

std::string history_report(const Model& model, const ReportHeader& header) {
  return json{{"format", "seam-report/1"},
              {"title", fmt::format("How the model {} came about", model.name())},
              {"command", header.command},
              {"version", SEAM_VERSION},
              {"model", model_json(model, header.model_file)},
              {"result", json::parse(history_json(model))}}
      .dump();
}

}  // namespace seam::measurement
