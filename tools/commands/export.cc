// `seam export`: a model as a file of another program.
#include <algorithm>
#include <cstdio>
#include <iterator>

#include "app/exchange/exchange.h"
#include "measurement/kinds/kinds.h"
#include "measurement/numerics/robust.h"
#include "measurement/sets/set.h"
#include "sim_core/base/error.h"
#include "sim_core/base/output.h"
#include "tools/command.h"
#include "tools/commands/analysis.h"

namespace seam::tools {
namespace {

struct ExportFlags {
  std::string model, to, out, size, data, form;
  std::vector<std::string> drop;
};

// The gains at which the controller of the set's servo ran. Rows without drive have a gain of 0.
app::ServoGains gains_of(const measurement::MeasurementSet& set) {
  app::ServoGains gains{.known = true};
  const auto table = set.table(measurement::find_kind(set.kind).observations.file);
  if (!table.has("kp")) return gains;
  for (const double kp : table.numbers("kp")) {
    if (kp > 0) gains.values.push_back(kp);
  }
  std::sort(gains.values.begin(), gains.values.end());
  gains.values.erase(std::unique(gains.values.begin(), gains.values.end()), gains.values.end());
  return gains;
}

// Samples a second of a set of inertial sensors.
double rate_of(const measurement::MeasurementSet& set) {
  const auto time_ns = set.table("imu").times_ns("time_s");
  std::vector<int64_t> steps_ns;
  for (size_t i = 1; i < time_ns.size(); ++i) steps_ns.push_back(time_ns[i] - time_ns[i - 1]);
  const double step_ns =
      steps_ns.empty() ? 0 : static_cast<double>(measurement::median_of(steps_ns));
  return step_ns > 0 ? 1e9 / step_ns : 0;
}

app::ExportOptions options_of(const ExportFlags& flags, const app::ExchangeFormat& format) {
  app::ExportOptions options{.drop = flags.drop, .form = flags.form};
  if (format.text_of_servo != nullptr) {
    if (!flags.data.empty())
      options.gains = gains_of(measurement::MeasurementSet::open(flags.data));
    return options;
  }
  if (format.text_of_rig != nullptr) return options;
  if (format.text_of_imu != nullptr) {
    if (!flags.data.empty())
      options.rate_hz = rate_of(measurement::MeasurementSet::open(flags.data));
    return options;
  }
  if (!flags.size.empty()) {
    char end = 0;
    if (std::sscanf(flags.size.c_str(), "%5dx%5d%c", &options.width_px, &options.height_px, &end) !=
            2 ||
        options.width_px < 2 || options.height_px < 2)
      throw UsageError(
          fmt::format("--size {}: expected WIDTHxHEIGHT in pixels, like 640x480", flags.size));
  } else if (!flags.data.empty()) {
    const auto set = measurement::MeasurementSet::open(flags.data);
    options.width_px = set.camera.width_px, options.height_px = set.camera.height_px;
    if (options.width_px == 0)
      throw InputError(
          fmt::format("{}: names no camera, expected `camera:` with its size: give "
                      "--size WIDTHxHEIGHT",
                      flags.data));
  }
  return options;
}

std::string formats_help() {
  std::string help = "Formats:\n";
  for (const app::ExchangeFormat& format : app::exchange_formats())
    help += fmt::format("  {:10} {}\n", format.name, format.help);
  return help;
}

}  // namespace

void add_export(app::Command app) {
  app::Command command =
      app.add_subcommand("export", "Writes a model as a file that another program reads");
  auto flags = std::make_shared<ExportFlags>();
  command.add_option("MODEL", flags->model, "The model").required();
  command.add_option("--to", flags->to, "The format").required();
  command.add_option("--out", flags->out, "The file to write").required();
  command.add_option("--drop", flags->drop,
                     "An effect that the format cannot hold, to be left out at a cost that is "
                     "printed; 'all': all of them; may be given several times");
  command.add_option("--size", flags->size, "Of the image, WIDTHxHEIGHT in pixels");
  command.add_option("--data", flags->data,
                     "A measurement set: its camera has the size, its servo's log the gain, its "
                     "inertial sensors the rate");
  command.add_option("--form", flags->form,
                     "Of the lens: ordinary, rational or fisheye, where the format has it");
  command.footer(
      formats_help() +
      "What a format cannot hold is an error that names the effect, or with --drop a warning with\n"
      "the error that this costs, in pixels or mrad. What is no property of the camera (a bent "
      "board)\n"
      "is no loss. A lens of another form is fitted over the image, and what the fit misses is "
      "printed:\n"
      "the ordinary form where it fits, else the nearest; file and output say which.\n"
      "Example: seam export models/ideal_camera.yaml --to kalibr --out camchain.yaml");
  command.callback([flags] {
    const app::ExchangeFormat& format = app::exchange_format_named(flags->to, "--to");
    OutputRules rules{.inputs = {flags->model}};
    if (!flags->data.empty())
      std::ranges::copy(files_of_set(flags->data), std::back_inserter(rules.inputs));
    OutputFile out(flags->out, rules);
    const effects::Model model = read_model(flags->model);
    const app::Exported exported = app::export_model(model, format, options_of(*flags, format));
    out.fill(exported.text);
    std::printf("%s: %s\n", flags->out.c_str(), format.help.c_str());
    if (!exported.form.empty()) std::printf("  lens: %s\n", exported.form.c_str());
    for (const std::string& note : exported.notes) std::printf("  note: %s\n", note.c_str());
  });
}

}  // namespace seam::tools
