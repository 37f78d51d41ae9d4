#include "app/predictors/outcome_runs.h"

#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <limits>
#include <nlohmann/json.hpp>

#include "app/data_file.h"
#include "app/predictors/run_helper.h"
#include "app/sweep/plan/plan.h"
#include "app/sweep/results.h"
#include "app/sweep/sweep.h"
#include "app/trust/program_consent.h"
#include "measurement/imaging/run_maker.h"
#include "sim_core/base/error.h"
#include "sim_core/base/hash.h"
#include "sim_core/base/output.h"
#include "sim_core/input/file_names.h"
#include "sim_core/system/own_files.h"

namespace seam::app {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;
using measurement::RunSpec;
using measurement::RunTable;

// Far from one another for all seeds of plans that anybody writes.
constexpr int64_t kSeedsApart = 1'000'003;

// Files that a document names by any text with a slash, but for programs, which are asked about.
void refuse_names_outside(const YAML::Node& node, const fs::path& folder, const fs::path& file) {
  if (node.IsScalar() && node.Scalar().find('/') != std::string::npos) {
    const std::string why = why_not_inside(folder, node.Scalar());
    if (!why.empty() && !is_our_data(folder / node.Scalar()))
      throw InputError(fmt::format("{}:{}: {}", file.string(), node.Mark().line + 1, why));
  }
  for (const auto& item : node) {
    if (!node.IsMap()) {
      refuse_names_outside(item, folder, file);
    } else if (!item.first.Scalar().ends_with("command") && item.first.Scalar() != "description") {
      refuse_names_outside(item.second, folder, file);
    }
  }
}

SweepPlan plan_of_set(const fs::path& file) {
  // Parsed with the limits of everything that is read.
  const ConfigNode plan = ConfigNode::from_file(file);
  const fs::path folder = file.parent_path();
  refuse_names_outside(plan.yaml(), folder, file);
  const ConfigNode scenario = plan.at("scenario");
  const fs::path named = folder / scenario.text();
  if (const std::string why = why_not_inside(folder, scenario.text());
      !why.empty() && !is_our_data(named))
    scenario.fail(why);
  if (fs::exists(named) && !is_our_data(named))
    refuse_names_outside(ConfigNode::from_file(named).yaml(), named.parent_path(), named);
  return SweepPlan::from_file(file);
}

// Programs that do not belong to SEAM.
std::vector<std::string> foreign_programs(const SweepPlan& plan) {
  std::vector<std::string> programs;
  for (const auto& [command, robot] : plan.commands()) {
    const bool ours = command.front().find('/') == std::string::npos &&
                      fs::exists(behaviours_folder() / command.front());
    if (!ours) programs.push_back(fmt::format("{}: {}", robot, fmt::join(command, " ")));
  }
  return programs;
}

// What a model changes: its effects of the scenario by their keys, the rest as the robots' own.
Json changes_by(const RunSpec& spec, effects::Model model) {
  Json changes = Json::object();
  std::vector<std::string> of_scenario;
  for (const effects::ModelEffect& effect : model.effects()) {
    if (!effect.definition->scenario) continue;
    of_scenario.push_back(effect.definition->name);
    for (const auto& [path, value] : effect.definition->scenario(effect.values()))
      changes[path] = fmt::format("{}", value);
  }
  for (const std::string& name : of_scenario) model.remove(name);
  std::vector<std::string> robots = spec.robots;
  if (robots.empty()) robots = {"*"};
  for (const std::string& robot : robots)
    changes[fmt::format("robots[{}].camera.model", robot)] = model.to_yaml();
  return changes;
}

// The plan with these changes, and other seeds.
SweepPlan changed_plan(const SweepPlan& plan, const Json& changes, uint64_t draw) {
  YAML::Node root = YAML::Load(plan.texts().plan);
  for (const auto& [path, value] : changes.items())
    root["set"][path] = YAML::Load(value.get<std::string>());
  if (draw > 0) {
    const auto away = static_cast<int64_t>(draw) * kSeedsApart;
    for (size_t i = 0; i < root["seeds"].size(); ++i)
      root["seeds"][i] = root["seeds"][i].as<int64_t>() + away;
  }
  YAML::Emitter out;
  out.SetDoublePrecision(17);
  out << root;
  PlanTexts texts = plan.texts();
  texts.plan = out.c_str();
  return SweepPlan::from_texts(texts);
}

void add_record(const RunRecord& record, size_t columns, Json& runs, std::string& first_error) {
  if (record.failed() && first_error.empty()) first_error = record.error;
  Json& values = runs[record.run];
  values = Json::array();
  for (size_t i = 0; i < columns; ++i) {
    const bool there = !record.failed() && i < record.kept.size() && record.kept[i].has_value();
    values.push_back(there ? Json(*record.kept[i]) : Json());
  }
}

// In the helper process: makes the runs of a request. Throws where it was interrupted.
std::string make_table(const std::vector<SweepPlan>& plans, const fs::path& kept,
                       ProgramPrints& prints, const std::string& request) {
  const Json asked = Json::parse(request);
  const SweepPlan plan =
      changed_plan(plans.at(asked.at("plan")), asked.at("changes"), asked.at("draw"));
  const Makers makers = makers_of(plan, prints);
  const size_t columns = plan.keep().columns().size();
  Json runs = Json::array();
  for (uint64_t i = 0; i < plan.runs(); ++i) runs.push_back(nullptr);
  std::string first_error;
  const auto take = [&](const RunRecord& record) {
    add_record(record, columns, runs, first_error);
  };
  SweepOutcome outcome;
  if (kept.empty()) {
    std::vector<uint64_t> all(plan.runs());
    for (uint64_t i = 0; i < all.size(); ++i) all[i] = i;
    outcome = make_runs(plan, all, makers, 0, {}, take, prints);
  } else {
    make_output_folder(kept);
    ResultsFile results = ResultsFile::for_writing(kept / (to_hex(plan.fingerprint()) + ".sqlite"),
                                                   plan, makers, Shard{});
    outcome = make_missing_runs(results, 0, prints);
    if (!outcome.interrupted) results.each(take);
    results.close();
  }
  if (outcome.interrupted) throw InputError("the runs were stopped");
  return Json{{"runs", runs}, {"error", first_error}}.dump(-1, ' ', false,
                                                           Json::error_handler_t::replace);
}

class OutcomeRuns final : public measurement::RunMaker {
 public:
  OutcomeRuns(const RunSpec& spec, const OutcomeRunsOptions& options) : spec_(spec) {
    std::vector<std::string> programs;
    for (const measurement::RunPlan& named : spec.plans) {
      plans_.push_back(plan_of_set(named.file));
      const SweepPlan& plan = plans_.back();
      if (plan.keep().columns().empty())
        throw InputError(fmt::format("{}: keeps no values, expected `keep:` (docs/sweeps.md)",
                                     named.file.string()));
      const auto foreign = foreign_programs(plan);
      programs.insert(programs.end(), foreign.begin(), foreign.end());
    }
    require_consent(programs, options.run_programs);
    helper_.emplace(
        [this, kept = options.kept, prints = ProgramPrints()](const std::string& request) mutable {
          return make_table(plans_, kept, prints, request);
        });
  }

  std::vector<std::string> columns(size_t plan) const override {
    return plans_.at(plan).keep().columns();
  }
  uint64_t runs(size_t plan) const override { return plans_.at(plan).runs(); }

  uint64_t alike(size_t plan) const override {
    const SweepPlan& made = plans_.at(plan);
    return std::max<uint64_t>(1, made.seeds()) * made.repetitions();
  }

  std::map<std::string, std::string> files(size_t plan) const override {
    const PlanTexts& texts = plans_.at(plan).texts();
    std::map<std::string, std::string> files = texts.files;
    YAML::Node root = YAML::Load(texts.plan);
    const std::string scenario = "scenario_of_" + texts.name;
    root["scenario"] = scenario;
    YAML::Emitter out;
    out << root;
    files[texts.name] = out.c_str();
    files[scenario] = texts.scenario;
    return files;
  }

  RunTable make(size_t plan, const effects::Model& model, uint64_t draw) override {
    if (draw > 0 && plans_.at(plan).seeds() == 0) {
      throw InputError(
          fmt::format("{}: has no `seeds: [first, last]`, which measured runs need to have others",
                      plans_[plan].texts().name));
    }
    const std::string answer = helper_->ask(
        Json{{"plan", plan}, {"changes", changes_by(spec_, model)}, {"draw", draw}}.dump());
    const Json table = Json::parse(answer);
    RunTable out{.first_error = table.at("error")};
    for (const Json& run : table.at("runs")) {
      std::vector<double>& values = out.runs.emplace_back();
      for (const Json& value : run)
        values.push_back(value.is_null() ? std::numeric_limits<double>::quiet_NaN()
                                         : value.get<double>());
    }
    return out;
  }

 private:
  RunSpec spec_;
  std::vector<SweepPlan> plans_;
  std::optional<RunHelper> helper_;
};

}  // namespace

measurement::OpenRuns outcome_runs(const OutcomeRunsOptions& options) {
  return [options](const RunSpec& spec) -> std::unique_ptr<measurement::RunMaker> {
    return std::make_unique<OutcomeRuns>(spec, options);
  };
}

}  // namespace seam::app
