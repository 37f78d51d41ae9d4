#include "app/command_line.h"

#include <CLI/CLI.hpp>
#include <algorithm>

namespace seam::app {

Option& Option::required() {
  option_->required();
  return *this;
}

Option& Option::range(int min, int max) {
  option_->check(CLI::Range(min, max));
  return *this;
}

Option& Option::range(double min, double max) {
  option_->check(CLI::Range(min, max));
  return *this;
}

Option& Option::one_of(std::initializer_list<std::string> words) {
  option_->check(CLI::IsMember(words));
  return *this;
}

Option& Option::count(int min, int max) {
  option_->expected(min, max);
  return *this;
}

Option& Option::environment(const std::string& variable) {
  option_->envname(variable);
  return *this;
}

Option& Option::show_default() {
  option_->capture_default_str();
  return *this;
}

Command Command::add_subcommand(const std::string& name, const std::string& help) {
  return Command(app_->add_subcommand(name, help));
}

#define SEAM_ADD_OPTION(Type)                                                                  \
  Option Command::add_option(const std::string& names, Type& value, const std::string& help) { \
    return Option(app_->add_option(names, value, help));                                       \
  }
SEAM_ADD_OPTION(std::string)
SEAM_ADD_OPTION(std::vector<std::string>)
SEAM_ADD_OPTION(std::filesystem::path)
SEAM_ADD_OPTION(int)
SEAM_ADD_OPTION(uint64_t)
SEAM_ADD_OPTION(std::optional<int64_t>)
SEAM_ADD_OPTION(double)
SEAM_ADD_OPTION(std::optional<double>)
#undef SEAM_ADD_OPTION

Option Command::add_flag(const std::string& names, bool& value, const std::string& help) {
  return Option(app_->add_flag(names, value, help));
}

Option Command::add_flag(const std::string& names, std::function<void()> when_given,
                         const std::string& help) {
  return Option(app_->add_flag_function(
      names, [when_given](int64_t) { when_given(); }, help));
}

void Command::require_subcommand() {
  app_->require_subcommand(1);
}

void Command::footer(const std::string& text) {
  app_->footer(text);
}

void Command::callback(std::function<void()> action) {
  app_->callback(std::move(action));
}

int parse_and_run(const std::string& help, const std::string& program, const std::string& version,
                  const std::vector<std::string>& arguments,
                  const std::function<void(Command)>& add_commands) {
  CLI::App app{help, program};
  app.set_version_flag("--version", version);
  add_commands(Command(&app));
  try {
    // CLI11 takes the arguments last to first.
    app.parse(std::vector<std::string>(arguments.rbegin(), arguments.rend()));
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  }
  return 0;
}

std::vector<std::string> split_words(const std::string& text) {
  return CLI::detail::split_up(text);
}

}  // namespace seam::app
