#include "open_r/programs/builder.h"

#include <algorithm>
#include <fstream>
#include <sstream>

#include "open_r/files/fault.h"
#include "open_r/files/memory_stick.h"
#include "open_r/files/stub_settings.h"
#include "open_r/files/text_file.h"

namespace seam::open_r {
namespace {

namespace fs = std::filesystem;

constexpr size_t kMostLines = 30;  // Of a compiler's words, for one file.

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

// Links lead to files of this stick alone: what else a user can read is not the program's.
void check_link(const fs::path& link, const fs::path& stick) {
  std::error_code error;
  const fs::path target = fs::canonical(link, error);
  if (error || !lies_in(target, stick))
    throw Fault(link.string() + ": a link that leaves the stick, expected the file itself");
  if (!fs::is_regular_file(target))
    throw Fault(link.string() + ": a link to no file, expected what it leads to");
}

// The stick without the files that are to be built: those that it holds are for a MIPS processor,
// and may not take the place of what was built before.
void copy_stick(const ProgramPlan& plan, const fs::path& stick) {
  const fs::path from = fs::canonical(plan.stick);
  const auto is_wanted = [&](const fs::path& file) {
    return file.parent_path().filename() == "OBJS" &&
           std::any_of(plan.wanted.begin(), plan.wanted.end(), [&](const std::string& wanted) {
             return same_name(wanted, file.filename().string());
           });
  };
  for (const auto& entry : fs::recursive_directory_iterator(from)) {
    const fs::path to = stick / entry.path().lexically_relative(from);
    std::error_code error;
    if (entry.is_symlink()) check_link(entry.path(), from);
    if (entry.is_directory())
      fs::create_directories(to, error);
    else if (!entry.is_regular_file())
      throw Fault(entry.path().string() + ": a pipe, socket or device, expected a file");
    else if (!is_wanted(entry.path()))
      fs::copy_file(entry.path(), to, fs::copy_options::overwrite_existing, error);
    if (error)
      throw Fault(entry.path().string() + ": cannot be copied to " + to.string() + ": " +
                  error.message());
  }
}

// A copy into itself has no end.
void check_out(const fs::path& out, const fs::path& stick) {
  const fs::path from = fs::canonical(stick), to = fs::weakly_canonical(fs::absolute(out));
  if (lies_in(to, from) || lies_in(from, to / "MS"))
    throw Fault(out.string() + ": its stick would be that of the program, " + from.string() +
                ", or lie in it: give another folder by --out");
}

}  // namespace

BuildReport build_program(const ProgramPlan& plan, const Toolchain& tools, const fs::path& out,
                          const std::function<void(const std::string&)>& say) {
  const fs::path stick = out / "MS", objects = stick / "OPEN-R" / "MW" / "OBJS";
  check_out(out, plan.stick);
  fs::create_directories(objects);
  write_text(out / kBuildMark, "Made by `seam open-r build`.\n");
  copy_stick(plan, stick);
  BuildReport report;
  const std::vector<const ObjectPlan*> made = assign_objects(plan);
  for (size_t i = 0; i < plan.wanted.size(); ++i) {
    const std::string& file = plan.wanted[i];
    if (made[i] == nullptr) {
      report.missing.push_back(file);
      say("OBJECT.CFG names " + file + ", which no folder makes: give its folder, too");
      continue;
    }
    const ObjectPlan& object = *made[i];
    // What was built before stays until this is whole.
    const fs::path made_file = out / "objects" / object.name / "whole.BIN";
    if (ObjectBuild(object, tools, made_file.parent_path(), say).build(made_file)) {
      fs::rename(made_file, objects / file);
      ++report.built;
      say(file + " from " + object.folder.string());
    } else {
      report.failed.push_back(object.name);
    }
  }
  return report;
}

}  // namespace seam::open_r
