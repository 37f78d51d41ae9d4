#include "tools/workbench/look/look.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>

#include "effects/questions.h"
#include "measurement/numerics/parallel_for.h"
#include "measurement/report/finite_or_null.h"
#include "measurement/report/report_data.h"
#include "measurement/search/models/compare.h"
#include "sim_core/base/error.h"
#include "tools/workbench/look/frame_strip.h"
#include "tools/workbench/look/outcome_runs.h"
#include "tools/workbench/look/prospects.h"
#include "tools/workbench/look/row_table.h"
#include "tools/workbench/look/set_json.h"

namespace seam::tools {
namespace {

using measurement::Candidate;
using measurement::Evaluation;
using measurement::Grown;
using measurement::Problem;
using measurement::Prospect;
using measurement::SearchResult;
using nlohmann::json;

constexpr const char* kOrder =
    "the log-likelihood of all rows less a price for each parameter, the simplest of equals first";

void say(const json& event) {
  std::printf("%s\n", event.dump().c_str());
  std::fflush(stdout);
}

// Effects that these data do not separate, and the measurement that would.
json ties_of(const Problem& problem, const std::vector<Candidate>& candidates) {
  json ties = json::array();
  std::vector<std::string> taken;
  for (const Candidate& candidate : candidates) {
    const std::string& name = candidate.effect->name;
    if (candidate.indistinguishable_from.empty() || std::ranges::find(taken, name) != taken.end())
      continue;
    std::vector<std::string> tied = {name};
    tied.insert(tied.end(), candidate.indistinguishable_from.begin(),
                candidate.indistinguishable_from.end());
    taken.insert(taken.end(), tied.begin(), tied.end());
    ties.push_back({{"effects", tied}, {"advice", problem.advice(name, tied[1])}});
  }
  return ties;
}

json values_json(const measurement::Assessment& assessment, const std::string& effect) {
  measurement::Model model = assessment.model;
  write_sigmas(model, assessment.unknowns, assessment.fit);
  const json effects = measurement::effects_json(model);
  return effects.contains(effect) ? effects[effect] : json::object();
}

class Looker {
 public:
  Looker(const AnalysisFlags& flags, std::filesystem::path out)
      : flags_(flags),
        out_(std::move(out)),
        model_(read_model(flags.model)),
        set_(open_set(flags)) {}

  void run() {
    problem_ = open_problem(flags_);
    compare();
    tell_set();
    see_prospects();
    fit_prospects();
    tell_search(/*ended=*/true);
  }

 private:
  void write(const std::string& name, const std::string& content) const {
    write_file_atomically(out_ / name, content);
  }

  // What only some kinds have.
  void write_whole(const std::string& name, const std::string& content) const {
    if (!content.empty()) write(name, content);
  }

  void compare() {
    const auto result = measurement::compare(*problem_, model_, flags_.material);
    doubts_ = doubts_about(flags_, model_, result.base.assessment.error);
    result_.base = result_.best = result.base;
    result_.base_structure = result.structure;
    write("compare.json", compare_json(*problem_, result, doubts_));
    measurement::Model fitted = result.base.assessment.model;
    write_sigmas(fitted, result.base.assessment.unknowns, result.base.assessment.fit);
    write("model.json", measurement::effects_json(fitted).dump());
    write_rows();
    say({{"event", "compared"}});
  }

  void write_rows() {
    const auto groups = problem_->all_groups();
    const measurement::Model& fitted = result_.base.assessment.model;
    const measurement::ResidualView view = problem_->residual_view(fitted, groups);
    if (!flags_.leave_out.empty()) {
      AnalysisFlags whole = flags_;
      whole.leave_out.clear();
      whole_ = open_problem(whole);
      whole_->prepare(model_);
    }
    const Problem& all = whole_ ? *whole_ : *problem_;
    table_.emplace(all, *problem_);
    const measurement::DataColumns data = measurement::data_columns(all, set_);
    write("rows.bin",
          whole_ ? table_->rows(whole_->residual_view(fitted, whole_->all_groups()), view, data)
                 : table_->rows(view, view, data));
    write_whole("frames.bin", measured_frames(*problem_, set_));
    write_whole("predicted.bin", predicted_frames(*problem_, set_, fitted));
    write_whole("runs.bin", predicted_runs(*problem_, fitted));
  }

  void tell_set() {
    write("set.json", set_json(whole_ ? *whole_ : *problem_, flags_, doubts_).dump());
    say({{"event", "set"}});
  }

  // Effects that others come with are seen last: their linearisation is dear, and the list of the
  // others need not wait for it.
  void see_prospects() {
    effects_ = absent_effects(*problem_, result_.base.assessment.model, {});
    prospects_.resize(effects_.size());
    ends_.resize(effects_.size());
    std::vector<size_t> alone, accompanied;
    for (size_t i = 0; i < effects_.size(); ++i) {
      const bool is_alone =
          effects::companions_of(*effects_[i], result_.base.assessment.model).empty();
      (is_alone ? alone : accompanied).push_back(i);
    }
    const auto near = start_of_prospects(*problem_, result_.base.assessment.model);
    for (const auto* part : {&alone, &accompanied}) {
      if (part->empty()) continue;
      see(*part, near);
      tell_steps(*part);
    }
  }

  void see(const std::vector<size_t>& part, const std::optional<Evaluation>& near) {
    std::vector<std::vector<measurement::NotTestable>> reasons(part.size());
    measurement::parallel_for(part.size(), [&](size_t k) {
      prospects_[part[k]] = prospect_of(*problem_, result_.base, effects_[part[k]], reasons[k],
                                        /*alone=*/false, near ? &*near : nullptr);
      const std::lock_guard lock(mutex_);
      say({{"event", "progress"},
           {"what", "effects looked at"},
           {"done", ++looked_at_},
           {"of", effects_.size()}});
    });
    auto& list = result_.first.not_testable;
    for (const auto& some : reasons) list.insert(list.end(), some.begin(), some.end());
    for (const size_t i : part) result_.first.tried += prospects_[i].has_value();
  }

  void preview(const std::string& how, const std::string& effect, const measurement::Model& model,
               json head) {
    const auto view = problem_->residual_view(model, problem_->all_groups());
    write_whole("predicted-" + effect + ".bin", predicted_frames(*problem_, set_, model));
    write_whole("runs-" + effect + ".bin", predicted_runs(*problem_, model));
    write(how + effect + ".bin", table_->residuals(view, std::move(head)));
    const std::lock_guard lock(mutex_);
    say({{"event", "preview"}, {"effect", effect}});
  }

  // The list by score, and what each step would leave: long before the fits.
  void tell_steps(const std::vector<size_t>& part) {
    const bool dear = problem_->screening_groups().has_value();
    measurement::parallel_for(part.size(), [&](size_t k) {
      const size_t i = part[k];
      if (prospects_[i])
        ends_[i] = (dear ? expected_end : end_of_step)(*problem_, result_.base, *prospects_[i]);
    });
    order_ = most_promising_first(prospects_, ends_);
    std::vector<size_t> fresh;
    for (const size_t i : order_) {
      if (!ends_[i] || steps_.contains(effects_[i]->name)) continue;
      fresh.push_back(i);
      steps_[effects_[i]->name] =
          prospect_json(*problem_, result_.base, *prospects_[i], *prospects_[i]->step_to, *ends_[i],
                        effects_.size());
    }
    tell_search(/*ended=*/false);
    measurement::parallel_for(fresh.size(), [&](size_t k) {
      const size_t i = fresh[k];
      if (dear && !goes_as_expected(i)) return;
      preview_before_fit(step_of(i), *prospects_[i]->step_to, "linear");
    });
    if (dear) tell_search(/*ended=*/false);
  }

  json step_of(size_t i) {
    const std::lock_guard lock(mutex_);
    return steps_.at(effects_[i]->name);
  }

  // The error where the step ends replaces the expected one; where there is no gain the candidate
  // waits for its fit.
  bool goes_as_expected(size_t i) {
    const measurement::Score held =
        problem_->score_held_out(*prospects_[i]->step_to, problem_->scored_groups());
    const std::lock_guard lock(mutex_);
    if (!held.valid || !(held.error() < result_.base.assessment.error)) {
      ends_[i].reset();
      steps_.erase(effects_[i]->name);
      return false;
    }
    ends_[i]->error = held.error();
    steps_[effects_[i]->name] =
        prospect_json(*problem_, result_.base, *prospects_[i], *prospects_[i]->step_to, *ends_[i],
                      prospects_.size());
    return true;
  }

  void preview_before_fit(const json& step, const measurement::Model& model, const char* how) {
    preview("step-", step["effect"], model,
            {{"error", step["error"]}, {"parameters", step["parameters"]}, {"how", how}});
  }

  void see_at_first(size_t i, const std::optional<measurement::FewRows>& few) {
    const Prospect& prospect = *prospects_[i];
    const auto seen = first_sight(*problem_, result_.base, prospect, few);
    if (!seen) return;
    json step =
        prospect_json(*problem_, result_.base, prospect, seen->model, seen->end, prospects_.size());
    preview_before_fit(step, seen->model, "first");
    const std::lock_guard lock(mutex_);
    ends_[i] = seen->end;
    steps_[prospect.effect->name] = std::move(step);
    tell_search(/*ended=*/false);
  }

  void tell_search(bool ended) {
    write("search.json", search_text(ended));
    json event = {{"event", "search"}};
    if (!ended) event.update({{"what", "fitted effects"}, {"done", done_}, {"of", order_.size()}});
    say(event);
  }

  void fit_prospects() {
    const Evaluation here =
        problem_->evaluate_held_out(result_.base.assessment.model, problem_->scored_groups());
    // The most promising one is fitted while what no step foresees is looked at.
    std::vector<size_t> first;
    if (!order_.empty() && ends_[order_.front()]) first.push_back(order_.front());
    std::vector<std::function<void()>> jobs;
    for (const size_t i : first) jobs.emplace_back([&, i] { fit(*prospects_[i], here); });
    const auto few = rows_for_first_sight(*problem_, result_.base.assessment.model);
    for (const size_t i : order_) {
      if (!ends_[i] && !problem_->screening_groups())
        jobs.emplace_back([&, i] { see_at_first(i, few); });
    }
    measurement::parallel_for(jobs.size(), [&](size_t k) { jobs[k](); });
    order_ = most_promising_first(prospects_, ends_);
    std::vector<size_t> rest = order_;
    std::erase_if(rest, [&](size_t i) { return std::ranges::find(first, i) != first.end(); });
    measurement::parallel_for(rest.size(), [&](size_t k) { fit(*prospects_[rest[k]], here); });
  }

  void fit(const Prospect& prospect, const Evaluation& here) {
    std::vector<measurement::NotTestable> reasons;
    auto candidate = fit_prospect(*problem_, result_.base, prospect, reasons);
    if (candidate) {
      judge(*problem_, result_.base, here, result_.first.tried, flags_.material, *candidate);
      const measurement::Assessment& after = candidate->grown.assessment;
      preview("fit-", candidate->effect->name, after.model,
              {{"error", measurement::finite_or_null<json>(after.error)},
               {"parameters", values_json(after, candidate->effect->name)},
               {"how", "fit"}});
    }
    const std::lock_guard lock(mutex_);
    auto& list = result_.first.not_testable;
    list.insert(list.end(), reasons.begin(), reasons.end());
    if (candidate) result_.first.candidates.push_back(std::move(*candidate));
    steps_.erase(prospect.effect->name);
    ++done_;
    tell_search(/*ended=*/false);
  }

  std::string search_text(bool ended) {
    for (Candidate& candidate : result_.first.candidates) candidate.indistinguishable_from.clear();
    rank_candidates(result_.first.candidates);
    json search = json::parse(looks_json(result_));
    search["ties"] = ties_of(*problem_, result_.first.candidates);
    search["prospects"] = json::array();  // Of those that wait for their fit.
    for (const size_t i : order_) {
      const auto step = steps_.find(effects_[i]->name);
      if (step != steps_.end()) search["prospects"].push_back(step->second);
    }
    search["ordered_by"] = kOrder;
    search["ended"] = ended;
    return search.dump();
  }

  const AnalysisFlags& flags_;
  const std::filesystem::path out_;
  const measurement::Model model_;
  const measurement::MeasurementSet set_;
  std::unique_ptr<Problem> problem_, whole_;
  std::optional<RowTable> table_;
  measurement::Doubts doubts_;
  SearchResult result_;
  measurement::EffectList effects_;
  Prospects prospects_;
  std::mutex mutex_;
  std::vector<std::optional<StepEnd>> ends_;  // By prospect, of its step or first sight.
  std::vector<size_t> order_;                 // Of prospects, as they are fitted.
  std::map<std::string, json> steps_;         // By effect, until it is fitted.

  size_t looked_at_ = 0, done_ = 0;
};

}  // namespace

void look_into(const AnalysisFlags& flags, const std::filesystem::path& out) {
  Looker(flags, out).run();
}

}  // namespace seam::tools
