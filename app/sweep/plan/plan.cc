#include "app/sweep/plan/plan.h"

#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <cctype>

#include "app/simulator.h"
#include "sim_core/base/error.h"
#include "sim_core/base/files.h"
#include "sim_core/base/hash.h"
#include "sim_core/base/random.h"

namespace seam::app {
namespace {

namespace fs = std::filesystem;

constexpr const char* kFormat = "seam-sweep/1";
constexpr uint64_t kMostPlanBytes = 16 << 20;
constexpr int64_t kMostRepetitions = 1'000'000'000'000;
// Settings of an axis that may name files, and those that are tried before anything runs.
constexpr uint64_t kMostFileSettings = 10'000;
constexpr uint64_t kTriedSettings = 16;

// Secrets stay out of results; the server makes new ones for each run.
Scenario without_tokens(Scenario scenario) {
  scenario.supervisor_token.clear();
  scenario.render_token.clear();
  for (RobotSpec& robot : scenario.robots) robot.token.clear();
  return scenario;
}

ConfigNode plan_root(const std::string& text, const std::string& name) {
  ConfigNode root = ConfigNode::from_text(text, name);
  root.at("format").choice({kFormat});
  return root;
}

// As text without comments and layout.
std::string plain_yaml(const std::string& text) {
  YAML::Emitter out;
  out << YAML::Load(text);
  return out.c_str();
}

std::string lower(std::string text) {
  for (char& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return text;
}

// The seed of a repetition, drawn by its number; the first has the setting's own. Settings of equal
// seed have equal seeds in each repetition, so that they can be compared pair by pair.
int64_t repeated_seed(int64_t seed, uint64_t repetition) {
  if (repetition == 0) return seed;
  const auto bits =
      random_bits(RandomStream{static_cast<uint64_t>(seed)}.child("repetition"), repetition);
  return static_cast<int64_t>(((uint64_t{bits[0]} << 32) | bits[1]) >> 1);
}

}  // namespace

SweepPlan SweepPlan::from_file(const fs::path& file) {
  PlanTexts texts{.name = file.filename().string(), .plan = read_file(file, kMostPlanBytes)};
  const ConfigNode root = plan_root(texts.plan, file.string());
  const ConfigNode scenario = root.at("scenario");
  texts.scenario_name = scenario.text();
  try {
    texts.scenario =
        without_tokens(Scenario::from_file(file.parent_path() / texts.scenario_name)).to_yaml();
  } catch (const InputError& error) {
    scenario.fail(error.what());
  }
  texts.name = file.string();
  SweepPlan plan(texts, PlanFiles(file.parent_path()));
  plan.texts_.name = file.filename().string();
  return plan;
}

SweepPlan SweepPlan::from_texts(const PlanTexts& texts) {
  return {texts, PlanFiles(texts.files)};
}

SweepPlan::SweepPlan(PlanTexts texts, PlanFiles files)
    : texts_(std::move(texts)), files_(std::move(files)) {
  const ConfigNode root = plan_root(texts_.plan, texts_.name);
  read(root);
  texts_.files = files_.texts();
  try_some_runs();
}

void SweepPlan::read(const ConfigNode& root) {
  for (const char* key : {"scenario", "name", "description"}) root.has(key);
  read_changes(root);
  read_axes(root);
  repetitions_ = static_cast<uint64_t>(root.integer_or("repetitions", 1, 1, kMostRepetitions));
  if (const auto limits = root.find("limits")) {
    wall_limit_s_ = limits->at("wall_s").number({1e-3, 1e9});
    limits->finish();
  }
  const auto keep = root.find("keep");
  for (const Axis& axis : axes_) {
    for (const SweepParameter& parameter : axis.parameters) parameters_.push_back(parameter.name);
  }
  keep_ = read_keep(keep, base_->scenario(), parameters_, parameters_without_number());
  root.finish();
  name_columns(root);
  count_runs(root);
}

std::set<std::string> SweepPlan::parameters_without_number() const {
  std::set<std::string> names;
  for (const Axis& axis : axes_) {
    for (size_t p = 0; p < axis.parameters.size(); ++p) {
      bool number = false;
      for (uint64_t i = 0; i < std::min(axis.size, kMostFileSettings) && !number; ++i)
        number = number_of(axis.value(p, i)).has_value();
      if (!number) names.insert(axis.parameters[p].name);
    }
  }
  return names;
}

WrittenValue SweepPlan::content(const WrittenValue& value, bool takes_file) const {
  if (!takes_file || !value.plain) return value;
  return {files_.texts().at(value.text), false};
}

void SweepPlan::read_changes(const ConfigNode& root) {
  base_.emplace(texts_.scenario, texts_.scenario_name);
  const auto changes = root.find("set");
  if (!changes) return;
  for (const std::string& path : changes->keys()) {
    const ConfigNode node = changes->at(path);
    try {
      const WrittenValue value = written(node);
      const bool takes_file = base_->takes_file(path);
      if (takes_file && value.plain) files_.text(value.text);
      base_->set(path, content(value, takes_file));
    } catch (const InputError& error) {
      node.fail(error.what());
    }
  }
}

void SweepPlan::read_axes(const ConfigNode& root) {
  std::vector<ConfigNode> nodes;
  if (const auto vary = root.find("vary")) {
    for (const ConfigNode& entry : vary->items()) {
      axes_.push_back(read_axis(entry, files_));
      nodes.push_back(entry);
    }
  }
  if (const auto seeds = root.find("seeds")) {
    axes_.push_back(seed_axis(*seeds));
    seeds_ = axes_.back().size;
    nodes.push_back(*seeds);
  }
  for (size_t a = 0; a < axes_.size(); ++a) {
    Axis& axis = axes_[a];
    for (size_t p = 0; p < axis.parameters.size(); ++p) {
      SweepParameter& parameter = axis.parameters[p];
      try {
        for (const std::string& path : parameter.paths)
          parameter.takes_file = base_->takes_file(path);
        if (!parameter.takes_file) continue;
        for (uint64_t i = 0; i < std::min(axis.size, kMostFileSettings); ++i) {
          const WrittenValue value = axis.value(p, i);
          if (value.plain) files_.text(value.text);
        }
      } catch (const InputError& error) {
        nodes[a].fail(error.what());
      }
    }
  }
}

void SweepPlan::count_runs(const ConfigNode& root) {
  // In floating point first, which does not overflow.
  double count = static_cast<double>(repetitions_);
  for (const Axis& axis : axes_) count *= static_cast<double>(axis.size);
  if (count > static_cast<double>(kMostRuns))
    root.fail(
        fmt::format("the plan has {:.17g} runs, expected at most {}: draw some of the "
                    "combinations ('draws'), or make several plans of it",
                    count, kMostRuns));
  runs_ = repetitions_;
  for (const Axis& axis : axes_) runs_ *= axis.size;
}

// A table cannot have two columns of one name, nor SQL two that differ in case alone.
void SweepPlan::name_columns(const ConfigNode& root) {
  std::vector<std::string> names = {"run", "repetition", "error", "key", "wall_s", "failed"};
  for (const char* column : kSummaryColumns) names.emplace_back(column);
  const auto add = [&](const std::string& name) {
    const bool known = std::any_of(names.begin(), names.end(), [&](const std::string& other) {
      return lower(other) == lower(name);
    });
    if (known)
      root.fail(
          fmt::format("two columns would be called '{}': give one of them another name "
                      "('name' in vary, 'as' in keep)",
                      name));
    names.push_back(name);
  };
  for (const std::string& parameter : parameters_) {
    if (parameter != "seed") add(parameter);  // The summary has its column.
  }
  for (const std::string& column : keep_.columns()) add(column);
}

RunSettings SweepPlan::settings(uint64_t run) const {
  SEAM_CHECK(run < runs_, "run {} of {}", run, runs_);
  RunSettings settings;
  settings.repetition = run % repetitions_;
  uint64_t rest = run / repetitions_;
  std::vector<uint64_t> places(axes_.size());
  for (size_t a = axes_.size(); a-- > 0;) {
    places[a] = rest % axes_[a].size;
    rest /= axes_[a].size;
  }
  for (size_t a = 0; a < axes_.size(); ++a) {
    for (size_t p = 0; p < axes_[a].parameters.size(); ++p)
      settings.values.push_back(axes_[a].value(p, places[a]));
  }
  return settings;
}

// `seeds:` is the axis that stands last and thus varies fastest but for repetitions.
uint64_t SweepPlan::with_first_seed(uint64_t run) const {
  const uint64_t of_seeds = std::max<uint64_t>(1, seeds_) * repetitions_;
  return run / of_seeds * of_seeds;
}

Scenario SweepPlan::worked_out(uint64_t run, const RunSettings& settings,
                               const Known& known) const {
  // Nothing else of a scenario depends on its seed.
  if (const auto alike = known.find(with_first_seed(run)); seeds_ > 0 && alike != known.end()) {
    Scenario scenario = alike->second;
    scenario.seed = std::stoll(settings.values.back().text);
    return scenario;
  }
  ScenarioTree tree(*base_);
  size_t at = 0;
  for (const Axis& axis : axes_) {
    for (const SweepParameter& parameter : axis.parameters) {
      const WrittenValue value = content(settings.values[at++], parameter.takes_file);
      for (const std::string& path : parameter.paths) tree.set(path, value);
    }
  }
  return tree.scenario();
}

Scenario SweepPlan::scenario(uint64_t run) const {
  const RunSettings settings = this->settings(run);
  try {
    Scenario scenario = worked_out(run, settings, *known_);
    scenario.seed = repeated_seed(scenario.seed, settings.repetition);
    return scenario;
  } catch (const InputError& error) {
    throw InputError(fmt::format("{}: run {}: {}", texts_.name, run, error.what()));
  }
}

void SweepPlan::try_some_runs() {
  std::vector<uint64_t> tried = {0};
  uint64_t stride = repetitions_;
  for (size_t a = axes_.size(); a-- > 0;) {
    const uint64_t size = axes_[a].size;
    for (uint64_t i = 1; i < size; ++i) {
      if (size <= kTriedSettings || i + 1 == size) tried.push_back(i * stride);
      if (size > kTriedSettings) i = std::max(i, size - 2);
    }
    stride *= size;
  }
  for (const uint64_t run : tried) {
    const Scenario scenario = this->scenario(run);
    if (seeds_ > 0 && run == with_first_seed(run)) {
      Known known = *known_;
      known.emplace(run, scenario);
      known_ = std::make_shared<const Known>(std::move(known));
    }
    try {
      models_of(scenario);
    } catch (const InputError& error) {
      throw InputError(fmt::format("{}: run {}: {}", texts_.name, run, error.what()));
    }
    for (const RobotSpec& robot : scenario.robots) {
      if (!robot.behaviour.command.empty()) commands_.emplace(robot.behaviour.command, robot.id);
    }
  }
}

std::vector<uint64_t> SweepPlan::runs_of_words() const {
  std::vector<uint64_t> runs = {0};
  uint64_t stride = repetitions_;
  for (size_t a = axes_.size(); a-- > 0;) {
    const auto is_number = [&](uint64_t i) {
      for (size_t p = 0; p < axes_[a].parameters.size(); ++p)
        if (!number_of(axes_[a].value(p, i))) return false;
      return true;
    };
    for (uint64_t i = 1; i < axes_[a].size; ++i)
      if (!is_number(i)) runs.push_back(i * stride);
    stride *= axes_[a].size;
  }
  return runs;
}

uint64_t SweepPlan::fingerprint() const {
  Hasher hasher;
  hasher.add(std::string_view(plain_yaml(texts_.plan)));
  hasher.add(std::string_view(texts_.scenario));
  for (const auto& [name, text] : texts_.files) {
    hasher.add(std::string_view(name));
    hasher.add(std::string_view(text));
  }
  return hasher.digest();
}

}  // namespace seam::app
