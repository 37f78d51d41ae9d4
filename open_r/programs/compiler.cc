#include "open_r/programs/compiler.h"

#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cstring>
#include <sstream>

#include "open_r/files/fault.h"

extern char** environ;  // NOLINT: POSIX's name.

namespace seam::open_r {
namespace {

bool is_c(const std::filesystem::path& source) {
  return source.extension() == ".c";
}

}  // namespace

CompilerResult run_program(const std::vector<std::string>& command) {
  int ends[2];
  if (pipe(ends) != 0) throw Fault("no pipe: " + std::string(std::strerror(errno)));
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, ends[1], STDOUT_FILENO);
  posix_spawn_file_actions_adddup2(&actions, ends[1], STDERR_FILENO);
  posix_spawn_file_actions_addclose(&actions, ends[0]);
  std::vector<char*> arguments;
  for (const std::string& word : command) arguments.push_back(const_cast<char*>(word.c_str()));
  arguments.push_back(nullptr);
  pid_t child = 0;
  const int error =
      posix_spawnp(&child, arguments[0], &actions, nullptr, arguments.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  close(ends[1]);
  if (error != 0) {
    close(ends[0]);
    throw Fault(command[0] + ": cannot be started: " + std::strerror(error) +
                ". Name a compiler: --compiler g++");
  }
  CompilerResult result;
  char buffer[4096];
  for (ssize_t size; (size = read(ends[0], buffer, sizeof buffer)) > 0;)
    result.output.append(buffer, static_cast<size_t>(size));
  close(ends[0]);
  int status = 0;
  waitpid(child, &status, 0);
  result.code = WIFEXITED(status) ? WEXITSTATUS(status) : 1;
  return result;
}

std::vector<std::string> compile_command(const Toolchain& tools,
                                         const std::filesystem::path& source,
                                         const std::vector<std::string>& flags,
                                         const std::filesystem::path& object) {
  std::vector<std::string> command{is_c(source) ? tools.cc : tools.cxx};
  // C++ of that time; warnings are the user's own business. Objects of one process must not share
  // statics of templates, which GNU's unique symbols would do.
  if (!is_c(source))
    for (const char* flag : {"-std=gnu++98", "-fpermissive", "-fno-gnu-unique"})
      command.emplace_back(flag);
  for (const char* flag : {"-w", "-O2", "-g", "-fPIC", "-fno-strict-aliasing", "-ffp-contract=off"})
    command.emplace_back(flag);
  // Their own folder first: def.h and entry.h are there.
  command.push_back("-I" + object.parent_path().string());
  command.push_back("-I" + source.parent_path().string());
  command.insert(command.end(), flags.begin(), flags.end());
  for (const char* room : {"system", "objects", "robot", "network"})
    command.push_back("-isystem" + (tools.headers / room).string());
  for (const std::string& word :
       {std::string("-c"), source.string(), std::string("-o"), object.string()})
    command.push_back(word);
  return command;
}

std::vector<std::string> link_command(const Toolchain& tools,
                                      const std::vector<std::filesystem::path>& objects,
                                      const std::vector<std::string>& libraries,
                                      const std::filesystem::path& result) {
  std::vector<std::string> command{tools.cxx, "-shared", "-Wl,-Bsymbolic"};
  // Calls of the C library that mean the memory stick or the robot's clock (robot/stick_calls.cc).
  command.push_back("-Wl,@" + (tools.headers / "link_options").string());
  for (const std::filesystem::path& object : objects) command.push_back(object.string());
  for (const std::string& library : libraries) command.push_back("-l" + library);
  command.emplace_back("-o");
  command.push_back(result.string());
  return command;
}

namespace {

// What stands between two texts in a line, or from the first to the line's end.
struct Known {
  std::string_view begin, end;
  std::string_view before, after;  // Around it, for people.
};

constexpr std::string_view kRepeated =
    ": g++ refuses a name that is declared twice, such as two parameters; rename one";
constexpr Known kKnown[] = {
    {"fatal error: ", ": No such file", "the header ", ""},
    {"#error \"", "\"", "", ""},
    {"cannot find -l", ":", "the library ", ": install it, or give its folder"},
    {"error: redefinition of '", "'", "one meaning of ", kRepeated},
    {"error: conflicting types for '", "'", "one meaning of ",
     ": a library of this machine has that name, too; rename it"},
    {"error: '", "' should have been declared inside '::'", "the name ",
     ": g++ refuses '::' before a name that it has not seen; leave '::' out"},
    {"error: need 'typename' before '", "' because", "the word typename before ", ": write it"},
    {"declared with attribute error: ", "", "", ""},
    {"declared with 'error' attribute: ", "", "", ""},
    {"error: '", "' was not declared", "the name ", ""},
    {"error: '", "' has not been declared", "the name ", ""},
    {"error: '", "' does not name a type", "the name ", ""},
    {" has no member named '", "'", "the member ", ""},
    {"Error: no such instruction", "", "a MIPS processor", ""},
    {"Error: unknown mnemonic", "", "a MIPS processor", ""},
    {"Error: bad register", "", "a MIPS processor", ""},
};

// Compilers quote as the locale likes it.
std::string with_plain_quotes(std::string text) {
  for (const char* quote : {"\xe2\x80\x98", "\xe2\x80\x99"})
    for (size_t at; (at = text.find(quote)) != std::string::npos;) text.replace(at, 3, "'");
  return text;
}

}  // namespace

std::vector<std::string> lacks(const std::string& output) {
  std::istringstream lines(with_plain_quotes(output));
  std::vector<std::string> found;
  for (std::string line; std::getline(lines, line);) {
    for (const Known& known : kKnown) {
      const size_t at = line.find(known.begin);
      if (at == std::string::npos) continue;
      const size_t begin = at + known.begin.size();
      const size_t end = known.end.empty() ? line.size() : line.find(known.end, begin);
      if (end == std::string::npos) continue;
      const std::string lack =
          std::string(known.before) + line.substr(begin, end - begin) + std::string(known.after);
      if (std::find(found.begin(), found.end(), lack) == found.end()) found.push_back(lack);
    }
  }
  return found;
}

}  // namespace seam::open_r
