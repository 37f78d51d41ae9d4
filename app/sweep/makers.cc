#include "app/sweep/makers.h"

#include <filesystem>
#include <sstream>

#include "app/session/behaviours.h"
#include "sim_core/base/error.h"
#include "sim_core/base/files.h"
#include "sim_core/base/hash.h"

namespace seam::app {
namespace {

std::string print_of_text(std::string_view text) {
  Hasher hasher;
  hasher.add(text);
  return to_hex(hasher.digest());
}

std::string read_whole(const char* file) {
  std::string text;
  if (FILE* stream = std::fopen(file, "rb")) {
    char buffer[4096];
    for (size_t n; (n = std::fread(buffer, 1, sizeof buffer, stream)) > 0;) text.append(buffer, n);
    std::fclose(stream);
  }
  return text;
}

// Plugins that this program was started with: their effects are part of it.
std::vector<std::string> plugins() {
  std::vector<std::string> words, files;
  std::istringstream line(read_whole("/proc/self/cmdline"));
  for (std::string word; std::getline(line, word, '\0');) words.push_back(word);
  for (size_t i = 0; i < words.size(); ++i) {
    if (words[i].starts_with("--plugin=")) files.push_back(words[i].substr(9));
    if (words[i] == "--plugin" && i + 1 < words.size()) files.push_back(words[i + 1]);
  }
  return files;
}

}  // namespace

const std::string& ProgramPrints::print_of(const std::string& file) {
  std::string& print = prints_[file];
  if (print.empty()) print = print_of_text(read_file(file));
  return print;
}

std::string ProgramPrints::of(const std::vector<std::string>& command, const std::string& robot) {
  std::string all;
  for (size_t i = 0; i < command.size(); ++i) {
    std::error_code unknown;
    if (i == 0)
      all += print_of(find_behaviour(command[0], robot));
    else if (std::filesystem::is_regular_file(command[i], unknown))
      all += print_of(command[i]);
  }
  return print_of_text(all);
}

std::string program_print(ProgramPrints& prints) {
  std::string program = prints.print_of("/proc/self/exe");
  for (const std::string& plugin : plugins()) program += prints.print_of(plugin);
  return print_of_text(program);
}

Makers makers_of(const SweepPlan& plan, ProgramPrints& prints) {
  std::string behaviours;
  for (const auto& [command, robot] : plan.commands()) behaviours += prints.of(command, robot);
  return {SEAM_VERSION, program_print(prints), print_of_text(behaviours)};
}

std::vector<std::string> made_by(const SweepPlan& plan, const Makers& makers) {
  const PlanTexts& texts = plan.texts();
  std::vector<std::string> all = {texts.plan, texts.scenario, makers.behaviours};
  for (const auto& [name, text] : texts.files) all.insert(all.end(), {name, text});
  return all;
}

}  // namespace seam::app
