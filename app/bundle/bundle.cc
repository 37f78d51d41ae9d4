#include "app/bundle/bundle.h"

#include <cstdio>
#include <map>
#include <memory>
#include <set>

#include "app/bundle/archive.h"
#include "app/bundle/behaviour_files.h"
#include "app/bundle/sha256.h"
#include "app/scratch_folder.h"
#include "app/simulator.h"
#include "app/sweep/makers.h"
#include "app/sweep/results.h"
#include "app/sweep/sweep.h"
#include "render/assets/assets.h"
#include "scheduler/log/log.h"
#include "sim_core/base/error.h"
#include "sim_core/base/output.h"

namespace seam::app {
namespace {

namespace fs = std::filesystem;

constexpr const char* kReadme =
    "This archive repeats the runs of a study with SEAM, or says which of them differ:\n\n"
    "    seam sweep rerun THIS_ARCHIVE --run-programs\n\n"
    "manifest.json lists the files with their SHA-256 and what must be installed beside them.\n"
    "plan.yaml and scenario.yaml are for reading; results.sqlite holds both, the files that they\n"
    "name, and the values and the fingerprint of each run. work/ is the folder in which the\n"
    "behaviours are started; logs/ holds what was recorded.\n";

void each_piece(const fs::path& file, const std::function<void(std::string_view)>& take) {
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> in(
      fs::is_regular_file(file) ? std::fopen(file.c_str(), "rb") : nullptr, &std::fclose);
  if (!in) throw InputError(fmt::format("{}: cannot be read", file.string()));
  std::string piece(size_t{1} << 20, '\0');
  for (size_t n; (n = std::fread(piece.data(), 1, piece.size(), in.get())) > 0;)
    take(std::string_view(piece).substr(0, n));
  if (std::ferror(in.get()) != 0)
    throw InputError(fmt::format("{}: cannot be read", file.string()));
}

bool is_executable(const fs::path& file) {
  return (fs::status(file).permissions() & fs::perms::owner_exec) != fs::perms::none;
}

// The files of an archive in the making, by their names in it.
class Contents {
 public:
  explicit Contents(const fs::path& scratch) : scratch_(scratch) {}

  void add(const std::string& name, const fs::path& file) { files_.emplace(name, file); }
  void add_text(const std::string& name, const std::string& text) {
    const fs::path file = scratch_ / fmt::format("text-{}", files_.size());
    write_file_atomically(file, text);
    add(name, file);
  }
  // With their sizes and checksums. Throws InputError where they are too much for a bundle.
  std::vector<BundleFile> listed() const {
    std::vector<BundleFile> list;
    uint64_t sum = 0;
    for (const auto& [name, file] : files_) {
      if (const std::string why = why_no_archive_name(name); !why.empty()) throw InputError(why);
      Sha256 digest;
      BundleFile entry{.name = name, .program = is_executable(file)};
      each_piece(file, [&](std::string_view piece) {
        digest.add(piece);
        entry.bytes += piece.size();
      });
      entry.sha256 = digest.digest();
      sum += entry.bytes;
      list.push_back(std::move(entry));
    }
    if (sum > kMostBundleBytes || list.size() > kMostBundleFiles)
      throw InputError(fmt::format(
          "found {} MB in {} files, expected at most {} MB in {}: leave logs out (--no-logs), or "
          "make bundles of parts",
          sum >> 20, list.size(), kMostBundleBytes >> 20, kMostBundleFiles));
    return list;
  }
  void write(const BundleManifest& manifest, OutputFile& out) const {
    ArchiveWriter archive(out);
    const std::string head = manifest.to_text();
    archive.begin(kManifestName, head.size(), false);
    archive.write(head);
    archive.end();
    for (const BundleFile& entry : manifest.files) {
      archive.begin(entry.name, entry.bytes, entry.program);
      Sha256 digest;
      each_piece(files_.at(entry.name), [&](std::string_view piece) {
        digest.add(piece);
        archive.write(piece);
      });
      archive.end();
      if (digest.digest() != entry.sha256)
        throw InputError(fmt::format("{}: it changed while it was read: run this again",
                                     files_.at(entry.name).string()));
    }
    archive.finish();
  }

 private:
  fs::path scratch_;
  std::map<std::string, fs::path> files_;
};

// The meshes and textures of scenarios, with the files that they name.
class SceneFolders {
 public:
  void add(const Scenario& scenario, Contents& contents) {
    for (const ObjectSpec& object : scenario.objects) {
      add_mesh(object.mesh, object.scale, contents);
      if (!object.texture.name.empty()) take(object.texture, object.texture.name, contents);
    }
    for (const RobotSpec& robot : scenario.robots)
      for (const BodyPart& part : robot.body.parts) add_mesh(part.mesh, part.scale, contents);
  }
  const std::map<std::string, std::string>& names() const { return names_; }

 private:
  void add_mesh(const FileName& mesh, double scale, Contents& contents) {
    if (mesh.name.empty() || !seen_.insert(mesh.folder + '\n' + mesh.name).second) return;
    for (const std::string& name : render::read_mesh(mesh, scale).files) take(mesh, name, contents);
  }
  void take(const FileName& of, const std::string& name, Contents& contents) {
    const auto [at, is_new] = names_.try_emplace(of.folder, "");
    if (is_new) at->second = fmt::format("scene/{}", names_.size());
    contents.add(at->second + "/" + fs::path(name).lexically_normal().string(),
                 fs::path(of.folder) / name);
  }

  std::map<std::string, std::string> names_;  // By folder.
  std::set<std::string> seen_;
};

// All of a bundle in the making.
struct Making {
  const BundleOptions& options;
  Contents contents;
  BehaviourFiles behaviours{"."};
  SceneFolders scene;
  std::set<std::string> needs = {};
  std::set<std::vector<std::string>> commands = {};

  void add_scenario(const Scenario& scenario) {
    for (const RobotSpec& robot : scenario.robots)
      if (const auto& command = robot.behaviour.command; !command.empty())
        if (commands.insert(command).second) behaviours.add_command(command, robot.id);
    scene.add(scenario, contents);
    if (scene.names().empty() || !needs.empty()) return;
    for (const auto& [name, version] : make_simulator(scenario).header.versions)
      if (name == "opengl")
        needs.insert(fmt::format(
            "frames with meshes or textures are drawn by OpenGL: their bits are those of {}",
            version));
  }
};

// A clean copy: one file, with nothing in it but the rows.
void add_results(Making& making, const fs::path& scratch) {
  const auto results = ResultsFile::for_reading(making.options.source);
  const SweepPlan& plan = results.plan();
  auto copy =
      ResultsFile::for_writing(scratch / "results.sqlite", plan, results.makers(), results.shard());
  copy.take_over(results);
  copy.close();
  making.contents.add("results.sqlite", scratch / "results.sqlite");
  making.contents.add_text("plan.yaml", plan.texts().plan);
  making.contents.add_text("scenario.yaml", plan.texts().scenario);
  for (const uint64_t run : plan.runs_of_words()) making.add_scenario(plan.scenario(run));
  if (!plan.keep().logs || !making.options.logs) return;
  results.each([&](const RunRecord& record) {
    const std::string name = fmt::format("run_{:06}.mcap", record.run);
    if (!record.failed())
      making.contents.add("logs/" + name, run_files(making.options.source) / name);
  });
}

void add_log(Making& making) {
  const scheduler::Log log = scheduler::Log::open(making.options.source);
  if (!log.end())
    throw InputError(fmt::format(
        "{}: the run did not reach its end, expected a whole log: seam replay resume finishes it",
        making.options.source.string()));
  const scheduler::RunHeader& header = log.header();
  const Scenario scenario = Scenario::from_made_text(header.scenario_text, header.scenario_name);
  making.contents.add("logs/run.mcap", making.options.source);
  making.contents.add_text("scenario.yaml", header.scenario_text);
  making.add_scenario(scenario);
}

}  // namespace

bool is_log(const fs::path& file) {
  constexpr std::string_view kMagic("\x89MCAP", 5);
  char found[kMagic.size()] = {};
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> in(
      fs::is_regular_file(file) ? std::fopen(file.c_str(), "rb") : nullptr, &std::fclose);
  return in && std::fread(found, 1, sizeof found, in.get()) == sizeof found &&
         std::string_view(found, sizeof found) == kMagic;
}

BundleManifest make_bundle(const BundleOptions& options) {
  OutputFile out(options.out, {.inputs = {options.source}});
  const ScratchFolder scratch("bundle");
  Making making{.options = options, .contents = Contents(scratch.path())};
  const bool log = is_log(options.source);
  if (log)
    add_log(making);
  else
    add_results(making, scratch.path());
  for (const std::string& path : options.with) making.behaviours.add(path);
  for (const auto& [name, file] : making.behaviours.files())
    making.contents.add("work/" + name, file);
  making.contents.add_text("README.txt", kReadme);
  ProgramPrints prints;
  BundleManifest manifest{.version = SEAM_VERSION,
                          .program = program_print(prints),
                          .of = log ? "logs/run.mcap" : "results.sqlite",
                          .files = making.contents.listed(),
                          .folders = making.scene.names(),
                          .words = making.behaviours.words(),
                          .needs = {}};
  making.needs.insert(making.behaviours.needs().begin(), making.behaviours.needs().end());
  manifest.needs.assign(making.needs.begin(), making.needs.end());
  making.contents.write(manifest, out);
  out.commit();
  return manifest;
}

}  // namespace seam::app
