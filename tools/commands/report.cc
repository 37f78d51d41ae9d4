// `seam report RESULT.json --out F.html`: a page from a result written earlier.
#include "measurement/report/report.h"

#include <cstdio>
#include <nlohmann/json.hpp>

#include "sim_core/base/error.h"
#include "sim_core/input/json_input.h"
#include "tools/command.h"

namespace seam::tools {
namespace {

using nlohmann::json;

json read_result(const std::string& file) {
  json result = read_json(file, "a result that a command wrote with --json");
  if (result.is_object() && result.contains("format") && result["format"].is_string())
    return result;
  throw InputError(
      fmt::format("{}: format: found nothing, expected for example \"seam-diagnose/1\"", file));
}

}  // namespace

void add_report(app::Command app) {
  app::Command command = app.add_subcommand(
      "report", "Makes the page of a result: seam report result.json --out result.html");
  auto file = std::make_shared<std::string>();
  auto out = std::make_shared<std::string>();
  command.add_option("RESULT", *file, "What a command wrote with --json").required();
  command.add_option("--out", *out, "The page to write").required();
  command.footer(
      "Example: seam diagnose --model nominal.yaml --data sets/points-a --json found.json && "
      "seam report found.json --out report.html");
  command.callback([file, out] {
    OutputFile page(*out, {.inputs = {*file}});
    json result = read_result(*file);
    const std::string format = result["format"];
    if (format != "seam-report/1") {
      result = {{"format", "seam-report/1"},
                {"command", fmt::format("seam report {} --out {}", *file, *out)},
                {"result", std::move(result)}};
    }
    measurement::write_report(page, result.dump());
    std::printf("%s: a page of %s\n", out->c_str(), format.c_str());
  });
}

}  // namespace seam::tools
