#include "app/logs/log_difference.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "app/logs/decision_fields.h"
#include "app/logs/replay_match.h"
#include "sim_core/base/error.h"
#include "sim_core/input/shown_text.h"

namespace seam::app {

scheduler::LogDifference difference_of(const scheduler::Log& a, const scheduler::Log& b) {
  scheduler::LogDifference difference = scheduler::compare_logs(a, b);
  if (auto& decision = difference.first_decision; decision && decision->a && decision->b) {
    decision->fields =
        other_fields(decision->a->answer, decision->b->answer, JointNames(a.header()));
  }
  if (!difference.first) return difference;
  try {
    ReplayMatch match_a(a), match_b(b);
    const auto state_of = [](ReplayMatch& match) {
      return [&match](SimTime time) {
        match.rewinder().to(time);
        return match.world().sections();
      };
    };
    scheduler::name_field(difference, state_of(match_a), state_of(match_b));
  } catch (const InputError&) {
    // A log that cannot be re-run (older states, a damaged part) still gives time and section.
  }
  return difference;
}

namespace {

// The two decisions beside each other, and whether they were made from the same frame.
std::string to_text(const scheduler::LogDifference::FirstDecision& decision) {
  std::string text = seam::app::to_text(decision.fields);
  if (const auto same = decision.same_frame()) {
    text += fmt::format("  {:<24} {} and {}, {}\n", "decided from frame", decision.a->frame->index,
                        decision.b->frame->index, *same ? "the same pixels" : "other pixels");
  }
  return text;
}

nlohmann::ordered_json to_json(const scheduler::LogDifference::FirstDecision& decision) {
  nlohmann::ordered_json json = {{"time_ns", decision.time.ns()},
                                 {"robot", decision.robot},
                                 {"fields", nlohmann::ordered_json::array()},
                                 {"frame", nullptr}};
  for (const auto& field : decision.fields)
    json["fields"].push_back({{"field", field.name}, {"a", field.a}, {"b", field.b}});
  if (const auto same = decision.same_frame()) {
    json["frame"] = {
        {"a", decision.a->frame->index}, {"b", decision.b->frame->index}, {"same", *same}};
  }
  return json;
}

std::string dumped(const nlohmann::ordered_json& json, int indent) {
  return json.dump(indent, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
}

}  // namespace

std::string to_text(const scheduler::LogDifference& difference) {
  std::string text;
  for (const std::string& line : difference.header) text += shown(line) + "\n";
  if (difference.first_decision) {
    const std::string& robot = difference.first_decision->robot;
    text += fmt::format("first other decision: {}, {}\n", seconds(difference.first_decision->time),
                        robot.empty() ? "where other robots decide, or at other times" : robot);
    text += to_text(*difference.first_decision);
  }
  if (difference.first) {
    const auto& first = *difference.first;
    text +=
        fmt::format("first difference: {} ({} ns), section {}, field {}", seconds(first.time),
                    first.time.ns(), first.section, first.field.empty() ? "unknown" : first.field);
    if (!first.a.empty() || !first.b.empty()) {
      text += fmt::format(": {} and {}", first.a, first.b);
    }
    text += "\nspreads:\n";
    for (const auto& step : difference.spread) {
      text += fmt::format("  {:>12}  {}\n", seconds(step.time), step.section);
    }
  }
  if (difference.end_a != difference.end_b) {
    text +=
        fmt::format("lengths: {} and {}\n", seconds(difference.end_a), seconds(difference.end_b));
  }
  text += difference.equal() ? "equal" : "different";
  text += fmt::format(" (compared up to {})\n", seconds(difference.compared_until));
  return shown_lines(text);
}

std::string to_json(const scheduler::LogDifference& difference) {
  nlohmann::ordered_json json = {{"format", "seam-diff/1"},
                                 {"equal", difference.equal()},
                                 {"header", difference.header},
                                 {"compared_until_ns", difference.compared_until.ns()},
                                 {"first", nullptr},
                                 {"first_decision", nullptr}};
  if (difference.first) {
    const auto& first = *difference.first;
    json["first"] = {{"time_ns", first.time.ns()},
                     {"section", first.section},
                     {"field", first.field},
                     {"a", first.a},
                     {"b", first.b}};
  }
  if (difference.first_decision) json["first_decision"] = to_json(*difference.first_decision);
  json["spread"] = nlohmann::ordered_json::array();
  for (const auto& step : difference.spread) {
    json["spread"].push_back({{"time_ns", step.time.ns()}, {"section", step.section}});
  }
  json["ends_ns"] = {difference.end_a.ns(), difference.end_b.ns()};
  return dumped(json, 2);
}

std::string to_view_json(const scheduler::LogDifference& difference) {
  nlohmann::ordered_json json = {{"equal", difference.equal()},
                                 {"header", difference.header},
                                 {"compared_until_s", difference.compared_until.s()},
                                 {"first", nullptr},
                                 {"first_decision", nullptr},
                                 {"spread", nlohmann::ordered_json::array()}};
  if (difference.first_decision) {
    json["first_decision"] = to_json(*difference.first_decision);
    json["first_decision"]["time_ns"] = std::to_string(difference.first_decision->time.ns());
    json["first_decision"]["t"] = difference.first_decision->time.s();
  }
  if (difference.first) {
    const auto& first = *difference.first;
    json["first"] = {{"t", first.time.s()},
                     {"time_ns", std::to_string(first.time.ns())},
                     {"section", first.section},
                     {"field", first.field},
                     {"a", first.a},
                     {"b", first.b}};
  }
  for (const auto& step : difference.spread) {
    json["spread"].push_back({{"t", step.time.s()}, {"section", step.section}});
  }
  return dumped(json, -1);
}

}  // namespace seam::app
