#include "tools/workbench/exporting.h"

#include "app/exchange/exchange.h"
#include "measurement/sets/set.h"
#include "sim_core/base/error.h"
#include "sim_core/base/files.h"
#include "sim_core/base/output.h"
#include "tools/pages/refusal.h"
#include "tools/workbench/child.h"
#include "tools/workbench/places.h"

namespace seam::tools {
namespace {

namespace fs = std::filesystem;
using app::ExchangeFormat;
using nlohmann::json;

bool holds_kind(const ExchangeFormat& format, const std::string& kind) {
  if (format.text_of_servo != nullptr) return kind == "joints";
  if (format.text_of_imu != nullptr || format.text_of_rig != nullptr) return kind == "imu";
  const bool of_camera = kind == "points" || kind == "frames" || kind == "outcomes";
  return format.text_of_all != nullptr || of_camera;
}

// A camera's format asks the set for the size of the image, where the set has one.
bool asks_set(const ExchangeFormat& format, const fs::path& set) {
  if (format.text_of_all != nullptr) return false;
  return format.text == nullptr || measurement::MeasurementSet::open(set).camera.width_px > 0;
}

}  // namespace

json export_formats_json(const std::string& kind) {
  json formats = json::array();
  for (const ExchangeFormat& format : app::exchange_formats()) {
    if (holds_kind(format, kind)) formats.push_back({{"name", format.name}, {"what", format.help}});
  }
  return formats;
}

json exported_json(const Exporting& wanted) {
  const ExchangeFormat& format = app::exchange_format_named(wanted.format, "format");
  const std::string name = fmt::format("{}-{}-{}{}", name_in_files(wanted.set.filename()),
                                       wanted.version, format.name, format.ending);
  make_output_folder(wanted.scratch);
  const fs::path out = wanted.scratch / ("export-" + format.name);
  const fs::path model = wanted.scratch / "export-model.yaml";
  wanted.model.write(model);
  std::vector<std::string> command = {"export", fs::absolute(model).string()};
  command.insert(command.end(), {"--to", format.name, "--out", out.string()});
  if (asks_set(format, wanted.set))
    command.insert(command.end(), {"--data", fs::absolute(wanted.set).string()});
  if (wanted.drop) command.insert(command.end(), {"--drop", "all"});
  json notes = json::array();
  Child child;
  const Child::Ended ended = child.run(command, wanted.scratch, [&](std::string_view line) {
    for (const std::string_view before : {"  lens: ", "  note: "}) {
      if (line.starts_with(before)) notes.push_back(std::string(line.substr(2)));
    }
  });
  fs::remove(model);
  if (ended.code != 0) throw Refusal(400, ended.trouble());
  json answer = {{"name", name}, {"text", read_file(out)}, {"notes", std::move(notes)}};
  fs::remove(out);
  return answer;
}

}  // namespace seam::tools
