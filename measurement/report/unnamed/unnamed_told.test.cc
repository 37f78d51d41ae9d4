#include "measurement/report/unnamed/unnamed_told.h"

#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "effects/registry.h"
#include "measurement/problem/made_problem.h"
#include "measurement/report/results.h"

namespace seam::measurement {
namespace {

using nlohmann::json;

class Servo : public MadeProblem {
 public:
  Servo() : MadeProblem({0, 1}, 0.15, [](const auto&, double) { return 0.0; }) {
    facts_.set.kind = effects::kJoints;
  }
};

// A search that found these effects.
SearchResult found(const std::vector<std::string>& names) {
  SearchResult result;
  result.verdict = "missing_effect";
  for (const std::string& name : names) {
    result.best.assessment.model.add_neutral(effects::find_effect(name));
    result.steps.push_back({.effect = name});
  }
  return result;
}

TEST(NoiseOfUnknownCause, IsWrittenByBothCommandsAndIsInTheSchema) {
  const Servo problem;
  std::ifstream file(SEAM_SOURCE_DIR "/docs/reference/schemas/results.schema.json");
  const json definitions = json::parse(file)["$defs"];
  const auto check = [&](const std::vector<std::string>& names, const json& expected) {
    const SearchResult result = found(names);
    for (const std::string& text :
         {diagnose_json(problem, result, {}), discover_json(problem, result, {})}) {
      const json written = json::parse(text);
      EXPECT_EQ(written.at("noise_of_unknown_cause"), expected) << text;
      const std::string format = written.at("format");
      EXPECT_TRUE(definitions.at(format.substr(0, format.find('/')))["properties"].contains(
          "noise_of_unknown_cause"))
          << format;
    }
  };
  check({"gravity_sag", "joint_wander", "walk_noise"}, {"joint_wander", "walk_noise"});
  check({"gravity_sag"}, json::array());
}

}  // namespace
}  // namespace seam::measurement
