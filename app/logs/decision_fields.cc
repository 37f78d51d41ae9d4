#include "app/logs/decision_fields.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>

#include "sim_core/input/shown_text.h"

namespace seam::app {
namespace {

using scheduler::Answer;
using scheduler::DebugItem;
using scheduler::FrameRequest;

using Fields = NamedTexts;

const char* name_of(scheduler::Outcome outcome) {
  constexpr const char* kNames[] = {"decided", "frozen", "absent", "resumed", "abort"};
  return kNames[static_cast<int>(outcome)];
}

std::string text_of(const FrameRequest& request) {
  if (request.which == FrameRequest::Which::all) return "all";
  if (request.which == FrameRequest::Which::none) return "none";
  return fmt::format("next {} from {:.9g} s", request.count, request.after.s());
}

void add_joints(const Answer& answer, const JointNames& joints, Fields& fields) {
  for (const JointFrame& frame : answer.decision.command.joints) {
    const std::string when =
        frame.offset.ns() == 0 ? "" : fmt::format(" after {:.9g} ms", 1e3 * frame.offset.s());
    for (const JointTarget& target : frame.targets) {
      const std::string joint = joints.of(static_cast<size_t>(answer.robot), target.joint);
      fields.push_back({joint + "_rad" + when, fmt::format("{}", target.angle_rad)});
      if (target.speed_radps > 0)
        fields.push_back(
            {joint + ".max_speed_rad_s" + when, fmt::format("{}", target.speed_radps)});
    }
  }
}

Fields fields_of(const Answer& answer, const JointNames& joints) {
  Fields fields = {{"outcome", name_of(answer.outcome)}};
  for (auto& order : orders_of(answer, joints)) fields.push_back(std::move(order));
  for (const DebugItem& item : answer.decision.debug) {
    if (item.kind == DebugItem::Kind::value)
      fields.push_back({"logged." + item.name, fmt::format("{}", item.value)});
    if (item.kind == DebugItem::Kind::text)
      fields.push_back({"logged." + item.name, shown(item.text)});
  }
  return fields;
}

// A number to four digits where the two still differ so.
std::pair<std::string, std::string> for_people(const DecisionField& field) {
  const auto brief = [](const std::string& text) {
    double value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    const bool whole = error == std::errc() && end == text.data() + text.size();
    return whole ? fmt::format("{:.4g}", value) : text.empty() ? "nothing" : text;
  };
  const std::string a = brief(field.a), b = brief(field.b);
  return a == b ? std::pair(field.a, field.b) : std::pair(a, b);
}

}  // namespace

NamedTexts orders_of(const Answer& answer, const JointNames& joints) {
  Fields fields;
  add_joints(answer, joints, fields);
  const RobotCommand& command = answer.decision.command;
  if (command.walk) {
    fields.push_back({"walk.vx_m_s", fmt::format("{}", command.walk->vx_mps)});
    fields.push_back({"walk.vy_m_s", fmt::format("{}", command.walk->vy_mps)});
    fields.push_back({"walk.omega_rad_s", fmt::format("{}", command.walk->omega_radps)});
  }
  if (command.kick != Kick::none) fields.push_back({"kick", to_string(command.kick)});
  for (const FrameRequest& request : answer.decision.frame_requests)
    fields.push_back({"frames", text_of(request)});
  for (const std::string& message : answer.decision.messages)
    fields.push_back({"message", shown(message)});
  return fields;
}

std::vector<DecisionField> other_fields(const Answer& a, const Answer& b,
                                        const JointNames& joints) {
  return other_fields(fields_of(a, joints), fields_of(b, joints));
}

std::string to_text(const std::vector<DecisionField>& fields) {
  std::string text;
  for (const DecisionField& field : fields) {
    const auto [a, b] = for_people(field);
    text += fmt::format("  {:<24} {} and {}\n", field.name, a, b);
  }
  return text;
}

std::vector<DecisionField> other_fields(const NamedTexts& a, const NamedTexts& b) {
  std::vector<DecisionField> fields;
  for (const auto& [name, value] : a) fields.push_back({name, value, ""});
  for (const auto& [name, value] : b) {
    const auto same =
        std::find_if(fields.begin(), fields.end(), [&, &name = name](const DecisionField& field) {
          return field.name == name && field.b.empty();
        });
    if (same == fields.end()) {
      fields.push_back({name, "", value});
    } else {
      same->b = value;
    }
  }
  std::erase_if(fields, [](const DecisionField& field) { return field.a == field.b; });
  return fields;
}

}  // namespace seam::app
