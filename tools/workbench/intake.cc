#include "tools/workbench/intake.h"

#include <algorithm>

#include "app/data_file.h"
#include "app/import/import.h"
#include "app/import/recognise.h"
#include "measurement/sets/set.h"
#include "sim_core/base/error.h"
#include "sim_core/base/files.h"
#include "sim_core/base/output.h"
#include "tools/workbench/places.h"

namespace seam::tools {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

// Files of ours: what was done (a protocol), the model that makes the measurements, and the model
// that a person begins with.
struct Sample {
  const char* name;
  const char* protocol;
  const char* truth;
  const char* nominal;
};

constexpr Sample kSamples[] = {
    {"camera", "docs/tutorial/room", "docs/tutorial/robot.yaml", "docs/tutorial/nominal.yaml"},
    {"servo", "scenarios/samples/servo", "scenarios/samples/servo/robot.yaml",
     "scenarios/samples/servo/nominal.yaml"},
    {"flats", "scenarios/samples/flats", "scenarios/samples/flats/robot.yaml",
     "scenarios/samples/flats/nominal.yaml"},
    {"walk", "scenarios/samples/walk", "scenarios/samples/walk/robot.yaml",
     "scenarios/samples/walk/nominal.yaml"},
};

// A name that leads nowhere but below the folder that it is put into.
fs::path plain_name(const std::string& name) {
  fs::path plain;
  for (const fs::path& part : fs::path(name)) {
    const std::string text = part.string();
    const bool bad = text.empty() || text == "." || text == ".." || text == "/" ||
                     text.size() > 200 ||
                     std::ranges::any_of(text, [](unsigned char c) { return c < ' ' || c == 127; });
    if (bad) throw UsageError("files: expected plain names of files");
    plain /= part;
  }
  if (plain.empty()) throw UsageError("files: found one without a name");
  return plain;
}

// BESIDE/NAME, or the first of NAME-2, NAME-3, ... that is not there.
fs::path new_folder(const fs::path& beside, const std::string& name) {
  fs::path folder = beside / name;
  for (int i = 2; fs::exists(folder); ++i) folder = beside / fmt::format("{}-{}", name, i);
  return folder;
}

// What lies in the folder, sorted: files or folders of files.
std::vector<fs::path> sources_in(const fs::path& folder) {
  std::vector<fs::path> sources;
  for (const auto& entry : fs::directory_iterator(folder)) sources.push_back(entry.path());
  std::sort(sources.begin(), sources.end());
  return sources;
}

// A name for a set, after the first of its files.
std::string name_after(const fs::path& source) {
  return "set-" + name_in_files(source.stem().string().substr(0, 60));
}

}  // namespace

void Making::finish() const {
  const fs::path model = set / "nominal.yaml";
  if (!nominal.empty() && !fs::exists(model)) write_file_atomically(model, read_file(nominal));
  std::error_code not_linked;  // Then the page shows no pictures beneath the rows.
  if (!pictures.empty()) fs::create_directory_symlink(pictures, set / "pictures", not_linked);
}

Intake::Intake(fs::path beside) : beside_(std::move(beside)) {}

json Intake::samples() const {
  json list = json::array();
  for (const Sample& sample : kSamples) {
    try {
      const auto set = measurement::MeasurementSet::open(app::data_file(sample.protocol));
      list.push_back({{"name", sample.name},
                      {"path", "sample:" + std::string(sample.name)},
                      {"kind", set.kind},
                      {"title", set.title}});
    } catch (const InputError&) {  // The program was copied without its files.
    }
  }
  return list;
}

std::optional<Making> Intake::of_sample(const std::string& path) const {
  const auto found = std::ranges::find_if(
      kSamples, [&](const Sample& sample) { return path == "sample:" + std::string(sample.name); });
  if (found == std::end(kSamples)) return std::nullopt;
  Making making{.set = beside_ / fmt::format("sample-{}", found->name),
                .folder = beside_,
                .command = {},
                .nominal = fs::absolute(app::data_file(found->nominal)),
                .pictures = {}};
  if (!fs::exists(making.set / "measurement.yaml"))
    making.command = {"measure",
                      "--model",
                      fs::absolute(app::data_file(found->truth)),
                      "--protocol",
                      fs::absolute(app::data_file(found->protocol)),
                      "--seed",
                      "1",
                      "--out",
                      making.set.string()};
  return making;
}

json Intake::take_in(const httplib::MultipartFormDataMap& files) const {
  std::vector<std::pair<fs::path, const std::string*>> kept;
  for (const auto& [key, file] : files) kept.emplace_back(plain_name(file.filename), &file.content);
  if (kept.empty()) throw UsageError("files: found none");
  const fs::path folder = new_folder(beside_, "dropped");
  fs::path set;
  try {
    for (const auto& [name, content] : kept) {
      make_output_folder((folder / name).parent_path());
      write_file_atomically(folder / name, *content);
      if (name.filename() == "measurement.yaml") set = (folder / name).parent_path();
    }
  } catch (const InputError&) {
    std::error_code stays;
    fs::remove_all(folder, stays);
    throw;
  }
  if (!set.empty()) return {{"set", fs::canonical(set).string()}};
  const app::ImportKind* kind = app::import_that_reads(sources_in(folder));
  return {{"dropped", folder.filename().string()}, {"kind", kind ? kind->name : ""}};
}

Making Intake::of_dropped(const std::string& dropped, const std::string& kind,
                          const std::map<std::string, std::string>& options) const {
  const fs::path folder = beside_ / dropped;
  if (!dropped.starts_with("dropped") || plain_name(dropped) != fs::path(dropped).filename() ||
      !fs::is_directory(folder))
    throw UsageError("dropped: expected what the answer to the files has as `dropped`");
  const std::vector<std::string>& known = app::import_kind_named(kind).options;
  Making making{
      .set = {}, .folder = folder, .command = {"import", kind}, .nominal = {}, .pictures = folder};
  const std::vector<fs::path> sources = sources_in(folder);
  // Names as the person knows them, so that errors have them; none is an option.
  for (const fs::path& source : sources) {
    const std::string name = source.filename().string();
    making.command.push_back(name.starts_with('-') ? "./" + name : name);
  }
  for (const auto& [name, value] : options) {
    if (value.empty()) continue;
    if (std::ranges::find(known, name) == known.end())
      throw UsageError(fmt::format("options: '{}' means nothing to {}", name.substr(0, 40), kind));
    making.command.push_back(fmt::format("--{}={}", name, value));
  }
  making.set = new_folder(beside_, name_after(sources.front()));
  making.command.push_back("--out=" + making.set.string());
  return making;
}

fs::path Intake::picture_of(const fs::path& set, const std::string& frame) const {
  std::error_code none;
  const fs::path folder = fs::canonical(set / "pictures", none);
  // A foreign set's link may lead anywhere.
  const bool is_dropped = folder.parent_path() == fs::weakly_canonical(beside_) &&
                          folder.filename().string().starts_with("dropped");
  if (none || (!is_dropped && folder.parent_path() != fs::canonical(set))) return {};
  fs::path found;
  for (fs::recursive_directory_iterator at(folder, none), end; !none && at != end;
       at.increment(none)) {
    const fs::path& file = at->path();
    const bool is_it = file.filename() == frame && at->is_regular_file() && !at->is_symlink();
    if (is_it && (found.empty() || file < found)) found = file;
  }
  return found;
}

json imports_json() {
  json kinds = json::array();
  for (const app::ImportKind& kind : app::import_kinds())
    kinds.push_back({{"name", kind.name},
                     {"what", kind.what},
                     {"help", kind.help},
                     {"options", kind.options},
                     {"quantities", kind.quantities}});
  return kinds;
}

}  // namespace seam::tools
