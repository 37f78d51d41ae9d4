// What the names of files and columns say: whether they hold commands or what was measured.
#pragma once

#include <string>

namespace seam::app {

enum class Role { unknown, command, state };

// What this name says; unknown where it says nothing or both.
Role role_in(const std::string& text);

// What is left of a name without the words of roles: "state_motor_3" -> "motor3".
std::string without_role(const std::string& text);

}  // namespace seam::app
