#include "app/import/draft/set_draft.h"

#include <fmt/ranges.h>
#include <stdlib.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstring>

#include "effects/model.h"
#include "measurement/check/describe.h"
#include "measurement/check/faults.h"
#include "measurement/kinds/kinds.h"
#include "sim_core/base/error.h"
#include "sim_core/base/output.h"
#include "sim_core/input/file_names.h"
#include "sim_core/input/shown_text.h"
#include "sim_core/signals/half_made.h"

namespace seam::app {

namespace fs = std::filesystem;

std::string yaml_text(std::string_view text) {
  std::string out = "\"";
  for (const char c : shown(text)) {
    if (c == '"' || c == '\\') out += '\\';
    out += c;
  }
  return out + '"';
}

std::string csv_word(std::string text) {
  std::replace_if(
      text.begin(), text.end(),
      [](char c) { return c == ',' || c == '"' || static_cast<unsigned char>(c) <= ' '; }, '_');
  return text;
}

std::string exact(double value) {
  // Twelve digits where they hold the number, so that 0.1 + 0.2 and the like stay readable.
  std::string text = fmt::format("{:.12g}", value);
  double back = 0;
  std::from_chars(text.data(), text.data() + text.size(), back);
  return back == value ? text : fmt::format("{}", value);
}

std::string seconds_text(int64_t ns) {
  const uint64_t size = ns < 0 ? 0 - static_cast<uint64_t>(ns) : static_cast<uint64_t>(ns);
  return fmt::format("{}{}.{:09}", ns < 0 ? "-" : "", size / 1'000'000'000, size % 1'000'000'000);
}

SetDraft::SetDraft(fs::path out) : out_(std::move(out)) {
  while (!out_.has_filename() && out_.has_parent_path()) out_ = out_.parent_path();
  std::error_code error;
  if (fs::exists(fs::symlink_status(out_, error))) {
    if (!fs::is_directory(out_, error) || !fs::is_empty(out_, error))
      throw InputError(
          fmt::format("{}: is there already, expected a new or an empty folder", out_.string()));
  }
  const fs::path parent = out_.has_parent_path() ? out_.parent_path() : fs::path(".");
  make_output_folder(parent);
  std::string pattern = (parent / ("." + out_.filename().string() + "-XXXXXX")).string();
  const SignalsWait wait;
  if (mkdtemp(pattern.data()) == nullptr)
    throw InputError(
        fmt::format("{}: cannot make a folder like this: {}", pattern, std::strerror(errno)));
  folder_ = pattern;
  is_half_made(folder_);
  // As folders are made elsewhere, less the umask.
  fs::permissions(folder_, fs::status(parent).permissions() & fs::perms::all, error);
}

SetDraft::~SetDraft() {
  std::error_code ignored;
  if (folder_.empty()) return;
  fs::remove_all(folder_, ignored);
  is_made(folder_);
}

void SetDraft::add_table(const std::string& name, const measurement::CsvWriter& table) {
  files_[name] = name + ".csv";
  table.write(folder_ / files_[name]);
}

void SetDraft::add_file(const std::string& name, std::string_view bytes) {
  const fs::path path = path_inside(folder_, name);
  fs::create_directories(path.parent_path());
  write_file_atomically(path, bytes);
}

std::string SetDraft::set_yaml(const std::string& came_from) const {
  std::string yaml =
      fmt::format("format: seam-measurement/1\nkind: {}\ntitle: {}\n", kind, yaml_text(title));
  if (camera.width_px > 0) {
    yaml += fmt::format("camera: {{width_px: {}, height_px: {}", camera.width_px, camera.height_px);
    if (camera.frame_period_s > 0)
      yaml += fmt::format(", frame_period_s: {}", exact(camera.frame_period_s));
    if (camera.channels != "grey" || camera.bits != 8)
      yaml += fmt::format(", channels: {}, bits: {}", camera.channels, camera.bits);
    yaml += "}\n";
  }
  std::vector<std::string> entries;
  for (const auto& [column, sigma] : noise)
    entries.push_back(fmt::format("{}: {}", column, exact(sigma)));
  if (!entries.empty()) yaml += fmt::format("noise: {{{}}}\n", fmt::join(entries, ", "));
  if (!group.empty()) yaml += fmt::format("group: {}\n", group);
  entries.clear();
  for (const auto& [name, file] : files_) entries.push_back(fmt::format("{}: {}", name, file));
  yaml += fmt::format("files: {{{}}}\n", fmt::join(entries, ", "));
  if (!scene.empty()) yaml += fmt::format("scene: {}\n", scene);
  if (!rig.empty()) yaml += fmt::format("rig: {}\n", rig);
  yaml += fmt::format("imported:\n  came_from: {}\n", yaml_text(came_from));
  const auto list = [&](const char* name, const std::vector<std::string>& sentences) {
    if (sentences.empty()) return;
    yaml += fmt::format("  {}:\n", name);
    for (const std::string& sentence : sentences)
      yaml += fmt::format("    - {}\n", yaml_text(sentence));
  };
  list("done", did_);
  list("doubts", warnings_);
  list("not_known", unknown_);
  return yaml;
}

std::string SetDraft::by_its_name(std::string text) const {
  const std::string inside = folder_.string();
  for (size_t at = text.find(inside); at != std::string::npos; at = text.find(inside))
    text.replace(at, inside.size(), out_.string());
  return text;
}

void SetDraft::check() {
  const auto set = measurement::MeasurementSet::open(folder_);
  const auto model = effects::Model::from_file(folder_ / "nominal.yaml");
  const measurement::SetDescription found =
      measurement::describe_set(set, std::nullopt, instruments);
  if (!found.errors.empty()) throw InputError(found.errors.front());
  for (const std::string& fault : measurement::faults_of_values(set)) warn(by_its_name(fault));
  const measurement::Kind& kind_of_set = measurement::find_kind(kind);
  is_protocol_ = measurement::is_protocol(set, kind_of_set.observations);
  if (!is_protocol_) kind_of_set.open(set, instruments)->check_model(model);
}

void SetDraft::finish(const std::string& came_from) {
  add_file("measurement.yaml", set_yaml(came_from));
  add_file("nominal.yaml",
           fmt::format("format: seam-model/1\nname: nominal\neffects:\n{}", effects));
  try {
    check();
  } catch (const InputError& error) {
    throw InputError(
        fmt::format("the set made of {} does not hold: {}", came_from, by_its_name(error.what())));
  }
  std::error_code error;
  fs::rename(folder_, out_, error);
  if (error)
    throw InputError(fmt::format("{}: cannot be made: {}", out_.string(), error.message()));
  is_made(folder_);
  folder_.clear();
}

std::string SetDraft::text() const {
  std::string text = fmt::format("{}: {}\n", out_.string(), title);
  for (const std::string& sentence : did_) text += fmt::format("  done: {}\n", shown(sentence));
  for (const std::string& sentence : warnings_)
    text += fmt::format("  warning: {}\n", shown(sentence));
  for (const std::string& sentence : unknown_)
    text += fmt::format("  not known: {}\n", shown(sentence));
  const std::string out = out_.string();
  if (is_protocol_)
    return text + fmt::format(
                      "  next: seam measure --model {0}/nominal.yaml --protocol {0} --seed 1 "
                      "--out made\n",
                      out);
  return text +
         fmt::format("  next: seam discover --model {0}/nominal.yaml --data {0} --out found.yaml\n",
                     out);
}

}  // namespace seam::app
