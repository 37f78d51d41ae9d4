#include "measurement/report/unnamed/unnamed_told.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "measurement/search/order.h"

namespace seam::measurement {
namespace {

using nlohmann::ordered_json;

ordered_json finite(double value) {
  return std::isfinite(value) ? ordered_json(value) : ordered_json(nullptr);
}

std::string beside_it(const EmpiricalLens& lens) {
  return lens.beside.empty() ? "" : fmt::format(" beside {}", fmt::join(lens.beside, ", "));
}

ordered_json splines_json(const EmpiricalLens& lens) {
  return {{"effect", lens.effect},
          {"beside", lens.beside},
          {"error", finite(lens.error)},
          {"rms_px", finite(lens.rms_px)},
          {"lead", lens.lead},
          {"with_formula", lens.named},
          {"with_formula_error", finite(lens.named_error)},
          {"with_formula_rms_px", finite(lens.named_rms_px)},
          {"yaml", lens.assessment.model.to_yaml()}};
}

}  // namespace

void add_unnamed(ordered_json& json, const SearchResult& result) {
  json["noise_of_unknown_cause"] = noises_of_unknown_cause(result);
  if (const auto& formula = result.suggestion) {
    ordered_json numbers = ordered_json::array();
    for (const auto& [parameter, value, sigma] : formula->numbers)
      numbers.push_back({{"parameter", parameter}, {"value", value}, {"sigma", finite(sigma)}});
    json["suggestion"] = {{"effect", formula->effect},
                          {"formula", formula->formula},
                          {"numbers", std::move(numbers)},
                          {"error", finite(formula->error)},
                          {"error_before", finite(formula->error_before)},
                          {"terms", formula->terms},
                          {"beside", formula->beside},
                          {"mimics", result.mimics},
                          {"yaml", formula->yaml}};
  }
  if (result.splines) json["empirical_lens"] = splines_json(*result.splines);
  if (!result.unnamed) return;
  const UnnamedCause& cause = *result.unnamed;
  json["unnamed_cause"] = {{"depends_on", cause.depends_on},
                           {"noise_units", cause.noise_units},
                           {"takes", cause.takes},
                           {"error_before", cause.error_before},
                           {"error_after", cause.error_after},
                           {"lead", cause.lead},
                           {"mimics", result.mimics}};
}

std::string splines_sentence(const SearchResult& result) {
  if (!result.splines) return "";
  const EmpiricalLens& lens = *result.splines;
  return fmt::format(
      " An empirical lens of splines ({}{}) leaves {:.3g} px in held-out views; with the nearest "
      "formula of a lens {:.3g} px are left.",
      lens.effect, beside_it(lens), lens.rms_px, lens.named_rms_px);
}

std::string splines_text(const SearchResult& result) {
  if (!result.splines) return "";
  const EmpiricalLens& lens = *result.splines;
  return fmt::format(
      "empirical lens: {}{}\n  error {:.4f}, {:.3g} px rms on held-out groups; with the nearest "
      "formula ({}) {:.4f}, {:.3g} px\n",
      lens.effect, beside_it(lens), lens.error, lens.rms_px,
      lens.named.empty() ? "no distortion" : fmt::format("{}", fmt::join(lens.named, ", ")),
      lens.named_error, lens.named_rms_px);
}

}  // namespace seam::measurement
