// `seam plan`: what a measurement that was not made yet would say.
#include <algorithm>
#include <cmath>
#include <filesystem>

#include "app/predictors/instruments.h"
#include "app/scratch_folder.h"
#include "effects/registry.h"
#include "measurement/kinds/kinds.h"
#include "measurement/plan/plan_results.h"
#include "measurement/report/report.h"
#include "sim_core/base/error.h"
#include "tools/command.h"
#include "tools/commands/analysis.h"

namespace seam::tools {
namespace {

struct PlanFlags {
  AnalysisFlags files;  // Its data is the protocol.
  std::vector<std::string> effects, improve;
  uint64_t seed = 1;
};

// Names of effects, between commas or spaces.
std::vector<std::string> effects_in(const std::vector<std::string>& words, const char* option) {
  std::vector<std::string> names;
  for (const std::string& word : words) {
    for (size_t at = 0; at <= word.size();) {
      const size_t end = std::min(word.find(',', at), word.size());
      const std::string name = word.substr(at, end - at);
      at = end + 1;
      if (name.empty()) continue;
      if (!effects::find_effect(name))
        throw UsageError(fmt::format("{}: unknown effect '{}'{}", option, name,
                                     suggestion_for(name, effects::effect_names())));
      names.push_back(name);
    }
  }
  if (names.empty() && !words.empty())
    throw UsageError(fmt::format("{}: found no names, expected a,b,...", option));
  return names;
}

// The sets that the model gives by a protocol and by changes of it.
class PlannedSets {
 public:
  PlannedSets(const PlanFlags& flags, const effects::Model& model)
      : model_(model),
        protocol_(measurement::MeasurementSet::open(flags.files.data)),
        instruments_(app::instruments(flags.files.runs)),
        seed_(flags.seed),
        scratch_("plan") {}

  const measurement::MeasurementSet& protocol() const { return protocol_; }

  // By the protocol as it is: errors have the names of its own files.
  std::unique_ptr<measurement::Problem> made() {
    if (measurement::needs_its_measurements(protocol_))
      return measurement::open_problem(protocol_.folder, instruments_);
    return made_by(protocol_, model_);
  }
  measurement::MeasurementSet changed(const measurement::ProtocolChange& change) {
    const std::filesystem::path folder = next_folder();
    measurement::write_changed(protocol_, change, folder / "protocol");
    return measurement::MeasurementSet::open(folder / "protocol");
  }
  // What a model gives by a protocol.
  std::unique_ptr<measurement::Problem> made_by(const measurement::MeasurementSet& protocol,
                                                const effects::Model& model) {
    return made_in(next_folder(), protocol, model);
  }
  // The same for looks on several threads: of a kind that holds all of a set in memory, whose files
  // may be large.
  std::unique_ptr<measurement::Problem> looked_at(const measurement::MeasurementSet& protocol,
                                                  const effects::Model& model) {
    const app::ScratchFolder scratch("plan-look");
    return made_in(scratch.path(), protocol, model);
  }

 private:
  std::unique_ptr<measurement::Problem> made_in(const std::filesystem::path& folder,
                                                const measurement::MeasurementSet& protocol,
                                                const effects::Model& model) const {
    measurement::measure_set(model, protocol, {.seed = seed_, .out = folder / "set"}, instruments_);
    return measurement::open_problem(folder / "set", instruments_);
  }
  std::filesystem::path next_folder() { return scratch_.path() / std::to_string(count_++); }

  const effects::Model& model_;
  measurement::MeasurementSet protocol_;
  measurement::Instruments instruments_;
  uint64_t seed_ = 1;
  app::ScratchFolder scratch_;
  size_t count_ = 0;
};

// The size of its first parameter from which a plan says that an effect is found.
double size_found(const measurement::Plan& plan, const std::string& name) {
  for (const measurement::PlannedEffect& effect : plan.effects) {
    if (effect.effect == name && !effect.parameters.empty() &&
        effect.parameters.front().smallest_found)
      return *effect.parameters.front().smallest_found;
  }
  throw InputError(name +
                   ": this protocol would not find it at any size in its bounds, so that "
                   "nothing can be separated from it");
}

void consider(const measurement::Planner& planner, const std::string& what, double cost,
              measurement::Improved& improved) {
  const double repeats = std::max(
      1.0, planner.gains(improved.effect, improved.size, improved.other).repeats_to_part());
  if (!std::isfinite(repeats)) return;
  improved.improvements.push_back({.what = what, .repeats = repeats, .cost = cost * repeats});
}

measurement::WholePlan planned(const PlanFlags& flags, const effects::Model& model) {
  PlannedSets sets(flags, model);
  measurement::PlanOptions options{
      .effects = effects_in(flags.effects, "--effects"),
      .material = flags.files.material,
      .made = [&](const effects::Model& truth) { return sets.looked_at(sets.protocol(), truth); }};
  const std::vector<std::string> pair = effects_in(flags.improve, "--improve");
  if (!flags.improve.empty() && pair.size() != 2)
    throw UsageError(
        fmt::format("--improve: found {} effects, expected two: --improve A,B", pair.size()));
  if (!pair.empty() &&
      std::find(options.effects.begin(), options.effects.end(), pair[0]) == options.effects.end())
    options.effects.push_back(pair[0]);
  const auto problem = sets.made();
  say_work("planning");
  const measurement::Planner planner(*problem, model, options);
  if (!pair.empty() && !planner.grows_with_groups())
    throw UsageError("--improve: a plan of flat fields compares no pairs: seam study photometry");
  measurement::WholePlan whole{
      .title = problem->facts().title, .kind = problem->facts().kind(), .plan = planner.plan()};
  if (options.effects.empty()) return whole;
  std::optional<measurement::Improved> improved;
  if (!pair.empty()) {
    improved = measurement::Improved{.effect = pair[0],
                                     .other = pair[1],
                                     .size = size_found(whole.plan, pair[0]),
                                     .advice = problem->advice(pair[0], pair[1])};
    consider(planner, "the protocol as it is", 1, *improved);
  }
  for (const measurement::ProtocolChange& change : measurement::changes_of(sets.protocol())) {
    say_work("planning " + change.what);
    if (change.repeats > 1 && planner.grows_with_groups()) {
      whole.changes.push_back({change, planner.repeated(change.repeats).plan()});
      continue;
    }
    const measurement::MeasurementSet protocol = sets.changed(change);
    const auto changed = sets.made_by(protocol, model);
    measurement::PlanOptions its = options;
    its.made = [&](const effects::Model& truth) { return sets.looked_at(protocol, truth); };
    const measurement::Planner there(*changed, model, its);
    whole.changes.push_back({change, there.plan()});
    if (improved) consider(there, change.what, change.cost, *improved);
  }
  if (improved)
    std::stable_sort(improved->improvements.begin(), improved->improvements.end(),
                     [](const auto& a, const auto& b) { return a.cost < b.cost; });
  whole.improved = std::move(improved);
  return whole;
}

}  // namespace

void add_plan(app::Command app) {
  app::Command command = app.add_subcommand(
      "plan",
      "Computes what a measurement would show before it is made: standard errors, smallest effects "
      "found, ties");
  auto flags = std::make_shared<PlanFlags>();
  command.add_option("--model", flags->files.model, "The model (seam-model/1)").required();
  command
      .add_option("--protocol", flags->files.data,
                  "A measurement set; its measured columns are not read")
      .required();
  command.add_option("--effects", flags->effects,
                     "Effects, a,b,...: only these, and how other protocols change them; left out: "
                     "all that the model lacks");
  command.add_option(
      "--improve", flags->improve,
      "Two effects, a,b: the change of the protocol that separates the first from the "
      "second at least cost");
  command.add_option("--seed", flags->seed, "Seed of the set that is made to look at")
      .show_default();
  add_material_flag(command, flags->files);
  add_run_flags(command, flags->files.runs);
  command.add_option("--json", flags->files.json, "Writes the plan as JSON");
  command.add_option("--report", flags->files.report, "Writes the plan as a web page");
  command.footer(
      "Example: seam plan --model nominal.yaml --protocol sets/room --effects "
      "frame_latency,rolling_shutter --json plan.json");
  command.callback([flags] {
    AnalysisOutputs outputs(flags->files);
    const effects::Model model = read_model(flags->files.model);
    const measurement::WholePlan whole = planned(*flags, model);
    outputs.print(measurement::plan_text(whole), [&] { return measurement::plan_json(whole); });
    if (outputs.report) {
      const std::string line =
          fmt::format("seam plan --model {} --protocol {} --report {}", flags->files.model,
                      flags->files.data, flags->files.report);
      measurement::write_report(outputs.report, measurement::plan_report(whole, line));
    }
  });
}

}  // namespace seam::tools
