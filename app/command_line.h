// The command line of a program: commands with their options, help and examples. CLI11 does the
// work, behind this header because its own costs several seconds in each file that includes it.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <initializer_list>
#include <optional>
#include <string>
#include <vector>

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace seam::app {

// What an option asks of its value. Each call returns the option, for more calls.
class Option {
 public:
  explicit Option(CLI::Option* option) : option_(option) {}
  Option& required();
  Option& range(int min, int max);
  Option& range(double min, double max);
  Option& one_of(std::initializer_list<std::string> words);
  Option& count(int min, int max);                   // How many values a list takes.
  Option& environment(const std::string& variable);  // Where the line does not give the option.
  Option& show_default();  // The help names the value that the variable has now.

 private:
  CLI::Option* option_;
};

// A program or one of its subcommands: a handle, cheap to copy.
class Command {
 public:
  explicit Command(CLI::App* app) : app_(app) {}
  Command add_subcommand(const std::string& name, const std::string& help);
  // `names` is "--name", or "NAME" for an argument by its place. The variable is filled when the
  // line is parsed and must live until then; a text that is no such value is wrong use (exit code
  // 2). Of whole numbers, only `int` may be negative.
  Option add_option(const std::string& names, std::string& value, const std::string& help);
  Option add_option(const std::string& names, std::vector<std::string>& value,
                    const std::string& help);
  Option add_option(const std::string& names, std::filesystem::path& value,
                    const std::string& help);
  Option add_option(const std::string& names, int& value, const std::string& help);
  Option add_option(const std::string& names, uint64_t& value, const std::string& help);
  Option add_option(const std::string& names, std::optional<int64_t>& value,
                    const std::string& help);
  Option add_option(const std::string& names, double& value, const std::string& help);
  Option add_option(const std::string& names, std::optional<double>& value,
                    const std::string& help);
  Option add_flag(const std::string& names, bool& value, const std::string& help);
  Option add_flag(const std::string& names, std::function<void()> when_given,
                  const std::string& help);
  // One of the subcommands must be given.
  void require_subcommand();
  // After parsing: whether the line goes on to one of them.
  bool has_chosen_subcommand() const;
  // Text after the options in the help: exit codes, examples.
  void footer(const std::string& text);
  // What the command does, once the whole line is parsed.
  void callback(std::function<void()> action);

 private:
  CLI::App* app_;
};

// Parses the arguments (without the program's name) and runs the command named. A program with
// subcommands has `help` among them: the help of one, or with --markdown that of all as a page.
// Returns the program's exit code: 0 after help or version, 2 for wrong use; what the commands
// throw passes through. An unknown command or option throws UsageError with the nearest known one.
int parse_and_run(const std::string& help, const std::string& program, const std::string& version,
                  const std::vector<std::string>& arguments,
                  const std::function<void(Command)>& add_commands);

// A text as a shell would split it into words, quotes respected.
std::vector<std::string> split_words(const std::string& text);

}  // namespace seam::app
