#include "app/import/servo/servo_roles.h"

#include <algorithm>
#include <cctype>
#include <vector>

namespace seam::app {
namespace {

using Names = std::vector<std::string>;

const Names& words_of(Role role) {
  static const Names commands = {"command", "cmd",     "control",   "goal",    "target",
                                 "action",  "desired", "reference", "setpoint"};
  static const Names states = {"state",  "measured", "measurement", "feedback",
                               "actual", "present",  "observation", "encoder"};
  return role == Role::command ? commands : states;
}

std::string lower_case(std::string text) {
  for (char& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return text;
}

bool holds_one_of(const std::string& text, const Names& words) {
  return std::any_of(words.begin(), words.end(), [&](const std::string& word) {
    return lower_case(text).find(word) != std::string::npos;
  });
}

}  // namespace

Role role_in(const std::string& text) {
  const bool command = holds_one_of(text, words_of(Role::command));
  const bool state = holds_one_of(text, words_of(Role::state));
  return command == state ? Role::unknown : command ? Role::command : Role::state;
}

std::string without_role(const std::string& text) {
  std::string left = lower_case(text);
  for (const Role role : {Role::command, Role::state}) {
    for (const std::string& word : words_of(role)) {
      for (const std::string& form : {word + "s", word}) {
        const size_t at = left.find(form);
        if (at != std::string::npos) left.erase(at, form.size());
      }
    }
  }
  std::erase_if(left, [](char c) { return std::isalnum(static_cast<unsigned char>(c)) == 0; });
  return left;
}

}  // namespace seam::app
