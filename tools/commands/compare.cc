// `seam compare`: residuals of a model on held-out groups, and where they fail; or two models
// beside each other over the image.
#include "measurement/problem/views.h"
#include "measurement/report/lens_map.h"
#include "measurement/report/report.h"
#include "measurement/sets/set.h"
#include "sim_core/base/error.h"
#include "tools/command.h"
#include "tools/commands/analysis.h"

namespace seam::tools {
namespace {

void compare_with_data(const AnalysisFlags& flags) {
  AnalysisOutputs outputs(flags);
  const effects::Model model = read_model(flags.model);
  const auto problem = open_problem(flags);
  if (outputs.attitudes) outputs.attitudes.fill(measurement::attitudes_table(*problem, model));
  const auto result = measurement::compare(*problem, model, flags.material);
  const auto doubts = doubts_about(flags, model, result.base.assessment.error);
  outputs.print(measurement::compare_text(*problem, result, doubts),
                [&] { return measurement::compare_json(*problem, result, doubts); });
  if (outputs.report) {
    measurement::write_report(
        outputs.report,
        measurement::compare_report(*problem, result, report_header("compare", flags, doubts)));
  }
}

void compare_models(const AnalysisFlags& flags, const std::vector<std::string>& files) {
  AnalysisOutputs outputs(flags, "", files);
  const auto set = measurement::MeasurementSet::open(flags.data);
  if (set.camera.width_px == 0)
    throw InputError(flags.data + ": the set names no camera, expected its width_px and height_px");
  const auto maps = measurement::difference_maps(read_model(files[0]), read_model(files[1]),
                                                 set.camera.width_px, set.camera.height_px);
  outputs.print(measurement::models_text(maps, files[0], files[1]),
                [&] { return measurement::models_json(maps, files[0], files[1]); });
  if (outputs.report) {
    const measurement::ReportHeader header{
        .command = fmt::format("seam compare --models {} {} --data {} --report {}", files[0],
                               files[1], flags.data, flags.report),
        .model_file = files[0],
        .data_folder = flags.data};
    measurement::write_report(outputs.report,
                              measurement::models_report(maps, files[0], files[1], header));
  }
}

}  // namespace

void add_compare(app::Command app) {
  app::Command command = app.add_subcommand(
      "compare",
      "Compares a model with measurements and says where it fails, or two models with each other");
  auto flags = std::make_shared<AnalysisFlags>();
  auto models = std::make_shared<std::vector<std::string>>();
  command.add_option("--model", flags->model, "The model (seam-model/1)");
  command.add_option("--models", *models,
                     "Two models instead: how their images differ over the set's camera");
  add_data_flags(command, *flags, true);
  add_material_flag(command, *flags);
  command.add_option("--attitudes-out", flags->attitudes_out,
                     "Of points with unknown poses: writes how the camera was turned in each view, "
                     "for a set with an inertial sensor");
  command.footer(
      "Examples:\n"
      "  seam compare --model nominal.yaml --data sets/points-a --json compare.json\n"
      "  seam compare --models nominal.yaml better.yaml --data sets/points-a");
  command.callback([flags, models] {
    if (flags->model.empty() == models->empty() || (!models->empty() && models->size() != 2))
      throw UsageError("compare: expected --model MODEL, or --models A B with two models");
    if (flags->model.empty() && !flags->attitudes_out.empty())
      throw UsageError(
          "compare: --attitudes-out needs --model: two models are compared without "
          "views");
    if (flags->model.empty() && !flags->leave_out.empty())
      throw UsageError("compare: --leave-out needs --model: two models are compared without rows");
    if (models->empty()) {
      compare_with_data(*flags);
    } else {
      compare_models(*flags, *models);
    }
  });
}

}  // namespace seam::tools
