#include "app/bundle/behaviour_files.h"

#include <algorithm>
#include <cstdlib>
#include <sstream>

#include "app/bundle/python_imports.h"
#include "app/session/behaviours.h"
#include "sim_core/base/error.h"
#include "sim_core/base/files.h"
#include "sim_core/system/own_files.h"

namespace seam::app {
namespace {

namespace fs = std::filesystem;

constexpr uint64_t kMostScriptBytes = 16 << 20;

bool is_below(const fs::path& folder, const fs::path& path) {
  const auto [in_folder, in_path] =
      std::mismatch(folder.begin(), folder.end(), path.begin(), path.end());
  return in_folder == folder.end();
}

// Of Debian, which anybody can install by a package's name.
bool is_of_system(const fs::path& program) {
  return is_below("/usr/bin", program) || is_below("/bin", program) ||
         is_below("/usr/sbin", program);
}

// The interpreter of a script's first line, and of `env` the program that it is to find.
std::vector<std::string> interpreter_of(const std::string& text) {
  std::vector<std::string> words;
  if (!text.starts_with("#!")) return words;
  std::istringstream line(text.substr(2, text.find('\n') - 2));
  for (std::string word; line >> word;) words.push_back(word);
  if (!words.empty() && fs::path(words[0]).filename() == "env") words.erase(words.begin());
  return words;
}

}  // namespace

BehaviourFiles::BehaviourFiles(const fs::path& working_folder)
    : here_(fs::canonical(working_folder)) {
  if (const char* path = std::getenv("PYTHONPATH"); path != nullptr && *path != '\0')
    needs_.insert(
        fmt::format("PYTHONPATH is set here ({}): modules there are not in the bundle", path));
}

// Its name in the folder `work`: where it is below the working folder as it is, else in a folder
// for each folder that files come from, so that modules stay beside their scripts.
std::string BehaviourFiles::take(const fs::path& file) {
  const fs::path whole = fs::absolute(file).lexically_normal();
  std::string name;
  if (is_below(here_, whole)) {
    name = whole.lexically_relative(here_).string();
  } else {
    const auto [at, is_new] = outside_.try_emplace(whole.parent_path(), "");
    if (is_new) at->second = fmt::format("outside/{}", outside_.size());
    name = at->second + "/" + whole.filename().string();
  }
  files_.emplace(name, whole);
  return name;
}

void BehaviourFiles::take_folder(const fs::path& folder) {
  for (auto at = fs::recursive_directory_iterator(folder); at != fs::end(at); ++at) {
    if (at->path().filename() == "__pycache__")
      at.disable_recursion_pending();
    else if (at->is_regular_file())
      take(at->path());
  }
}

void BehaviourFiles::add(const fs::path& path) {
  if (!is_below(here_, fs::absolute(path).lexically_normal()))
    throw InputError(
        fmt::format("--with {}: found a place outside the working folder, expected one below it",
                    path.string()));
  if (fs::is_directory(path)) return take_folder(path);
  if (!fs::is_regular_file(path))
    throw InputError(fmt::format("--with {}: found no such file or folder", path.string()));
  take(path);
}

void BehaviourFiles::take_word(const std::string& word, const std::string& robot) {
  std::error_code unknown;
  const std::string path = word.starts_with('-') && word.find('=') != std::string::npos
                               ? word.substr(word.find('=') + 1)
                               : word;
  if (fs::is_regular_file(path, unknown)) {
    const std::string name = "./" + take(path);
    const bool same = fs::path(path).is_relative() &&
                      fs::path(path).lexically_normal() == fs::path(name).lexically_normal();
    if (!same) words_[word] = word.substr(0, word.size() - path.size()) + name;
    if (path.ends_with(".py")) look_into(path, robot);
  } else if (path.find('/') != std::string::npos && fs::is_directory(path, unknown)) {
    needs_.insert(
        fmt::format("{}: its command names the folder '{}', which is not in the bundle: "
                    "--with takes folders along",
                    robot, path));
  }
}

void BehaviourFiles::add_command(const std::vector<std::string>& command,
                                 const std::string& robot) {
  const fs::path program = find_behaviour(command[0], robot);
  if (command[0].find('/') != std::string::npos) {
    take_word(command[0], robot);
    look_into(program, robot);
  } else if (!is_below(behaviours_folder(), program)) {
    needs_.insert(fmt::format("{}: starts '{}' from PATH ({}), which must be there", robot,
                              command[0], program.string()));
  }
  for (size_t i = 1; i < command.size(); ++i) take_word(command[i], robot);
}

void BehaviourFiles::look_into(const fs::path& program, const std::string& robot) {
  const std::string text = read_file(program);
  const std::string who = fmt::format("{}: {}", robot, program.filename().string());
  if (text.starts_with("\x7f"
                       "ELF")) {
    needs_.insert(
        who +
        " is a compiled program: it runs on machines of this kind alone, with the "
        "libraries that it was linked to, and its source is in the bundle only by --with");
    return;
  }
  const std::vector<std::string> words = interpreter_of(text);
  if (!words.empty() && words[0].find('/') != std::string::npos && !is_of_system(words[0])) {
    std::error_code unknown;
    const bool is_virtual =
        fs::exists(fs::path(words[0]).parent_path().parent_path() / "pyvenv.cfg", unknown);
    needs_.insert(fmt::format("{} is run by {}{}, which must be there", who, words[0],
                              is_virtual ? ", of a virtual environment" : ""));
  }
  if (const char* path = std::getenv("VIRTUAL_ENV"); path != nullptr && !words.empty())
    needs_.insert(
        fmt::format("a virtual environment is active here ({}): what is installed in it "
                    "is not in the bundle",
                    path));
  const bool python = program.extension() == ".py" ||
                      std::any_of(words.begin(), words.end(), [](const std::string& word) {
                        return fs::path(word).filename().string().starts_with("python");
                      });
  if (python) look_at_imports(program, who);
}

// Modules that stand beside the script come along, with what they import.
void BehaviourFiles::look_at_imports(const fs::path& script, const std::string& who) {
  const fs::path beside = script.parent_path();
  std::set<fs::path> seen;
  std::vector<fs::path> ahead = {script};
  while (!ahead.empty()) {
    const fs::path file = ahead.back();
    ahead.pop_back();
    if (!seen.insert(file).second) continue;
    for (const std::string& module : imported_modules(read_file(file, kMostScriptBytes))) {
      std::error_code unknown;
      const fs::path own = beside / (module + ".py"), package = beside / module;
      if (fs::is_regular_file(own, unknown)) {
        take(own);
        ahead.push_back(own);
      } else if (fs::exists(package / "__init__.py", unknown)) {
        take_folder(package);
        for (const auto& entry : fs::recursive_directory_iterator(package))
          if (entry.path().extension() == ".py") ahead.push_back(entry.path());
      } else if (const ModulePlace found = place_of_module(module); !found.of_python) {
        needs_.insert(fmt::format(
            "{} imports '{}', which {}", who, module,
            found.path.empty() ? "is neither beside it nor among Debian's packages"
                               : fmt::format("must be installed (here it is in {})", found.path)));
      }
    }
  }
}

}  // namespace seam::app
