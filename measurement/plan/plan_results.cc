#include "measurement/plan/plan_results.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "measurement/check/describe.h"
#include "measurement/report/finite_or_null.h"

namespace seam::measurement {
namespace {

using nlohmann::ordered_json;

std::string number(double value) {
  return std::isfinite(value) ? fmt::format("{:.3g}", value) : "not determined";
}

std::string smallest(const PlannedEffect& effect, const PlannedParameter& parameter) {
  if (effect.in_model) return "in the model";
  return parameter.smallest_found ? number(*parameter.smallest_found) : "not in its bounds";
}

std::string ties_text(const Plan& plan, const PlannedEffect& effect) {
  if (!plan.has_ties) return "not computed";
  std::vector<std::string> ties;
  for (const PlannedTie& tie : effect.ties)
    ties.push_back(tie.apart_from
                       ? fmt::format("{} (below {})", tie.effect, number(*tie.apart_from))
                       : tie.effect + " (at any size)");
  return fmt::format("{}", fmt::join(ties, ", "));
}

std::string headline(const WholePlan& whole) {
  const Plan& plan = whole.plan;
  size_t found = 0, planned = 0;
  for (const PlannedEffect& effect : plan.effects) {
    planned += !effect.in_model;
    found += std::any_of(effect.parameters.begin(), effect.parameters.end(),
                         [](const PlannedParameter& p) { return p.smallest_found.has_value(); });
  }
  return fmt::format("{} of {} effects would be found at some size: {} residuals in {} groups",
                     found, planned, plan.residuals, plan.groups);
}

ordered_json effects_json(const Plan& plan) {
  ordered_json list = ordered_json::array();
  for (const PlannedEffect& effect : plan.effects) {
    ordered_json parameters = ordered_json::object(), found = ordered_json::object();
    for (const PlannedParameter& p : effect.parameters) {
      parameters[p.name] = {{"sigma", finite_or_null<ordered_json>(p.sigma)},
                            {"unit", unit_of(p.name)}};
      if (!effect.in_model)
        found[p.name] = p.smallest_found ? ordered_json(*p.smallest_found) : ordered_json(nullptr);
    }
    ordered_json ties = ordered_json::array();
    for (const PlannedTie& tie : effect.ties)
      ties.push_back(
          {{"effect", tie.effect},
           {"apart_from", tie.apart_from ? ordered_json(*tie.apart_from) : ordered_json(nullptr)}});
    list.push_back({{"effect", effect.effect},
                    {"in_model", effect.in_model},
                    {"parameters", std::move(parameters)},
                    {"smallest_found", std::move(found)},
                    {"ties", plan.has_ties ? std::move(ties) : ordered_json(nullptr)}});
  }
  return list;
}

ordered_json json_of(const WholePlan& whole) {
  const Plan& plan = whole.plan;
  ordered_json not_planned = ordered_json::array(), changes = ordered_json::array();
  for (const NotTestable& n : plan.not_planned)
    not_planned.push_back({{"effect", n.effect}, {"parameter", n.parameter}, {"why", n.why}});
  for (const ChangedPlan& changed : whole.changes)
    changes.push_back({{"change", changed.change.what},
                       {"cost", changed.change.cost},
                       {"effects", effects_json(changed.plan)}});
  ordered_json json = {{"format", "seam-plan/1"},       {"headline", headline(whole)},
                       {"title", whole.title},          {"kind", whole.kind},
                       {"residuals", plan.residuals},   {"groups", plan.groups},
                       {"looks", plan.looks},           {"effects", effects_json(plan)},
                       {"changes", std::move(changes)}, {"not_planned", std::move(not_planned)}};
  if (!whole.improved) return json;
  const Improved& improved = *whole.improved;
  ordered_json list = ordered_json::array();
  for (const Improvement& one : improved.improvements)
    list.push_back({{"change", one.what}, {"repeats", one.repeats}, {"cost", one.cost}});
  json["improve"] = {{"effect", improved.effect},
                     {"other", improved.other},
                     {"size", improved.size},
                     {"proposals", std::move(list)},
                     {"advice", improved.advice}};
  return json;
}

// The parameter of the same name in another plan; null where there is none.
const PlannedParameter* same_in(const Plan& plan, const std::string& effect,
                                const std::string& parameter) {
  for (const PlannedEffect& other : plan.effects) {
    if (other.effect != effect) continue;
    for (const PlannedParameter& p : other.parameters)
      if (p.name == parameter) return &p;
  }
  return nullptr;
}

struct Table {
  std::string title;
  std::vector<std::string> columns;
  std::vector<std::vector<std::string>> rows;
};

Table errors_table(const Plan& plan) {
  Table table{
      .title = "Standard errors, and the smallest size that is found with 95 %",
      .columns = {"effect", "parameter", "standard error", "smallest found", "not separated from"},
      .rows = {}};
  for (const PlannedEffect& effect : plan.effects) {
    for (const PlannedParameter& p : effect.parameters) {
      const bool first = &p == &effect.parameters.front();
      table.rows.push_back({effect.effect, p.name, number(p.sigma), smallest(effect, p),
                            first ? ties_text(plan, effect) : ""});
    }
  }
  return table;
}

Table changes_table(const WholePlan& whole) {
  Table table{.title = "With another protocol: the smallest size that is found",
              .columns = {"effect", "parameter", "as planned"},
              .rows = {}};
  for (const ChangedPlan& changed : whole.changes)
    table.columns.push_back(
        fmt::format("{} (cost {:g})", changed.change.what, changed.change.cost));
  for (const PlannedEffect& effect : whole.plan.effects) {
    if (effect.in_model) continue;
    for (const PlannedParameter& p : effect.parameters) {
      std::vector<std::string> row = {effect.effect, p.name, smallest(effect, p)};
      for (const ChangedPlan& changed : whole.changes) {
        const PlannedParameter* there = same_in(changed.plan, effect.effect, p.name);
        row.push_back(there ? smallest(effect, *there) : "not testable");
      }
      table.rows.push_back(std::move(row));
    }
  }
  return table;
}

Table improved_table(const Improved& improved) {
  Table table{.title = fmt::format("To separate {} of size {} from {}, cheapest first",
                                   improved.effect, number(improved.size), improved.other),
              .columns = {"change", "repeats", "cost"},
              .rows = {}};
  for (const Improvement& one : improved.improvements)
    table.rows.push_back(
        {one.what, fmt::format("{:.3g}", one.repeats), fmt::format("{:.3g}", one.cost)});
  return table;
}

Table not_planned_table(const Plan& plan) {
  Table table{.title = "Not planned", .columns = {"effect", "parameter", "why"}, .rows = {}};
  for (const NotTestable& n : plan.not_planned)
    table.rows.push_back({n.effect, n.parameter, n.why});
  return table;
}

std::vector<Table> tables_of(const WholePlan& whole) {
  std::vector<Table> tables = {errors_table(whole.plan)};
  if (!whole.changes.empty()) tables.push_back(changes_table(whole));
  if (whole.improved && !whole.improved->improvements.empty())
    tables.push_back(improved_table(*whole.improved));
  if (!whole.plan.not_planned.empty()) tables.push_back(not_planned_table(whole.plan));
  return tables;
}

std::string text_of(const Table& table) {
  std::vector<size_t> width;
  for (const std::string& column : table.columns) width.push_back(column.size());
  for (const auto& row : table.rows)
    for (size_t c = 0; c < row.size(); ++c) width[c] = std::max(width[c], row[c].size());
  std::string text = table.title + ":\n";
  const auto line = [&](const std::vector<std::string>& cells) {
    std::string out = " ";
    for (size_t c = 0; c < cells.size(); ++c) out += fmt::format(" {:{}} ", cells[c], width[c]);
    while (out.ends_with(' ')) out.pop_back();
    text += out + "\n";
  };
  line(table.columns);
  for (const auto& row : table.rows) line(row);
  return text;
}

}  // namespace

std::string plan_text(const WholePlan& whole) {
  std::string text = headline(whole) + "\n";
  for (const Table& table : tables_of(whole)) text += text_of(table);
  if (!whole.improved) return text;
  if (whole.improved->improvements.empty())
    text += fmt::format("no change that was tried separates {} from {}\n", whole.improved->effect,
                        whole.improved->other);
  if (!whole.improved->advice.empty()) text += "advice: " + whole.improved->advice + "\n";
  return text;
}

std::string plan_json(const WholePlan& whole) {
  return json_of(whole).dump(1) + "\n";
}

std::string plan_report(const WholePlan& whole, const std::string& command) {
  ordered_json tables = ordered_json::array();
  for (const Table& table : tables_of(whole))
    tables.push_back({{"title", table.title}, {"columns", table.columns}, {"rows", table.rows}});
  return ordered_json{{"format", "seam-report/1"}, {"title", "Plan: " + whole.title},
                      {"command", command},        {"version", SEAM_VERSION},
                      {"result", json_of(whole)},  {"tables", std::move(tables)}}
      .dump();
}

}  // namespace seam::measurement
