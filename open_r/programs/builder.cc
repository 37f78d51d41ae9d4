#include "open_r/programs/builder.h"

#include <algorithm>
#include <fstream>
#include <set>
#include <sstream>

#include "open_r/files/fault.h"
#include "open_r/files/stub_settings.h"

namespace seam::open_r {
namespace {

namespace fs = std::filesystem;

constexpr size_t kMostLines = 30;  // Of a compiler's words, for one file.

std::string read_text(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  std::ostringstream text;
  text << stream.rdbuf();
  return text.str();
}

void write_text(const fs::path& file, const std::string& text) {
  std::ofstream stream(file, std::ios::binary);
  stream << text;
  if (!stream.flush()) throw Fault(file.string() + ": cannot be written");
}

std::string first_lines(const std::string& text) {
  std::istringstream stream(text);
  std::string lines;
  size_t count = 0;
  for (std::string line; std::getline(stream, line) && count < kMostLines; ++count)
    lines += "  " + line + "\n";
  return lines;
}

class ObjectBuild {
 public:
  ObjectBuild(const ObjectPlan& plan, const Toolchain& tools, fs::path folder,
              const std::function<void(const std::string&)>& say)
      : plan_(plan), tools_(tools), folder_(std::move(folder)), say_(say) {}

  bool build(const fs::path& result) {
    fs::create_directories(folder_);
    std::vector<SourceFile> sources = plan_.sources;
    if (!plan_.stub_settings.empty() && !write_stub(sources)) return false;
    bool whole = true;
    std::vector<fs::path> objects;
    for (const SourceFile& source : sources) {
      const fs::path object =
          folder_ / (std::to_string(objects.size()) + "_" + source.file.stem().string() + ".o");
      objects.push_back(object);
      whole =
          call(compile_command(tools_, source.file, source.flags, object), source.file.string()) &&
          whole;
    }
    return whole && call(link_command(tools_, objects, plan_.libraries, result), plan_.name);
  }

 private:
  bool write_stub(std::vector<SourceFile>& sources) {
    const StubSettings stub =
        read_stub_settings(plan_.stub_settings.string(), read_text(plan_.stub_settings));
    write_text(folder_ / "def.h", definitions_header(stub));
    write_text(folder_ / "entry.h", entries_header(stub));
    const fs::path source = folder_ / (stub.object + "Stub.cc");
    // One that was written by hand stays.
    const bool by_hand = std::any_of(sources.begin(), sources.end(), [&](const SourceFile& s) {
      return s.file.filename() == source.filename();
    });
    if (by_hand) return true;
    write_text(source, stub_source(stub));
    std::vector<std::string> flags{"-I" + plan_.folder.string()};
    if (!sources.empty())
      flags.insert(flags.end(), sources.front().flags.begin(), sources.front().flags.end());
    sources.push_back({source, flags});
    return true;
  }

  bool call(const std::vector<std::string>& command, const std::string& what) {
    const CompilerResult result = run_program(command);
    if (result.code == 0) return true;
    say_(what + ": the compiler refuses it:\n" + first_lines(result.output));
    for (const std::string& lack : lacks(result.output)) say_(what + " lacks " + lack);
    return false;
  }

  const ObjectPlan& plan_;
  const Toolchain& tools_;
  fs::path folder_;
  const std::function<void(const std::string&)>& say_;
};

}  // namespace

BuildReport build_program(const ProgramPlan& plan, const Toolchain& tools, const fs::path& out,
                          const std::function<void(const std::string&)>& say) {
  const fs::path stick = out / "MS", objects = stick / "OPEN-R" / "MW" / "OBJS";
  fs::create_directories(out);
  fs::copy(plan.stick, stick, fs::copy_options::recursive | fs::copy_options::overwrite_existing);
  fs::create_directories(objects);
  BuildReport report;
  const std::vector<const ObjectPlan*> made = assign_objects(plan);
  for (size_t i = 0; i < plan.wanted.size(); ++i) {
    const std::string& file = plan.wanted[i];
    // A stick that already holds it for a MIPS processor: it cannot be run here.
    fs::remove(objects / file);
    if (made[i] == nullptr) {
      report.missing.push_back(file);
      say("OBJECT.CFG names " + file + ", which no folder makes: give its folder, too");
      continue;
    }
    const ObjectPlan& object = *made[i];
    if (ObjectBuild(object, tools, out / "objects" / object.name, say).build(objects / file)) {
      ++report.built;
      say(file + " from " + object.folder.string());
    } else {
      report.failed.push_back(object.name);
    }
  }
  return report;
}

}  // namespace seam::open_r
