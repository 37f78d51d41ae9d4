#include "app/command_line.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <limits>
#include <sstream>

#include "sim_core/base/error.h"
#include "sim_core/input/shown_text.h"

namespace seam::app {
namespace {

std::vector<std::string> subcommand_names(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::App* command : app.get_subcommands({})) names.push_back(command->get_name());
  return names;
}

std::vector<std::string> option_names(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::Option* option : app.get_options()) {
    for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
  }
  return names;
}

// What is wrong with the line where a word of it is no subcommand or option, with the nearest that
// there is; empty where all of them are known.
std::string unknown_word(const CLI::App& app) {
  for (const std::string& word : app.remaining()) {
    if (word.size() > 1 && word.front() == '-') {
      const std::string name = word.substr(0, word.find('='));
      return fmt::format("unknown option '{}'{}", name, suggestion_for(name, option_names(app)));
    }
    if (const auto names = subcommand_names(app); !names.empty())
      return fmt::format("unknown command '{}'{}", word, suggestion_for(word, names));
  }
  for (const CLI::App* command : app.get_subcommands()) {
    if (const std::string found = unknown_word(*command); !found.empty()) return found;
  }
  return "";
}

std::string help_of(const CLI::App& program, const std::vector<std::string>& words) {
  const CLI::App* command = &program;
  std::string path;
  for (const std::string& word : words) {
    const auto names = subcommand_names(*command);
    if (std::find(names.begin(), names.end(), word) == names.end())
      throw UsageError(fmt::format("unknown command '{}'{}", word, suggestion_for(word, names)));
    path += (path.empty() ? "" : " ") + command->get_name();
    command = command->get_subcommand(word);
  }
  // The program itself has `help` as its subcommand on this line, to which `help()` would go.
  if (words.empty())
    return program.get_formatter()->make_help(&program, program.get_name(),
                                              CLI::AppFormatMode::Normal);
  return command->help(path);
}

void add_pages(const CLI::App& app, const std::string& path, std::string& text) {
  for (const CLI::App* command : app.get_subcommands({})) {
    text += fmt::format("\n## `{} {}`\n\n```text\n{}```\n", path, command->get_name(),
                        command->help(path));
    add_pages(*command, path + " " + command->get_name(), text);
  }
}

// docs/reference/commands.md: the help of the program and of each subcommand.
std::string commands_markdown(const CLI::App& program) {
  const std::string name = program.get_name();
  std::string text = fmt::format(
      "# Commands\n\nMade by `{0} help --markdown`; a test compares this page with the program, "
      "and "
      "another runs the\nexamples. `{0} help COMMAND` and `{0} COMMAND --help` show one part of "
      "it. Names of files and folders in examples\n(`nominal.yaml`, `sets/points-a`, "
      "`match.mcap`) stand for yours.\n\n```text\n{1}```\n",
      name, help_of(program, {}));
  add_pages(program, name, text);
  return text;
}

// `help [COMMAND...]`, as many programs have it beside --help.
void add_help(CLI::App& program) {
  CLI::App* help = program.add_subcommand("help", "The help of a command, as COMMAND --help");
  auto words = std::make_shared<std::vector<std::string>>();
  auto markdown = std::make_shared<bool>(false);
  help->add_option("COMMAND", *words, "A command, and a command of it");
  help->add_flag("--markdown", *markdown,
                 "The help of all commands as a page (docs/reference/commands.md)");
  help->footer("Example: " + program.get_name() + " help " + subcommand_names(program).front());
  help->callback([&program, words, markdown] {
    const std::string text = *markdown ? commands_markdown(program) : help_of(program, *words);
    std::fputs(text.c_str(), stdout);
  });
}

// What CLI11 would read as another value: numbers beyond the type as its last one, no text at all
// as no value; a NaN is within each of its ranges. Texts that are no number are left to it.
std::string trouble_with(const std::string& text, double) {
  const bool is_number = !text.empty() && !std::isnan(std::strtod(text.c_str(), nullptr));
  return is_number ? "" : fmt::format("found '{}', expected a number", text);
}

template <typename Whole>
std::string trouble_with(const std::string& text, Whole) {
  constexpr bool kMayBeNegative = std::is_same_v<Whole, int>;
  constexpr Whole kLeast = kMayBeNegative ? std::numeric_limits<Whole>::min() : 0;
  constexpr Whole kMost = std::numeric_limits<Whole>::max();
  errno = 0;
  if constexpr (std::is_unsigned_v<Whole>) {
    std::strtoull(text.c_str(), nullptr, 0);
  } else {
    std::strtoll(text.c_str(), nullptr, 0);
  }
  const bool is_below = !kMayBeNegative && text.find('-') != std::string::npos;
  if (!text.empty() && errno != ERANGE && !is_below) return "";
  return fmt::format("found '{}', expected a whole number from {} to {}", text, kLeast, kMost);
}

// Before other checks of the option.
template <typename Value>
void check_value(CLI::Option& option, const Value&) {
  if constexpr (std::is_arithmetic_v<Value>) {
    option.check([](const std::string& text) { return trouble_with(text, Value{}); });
  } else {
    option.check([](const std::string& text) {
      return text.empty() ? "nothing given: leave it out, or say what is meant" : std::string();
    });
  }
}

template <typename Value>
void check_value(CLI::Option& option, const std::optional<Value>&) {
  check_value(option, Value{});
}

}  // namespace

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
    CLI::Option* option = app_->add_option(names, value, help);                                \
    check_value(*option, value);                                                               \
    return Option(option);                                                                     \
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

bool Command::has_chosen_subcommand() const {
  return !app_->get_subcommands().empty();
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
  if (!subcommand_names(app).empty()) add_help(app);
  try {
    // CLI11 takes the arguments last to first.
    app.parse(std::vector<std::string>(arguments.rbegin(), arguments.rend()));
  } catch (const CLI::ParseError& error) {
    const std::string unknown = error.get_exit_code() == 0 ? "" : unknown_word(app);
    if (!unknown.empty()) throw UsageError(unknown + "\nRun with --help for more information.");
    std::ostringstream help_text, error_text;
    const int code = app.exit(error, help_text, error_text);
    std::fputs(help_text.str().c_str(), stdout);
    std::fputs(shown_lines(error_text.str()).c_str(), stderr);  // It repeats what was given.
    return code == 0 ? 0 : 2;
  }
  return 0;
}

std::vector<std::string> split_words(const std::string& text) {
  return CLI::detail::split_up(text);
}

}  // namespace seam::app
