#include "open_r/programs/program_folder.h"

#include <algorithm>
#include <cctype>
#include <memory>
#include <set>

#include "open_r/files/fault.h"
#include "open_r/files/settings.h"
#include "open_r/files/text_file.h"
#include "open_r/programs/makefile.h"

namespace seam::open_r {
namespace {

namespace fs = std::filesystem;

const char* const kSourceEndings[] = {".cc", ".cpp", ".cxx", ".C", ".c", ".s", ".S"};
// Libraries of the robot's SDK: ours stands for them.
const std::set<std::string> kOwnLibraries = {"ObjectComm", "OPENR",  "Internet", "antMCOOP",
                                             "ERA201D1",   "cdtcmd", "m",        "c",
                                             "stdc++",     "OMWares"};

std::vector<fs::path> sorted_files(const fs::path& folder) {
  std::vector<fs::path> files;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(folder, error))
    if (entry.is_regular_file(error)) files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  return files;
}

fs::path makefile_of(const fs::path& folder) {
  for (const char* name : {"GNUmakefile", "makefile", "Makefile"})
    if (fs::is_regular_file(folder / name)) return folder / name;
  return {};
}

bool is_object_folder(const fs::path& folder) {
  const std::vector<fs::path> files = sorted_files(folder);
  return std::any_of(files.begin(), files.end(), [](const fs::path& file) {
    return file.filename() == "stub.cfg" || file.extension() == ".ocf";
  });
}

bool is_source(const fs::path& file) {
  return std::any_of(std::begin(kSourceEndings), std::end(kSourceEndings),
                     [&](const char* ending) { return file.extension() == ending; });
}

// A name that may become a folder's.
bool is_plain(const std::string& name) {
  return std::all_of(name.begin(), name.end(),
                     [](unsigned char c) { return std::isalnum(c) != 0 || c == '_'; });
}

// "object movingHead 3072 16384 128 cache tlb user"
std::string name_in_ocf(const fs::path& folder) {
  for (const fs::path& file : sorted_files(folder)) {
    if (file.extension() != ".ocf") continue;
    const std::vector<std::string> words = words_of(read_text(file));
    if (words.size() >= 2 && words[0] == "object" && is_plain(words[1])) return words[1];
  }
  return folder.filename().string();
}

// -I and -D of a Makefile, paths as they are from here.
std::vector<std::string> flags_of(const Makefile& makefile, const fs::path& folder) {
  std::vector<std::string> flags;
  for (const char* variable : {"CXXFLAGS", "CPPFLAGS", "CFLAGS", "INCLUDES", "DEFS"}) {
    for (const std::string& word : words_of(makefile.value(variable))) {
      if (word.starts_with("-D") && word.size() > 2) flags.push_back(word);
      if (!word.starts_with("-I") || word.size() == 2) continue;
      const fs::path path = folder / word.substr(2);
      if (fs::is_directory(path)) flags.push_back("-I" + fs::weakly_canonical(path).string());
    }
  }
  return flags;
}

// Folders named `include` in the program count for all its objects where no Makefile says so.
std::vector<std::string> common_includes(const fs::path& program) {
  std::vector<std::string> flags;
  std::error_code error;
  for (const auto& entry : fs::recursive_directory_iterator(program, error))
    if (entry.is_directory(error) && entry.path().filename() == "include")
      flags.push_back("-I" + entry.path().string());
  std::sort(flags.begin(), flags.end());
  return flags;
}

class ObjectReader {
 public:
  ObjectReader(fs::path folder, const fs::path& program,
               const std::map<std::string, std::string>& given)
      : folder_(std::move(folder)), program_(program), given_(given) {
    object_.folder = folder_;
    object_.name = name_in_ocf(folder_);
    if (fs::is_regular_file(folder_ / "stub.cfg")) object_.stub_settings = folder_ / "stub.cfg";
  }

  ObjectPlan read() {
    const fs::path file = makefile_of(folder_);
    if (!file.empty()) read_makefile(Makefile::read(file.string(), read_text(file), given_));
    if (object_.sources.empty()) take_all_sources();
    return object_;
  }

 private:
  void take_all_sources() {
    const std::vector<std::string> flags = common_includes(program_);
    for (const fs::path& file : sorted_files(folder_))
      if (is_source(file)) object_.sources.push_back({file, flags});
  }

  void read_makefile(const Makefile& makefile) {
    const std::vector<std::string> flags = flags_of(makefile, folder_);
    for (const MakeRule& rule : makefile.rules()) {
      const bool makes_object = rule.targets.size() == 1 && rule.targets[0].ends_with(".bin") &&
                                std::any_of(rule.prerequisites.begin(), rule.prerequisites.end(),
                                            [](const std::string& p) { return p.ends_with(".o"); });
      if (makes_object)
        for (const std::string& part : rule.prerequisites) take_part(part, flags);
      for (const std::string& command : rule.commands) take_command(rule, makefile, command);
    }
    for (const std::string& word : words_of(makefile.value("LIBS")))
      if (word.starts_with("-l") && !kOwnLibraries.contains(word.substr(2)))
        take_library("lib" + word.substr(2) + ".a", flags);
  }

  // "Brain.o": its source; "libMTN.a": the sources of that library.
  void take_part(const std::string& part, const std::vector<std::string>& flags) {
    const fs::path path = folder_ / part;
    if (path.extension() == ".a") return take_library(path, flags);
    if (path.extension() != ".o") return;
    for (const char* ending : kSourceEndings) {
      const fs::path source = fs::path(path).replace_extension(ending);
      if (!fs::is_regular_file(source)) continue;
      return take_source({fs::weakly_canonical(source), flags});
    }
  }

  // A Makefile may name it twice; what is linked twice has two of each function.
  void take_source(SourceFile source) {
    if (std::none_of(object_.sources.begin(), object_.sources.end(),
                     [&](const SourceFile& known) { return known.file == source.file; }))
      object_.sources.push_back(std::move(source));
  }

  void take_library(const fs::path& library, const std::vector<std::string>& flags) {
    const std::string stem = library.stem().string();
    const fs::path whole = fs::weakly_canonical(folder_ / library), folder = whole.parent_path();
    // Libraries may name each other.
    if (!libraries_->insert(whole).second) return;
    const fs::path file = makefile_of(folder);
    if (!file.empty() && folder != folder_) {
      const Makefile makefile = Makefile::read(file.string(), read_text(file), given_);
      ObjectReader inner(folder, program_, given_);
      inner.libraries_ = libraries_;
      for (const MakeRule& rule : makefile.rules())
        for (const std::string& target : rule.targets)
          if (fs::path(target).filename() == library.filename())
            for (const std::string& part : rule.prerequisites)
              inner.take_part(part, flags_of(makefile, folder));
      for (SourceFile& source : inner.object_.sources) {
        source.flags.insert(source.flags.end(), flags.begin(), flags.end());
        take_source(std::move(source));
      }
      if (!inner.object_.sources.empty()) return;
    }
    if (stem.starts_with("lib")) object_.libraries.push_back(stem.substr(3));
  }

  // "gzip -c movingHead.bin > ../MS/OPEN-R/MW/OBJS/MOVEHEAD.BIN"
  void take_command(const MakeRule& rule, const Makefile& makefile, const std::string& command) {
    std::string text = makefile.expand(command);
    std::string all;
    for (const std::string& p : rule.prerequisites) all += p + " ";
    for (const char* name : {"$^", "$<"})
      // What is put in may name it, too.
      for (size_t at = 0; (at = text.find(name, at)) != std::string::npos; at += all.size()) {
        text.replace(at, 2, all);
        if (text.size() > kMostTextBytes)
          throw Fault(folder_.string() + ": a command of the Makefile is longer than " +
                      std::to_string(kMostTextBytes) + " bytes");
      }
    if (text.starts_with("rm ") || text.find(".bin") == std::string::npos) return;
    for (const std::string& word : words_of(text))
      if (word.ends_with(".BIN")) object_.installed.push_back(fs::path(word).filename().string());
  }

  fs::path folder_, program_;
  const std::map<std::string, std::string>& given_;
  // Those that were read, or are just being read, for this object.
  std::shared_ptr<std::set<fs::path>> libraries_ = std::make_shared<std::set<fs::path>>();
  ObjectPlan object_;
};

// Folders of objects below a folder and, where its Makefile names them, beside it.
std::vector<fs::path> object_folders(const fs::path& folder,
                                     const std::map<std::string, std::string>& given) {
  std::set<fs::path> found;
  std::error_code error;
  if (is_object_folder(folder)) found.insert(folder);
  for (auto at = fs::recursive_directory_iterator(folder, error); at != fs::end(at); ++at) {
    if (!at->is_directory(error)) continue;
    const std::string name = at->path().filename().string();
    if (name.starts_with(".") || name == "MS" || at.depth() > 6)
      at.disable_recursion_pending();
    else if (is_object_folder(at->path()))
      found.insert(at->path());
  }
  if (const fs::path file = makefile_of(folder); !file.empty()) {
    const Makefile makefile = Makefile::read(file.string(), read_text(file), given);
    for (const auto& [name, value] : makefile.variables())
      for (const std::string& word : words_of(makefile.expand(value)))
        if (word.starts_with("..") && fs::is_directory(folder / word) &&
            is_object_folder(folder / word))
          found.insert(fs::weakly_canonical(folder / word));
  }
  return {found.begin(), found.end()};
}

// Whether a file lies on a stick that a build made.
bool is_built(const fs::path& file) {
  for (fs::path at = file; at != at.parent_path(); at = at.parent_path())
    if (at.filename() == "MS" && fs::exists(at.parent_path() / kBuildMark)) return true;
  return false;
}

fs::path find_stick(const fs::path& folder, const fs::path& out) {
  std::vector<fs::path> sticks;
  std::error_code error;
  for (const auto& entry : fs::recursive_directory_iterator(folder, error))
    if (entry.path().filename() == "OBJECT.CFG") sticks.push_back(entry.path());
  std::sort(sticks.begin(), sticks.end());
  const fs::path whole_out = fs::weakly_canonical(fs::absolute(out));
  if (sticks.size() > 1)
    std::erase_if(sticks, [&](const fs::path& file) {
      return is_built(file) || (lies_in(file, whole_out / "MS") && !lies_in(folder, whole_out));
    });
  if (sticks.empty()) return {};
  if (sticks.size() > 1)
    throw Fault(folder.string() + ": " + std::to_string(sticks.size()) +
                " files OBJECT.CFG, expected one program: give the folder of one, such as " +
                sticks[0].parent_path().string());
  // MS/OPEN-R/MW/CONF/OBJECT.CFG
  fs::path at = sticks[0].parent_path();
  for (const char* part : {"CONF", "MW", "OPEN-R"}) {
    if (at.filename() != part)
      throw Fault(sticks[0].string() + ": expected it in MS/OPEN-R/MW/CONF");
    at = at.parent_path();
  }
  return at;
}

std::string letters_of(const std::string& text) {
  std::string letters;
  for (const unsigned char c : text)
    if (std::isalnum(c) != 0) letters += static_cast<char>(std::toupper(c));
  return letters;
}

// The length of the longest sequence of letters that both have in their order.
size_t common_letters(const std::string& a, const std::string& b) {
  std::vector<size_t> row(b.size() + 1, 0);
  for (const char c : a) {
    size_t diagonal = 0;
    for (size_t j = 0; j < b.size(); ++j) {
      const size_t above = row[j + 1];
      row[j + 1] = c == b[j] ? diagonal + 1 : std::max(above, row[j]);
      diagonal = above;
    }
  }
  return row.back();
}

}  // namespace

bool lies_in(const fs::path& path, const fs::path& folder) {
  return std::mismatch(path.begin(), path.end(), folder.begin(), folder.end()).second ==
         folder.end();
}

ProgramPlan plan_program(const std::vector<fs::path>& folders, const std::string& design,
                         const std::map<std::string, std::string>& given, const fs::path& out) {
  ProgramPlan plan;
  plan.design = design;
  std::set<fs::path> seen;
  for (const fs::path& named : folders) {
    if (!fs::is_directory(named)) throw Fault(named.string() + ": no folder, expected a program's");
    const fs::path folder = fs::canonical(named);
    if (plan.stick.empty()) plan.stick = find_stick(folder, out);
    for (const fs::path& object : object_folders(folder, given))
      if (seen.insert(object).second)
        plan.objects.push_back(ObjectReader(object, folder, given).read());
  }
  if (plan.objects.empty())
    throw Fault(folders.front().string() +
                ": no object, expected folders with stub.cfg or NAME.ocf and sources");
  if (plan.stick.empty())
    throw Fault(folders.front().string() +
                ": no OBJECT.CFG, expected one in MS/OPEN-R/MW/CONF that names the objects");
  const std::string text = read_text(plan.stick / "OPEN-R" / "MW" / "CONF" / "OBJECT.CFG");
  for (const std::string& path : read_object_settings(text, design))
    plan.wanted.push_back(fs::path(path).filename().string());
  return plan;
}

// By the Makefile; where it says nothing, by the likeness of names: MVHEAD2 is movingHead2.
std::vector<const ObjectPlan*> assign_objects(const ProgramPlan& plan) {
  constexpr double kAlike = 0.7;
  std::vector<const ObjectPlan*> made(plan.wanted.size(), nullptr);
  std::set<const ObjectPlan*> used;
  for (size_t i = 0; i < plan.wanted.size(); ++i)
    for (const ObjectPlan& object : plan.objects) {
      const auto& names = object.installed;
      if (made[i] != nullptr ||
          std::find(names.begin(), names.end(), plan.wanted[i]) == names.end())
        continue;
      made[i] = &object;
      used.insert(&object);
    }
  struct Pair {
    double alike;
    size_t wanted;
    const ObjectPlan* object;
  };
  std::vector<Pair> pairs;
  for (size_t i = 0; i < plan.wanted.size(); ++i)
    for (const ObjectPlan& object : plan.objects) {
      if (made[i] != nullptr || !object.installed.empty()) continue;
      const std::string wanted = letters_of(fs::path(plan.wanted[i]).stem().string());
      const std::string name = letters_of(object.name);
      if (wanted.empty()) continue;
      pairs.push_back(
          {static_cast<double>(common_letters(wanted, name)) / static_cast<double>(wanted.size()) -
               1e-3 * static_cast<double>(name.size()),
           i, &object});
    }
  std::stable_sort(pairs.begin(), pairs.end(),
                   [](const Pair& a, const Pair& b) { return a.alike > b.alike; });
  for (const Pair& pair : pairs) {
    if (pair.alike < kAlike || made[pair.wanted] != nullptr || used.contains(pair.object)) continue;
    made[pair.wanted] = pair.object;
    used.insert(pair.object);
  }
  // One object and one name are left, or the name is that of the robot.
  if (plan.objects.size() != used.size() + 1) return made;
  const auto rest = std::find_if(plan.objects.begin(), plan.objects.end(),
                                 [&](const ObjectPlan& o) { return !used.contains(&o); });
  const auto left = std::count(made.begin(), made.end(), nullptr);
  for (size_t i = 0; i < plan.wanted.size() && rest->installed.empty(); ++i)
    if (made[i] == nullptr && (left == 1 || fs::path(plan.wanted[i]).stem() == plan.design)) {
      made[i] = &*rest;
      break;
    }
  return made;
}

}  // namespace seam::open_r
