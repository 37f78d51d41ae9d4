#include "app/trust/program_consent.h"

#include <fmt/format.h>
#include <unistd.h>

#include <iostream>

#include "sim_core/base/error.h"
#include "sim_core/input/shown_text.h"

namespace seam::app {

std::vector<std::string> programs_of(const Scenario& scenario) {
  std::vector<std::string> programs;
  for (const RobotSpec& robot : scenario.robots) {
    const std::vector<std::string>& command = robot.behaviour.command;
    if (command.empty()) continue;
    programs.push_back(shown(fmt::format("{}: {}", robot.id, fmt::join(command, " "))));
  }
  return programs;
}

void require_consent(const std::vector<std::string>& programs, bool agreed, bool terminal,
                     std::istream& in, std::ostream& out) {
  if (agreed || programs.empty()) return;
  const std::string list = fmt::format("{}", fmt::join(programs, "\n  "));
  if (!terminal) {
    throw UsageError(
        fmt::format("it names programs to start; --run-programs allows it:\n  {}", list));
  }
  out << "It names programs to start on this machine:\n  " << list << "\nStart them? [y/N] "
      << std::flush;
  std::string answer;
  std::getline(in, answer);
  if (answer != "y" && answer != "yes") throw UsageError("the programs were not started");
}

void require_consent(const std::vector<std::string>& programs, bool agreed) {
  const bool terminal = isatty(STDIN_FILENO) != 0 && isatty(STDERR_FILENO) != 0;
  require_consent(programs, agreed, terminal, std::cin, std::cerr);
}

}  // namespace seam::app
