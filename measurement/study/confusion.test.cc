// Effects that look alike: told apart where the data allows, declared where it does not.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <ostream>
#include <regex>

#include "measurement/kinds/kinds.h"
#include "measurement/study/study.h"
#include "sim_core/base/files.h"
#include "sim_core/base/output.h"

namespace seam::measurement {
namespace {

namespace fs = std::filesystem;

struct Case {
  std::string kind, truth, rival;  // Effects; the truth with its parameters.
  std::string name() const { return truth.substr(0, truth.find(':')); }
  friend void PrintTo(const Case& c, std::ostream* out) {
    *out << c.kind << ": " << c.name() << ", not " << c.rival;
  }
};

using Edit = std::function<void(const fs::path& protocol)>;

SearchResult searched(const std::string& kind, const std::string& hidden, const Edit& edit = {}) {
  const std::string name =
      kind + "-" + hidden.substr(0, hidden.find(':')) + (edit ? "-edited" : "");
  const fs::path protocol = fs::path(testing::TempDir()) / ("confusion-" + name),
                 out = protocol.string() + "-set";
  const Model nominal = write_study_protocol(kind, protocol);
  if (edit) edit(protocol);
  std::string effects;
  for (const effects::ModelEffect& effect : nominal.effects()) {
    effects += effect.definition->name + ": {";
    for (size_t i = 0; i < effect.parameters.size(); ++i) {
      effects += fmt::format("{}{}: {}", i ? ", " : "", effect.definition->parameters[i].name,
                             effect.parameters[i].value);
    }
    effects += "}, ";
  }
  const Model truth = Model::from_config(ConfigNode::from_text(
      "format: seam-model/1\neffects: {" + effects + hidden + "}\n", "truth"));
  measure_set(truth, MeasurementSet::open(protocol), {.seed = 6, .out = out});
  const auto problem = open_problem(out);
  return search(*problem, nominal, {}, [](const std::string&) {});
}

bool holds(const std::vector<std::string>& names, const std::string& name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

class ToldApart : public testing::TestWithParam<Case> {};

TEST_P(ToldApart, WhereTheDataAllows) {
  const Case& c = GetParam();
  const SearchResult result = searched(c.kind, c.truth);
  ASSERT_EQ(result.steps.size(), 1u);
  EXPECT_EQ(result.steps[0].effect, c.name());
  EXPECT_FALSE(holds(result.steps[0].indistinguishable_from, c.rival));
  // The prediction of a dead band jumps with its width: training runs leave an interval, within
  // which a held-out run may hold another jump.
  if (c.name() == "stiction") return;
  EXPECT_EQ(result.verdict, "missing_effect");
  EXPECT_LT(result.best.assessment.error, 1.1);
}

INSTANTIATE_TEST_SUITE_P(
    Pairs, ToldApart,
    testing::Values(Case{"points", "rolling_shutter: {line_delay_s: 0.0001}", "frame_latency"},
                    Case{"points", "frame_latency: {latency_s: 0.006}", "rolling_shutter"},
                    Case{"points", "focal_length_error: {fx_scale: 0.01, fy_scale: 0.01}",
                         "encoder_scale"},
                    Case{"points", "encoder_scale: {pan_scale: 0.01}", "focal_length_error"},
                    Case{"points", "encoder_offset: {pan_rad: 0.01}", "principal_point_offset"},
                    Case{"points", "principal_point_offset: {du_px: 1.2}", "encoder_offset"},
                    Case{"joints", "servo_latency: {latency_s: 0.02}", "servo_lag"},
                    Case{"joints", "servo_lag: {tau_s: 0.012}", "servo_latency"},
                    Case{"joints", "backlash: {width_rad: 0.006}", "stiction"},
                    Case{"joints", "stiction: {dead_band_rad: 0.02}", "backlash"}),
    [](const auto& info) { return info.param.name() + "_not_" + info.param.rival; });

void rewrite(const fs::path& file, const std::string& pattern, const std::string& by) {
  write_file_atomically(file, std::regex_replace(read_file(file), std::regex(pattern), by));
}

// A window's length moves a point like a latency of half of it: one exposure time cannot tell them.
TEST(Declared, ExposureAndLatency) {
  const SearchResult result = searched("points", "exposure: {exposure_s: 0.01}");
  ASSERT_EQ(result.steps.size(), 1u);
  EXPECT_EQ(result.steps[0].effect, "frame_latency");  // Without a bound at neutral.
  EXPECT_TRUE(holds(result.steps[0].indistinguishable_from, "exposure"));
}

// A level head that sees points at its own height has them all in one row.
TEST(Declared, RollingShutterAndLatencyInOneRow) {
  const SearchResult result =
      searched("points", "rolling_shutter: {line_delay_s: 0.0001}", [](const fs::path& set) {
        rewrite(set / "joints.csv", R"(\n([^,\n]+),[^,\n]+,)", "\n$1,0,");
        rewrite(set / "points.csv", R"(,[^,\nz]+\n)", ",0.243\n");
      });
  ASSERT_EQ(result.steps.size(), 1u);
  const Step& step = result.steps[0];
  for (const std::string effect : {"rolling_shutter", "frame_latency"}) {
    EXPECT_TRUE(step.effect == effect || holds(step.indistinguishable_from, effect)) << effect;
  }
}

// Nothing is known of an encoder's scale where the joint stands at zero.
TEST(Declared, EncoderScaleOfAStandingHead) {
  const SearchResult result = searched(
      "points", "focal_length_error: {fx_scale: 0.01, fy_scale: 0.01}", [](const fs::path& set) {
        rewrite(set / "joints.csv", R"(\n([^,\n]+),[^,\n]+,[^,\n]+)", "\n$1,0,0");
      });
  ASSERT_EQ(result.steps.size(), 1u);
  EXPECT_EQ(result.steps[0].effect, "focal_length_error");
  EXPECT_TRUE(std::any_of(result.first.not_testable.begin(), result.first.not_testable.end(),
                          [](const NotTestable& n) {
                            return n.effect == "encoder_scale" && n.parameter == "pan_scale";
                          }));
}

// The same load can be told from the opposite level with the other sign; a fit tells it the near
// way.
TEST(Declared, ASagByItsNearLevel) {
  for (const double rad : {0.02, -0.02}) {
    const SearchResult result =
        searched("joints", fmt::format("gravity_sag: {{rad: {}, level_rad: 0.3}}", rad));
    const effects::ModelEffect* found = result.best.assessment.model.find("gravity_sag");
    ASSERT_NE(found, nullptr) << rad;
    EXPECT_NEAR(found->value("rad"), rad, 0.001);
    EXPECT_NEAR(found->value("level_rad"), 0.3, 0.03);
  }
}

}  // namespace
}  // namespace seam::measurement
