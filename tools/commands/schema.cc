// `seam schema FORMAT`: the JSON Schema of a file format, for editors that complete and check keys.
#include <cstdio>

#include "effects/schema/model_schema.h"
#include "measurement/sets/set.h"
#include "sim_core/scenario/scenario.h"
#include "sim_core/scene/scene_file.h"
#include "tools/command.h"

namespace seam::tools {
namespace {

std::string schema_of(const std::string& format) {
  if (format == "measurement") return measurement::MeasurementSet::schema();
  if (format == "model") return effects::model_schema();
  if (format == "scene") return scene_schema();
  return Scenario::schema();
}

}  // namespace

void add_schema(app::Command app) {
  app::Command command =
      app.add_subcommand("schema", "Prints the JSON Schema of a file format, for editors");
  auto format = std::make_shared<std::string>();
  command.add_option("FORMAT", *format, "The format: measurement, model, scenario or scene")
      .required()
      .one_of({"measurement", "model", "scenario", "scene"});
  command.footer("Example: seam schema model");
  command.callback([format] { std::fputs(schema_of(*format).c_str(), stdout); });
}

}  // namespace seam::tools
