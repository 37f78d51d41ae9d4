#include "measurement/report/report.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "measurement/kinds/kinds.h"
#include "measurement/report/report_data.h"
#include "sim_core/base/error.h"
#include "sim_core/base/files.h"

namespace seam::measurement {
namespace {

constexpr const char* kTemplate =
    R"(<script type="application/json" id="data">__SEAM_REPORT_DATA__</script><p>page</p>)";

TEST(Report, DataStandsWhereTheMarkerWas) {
  EXPECT_EQ(fill_report_template(kTemplate, R"({"n": 1})"),
            R"(<script type="application/json" id="data">{"n": 1}</script><p>page</p>)");
}

TEST(Report, NoTextCanEndTheScript) {
  std::string page = fill_report_template(kTemplate, R"({"title": "</script><!-- a < b"})");
  EXPECT_NE(page.find(R"("\u003c/script>\u003c!-- a < b")"), std::string::npos) << page;
}

TEST(Report, TemplateWithoutMarkerIsAnError) {
  EXPECT_THROW(fill_report_template("<p>other</p>", "{}"), InputError);
}

TEST(Report, PlainPageShowsTheNumbersAndEscapesText) {
  std::string page =
      plain_report(R"({"title": "a<b", "result": {"error": 3.5, "steps": [{"effect": "x"}]}})");
  EXPECT_NE(page.find("a&lt;b"), std::string::npos);
  EXPECT_NE(page.find("3.5"), std::string::npos);
  EXPECT_NE(page.find("<th>effect</th><td>x</td>"), std::string::npos);
}

TEST(Report, WritesAPageWithOrWithoutTheTemplate) {
  auto path = std::filesystem::temp_directory_path() / "seam_report_test.html";
  OutputFile page(path);
  write_report(page, R"({"format": "seam-report/1", "result": {"error": 2.25}})");
  EXPECT_NE(read_file(path).find("2.25"), std::string::npos);
  std::filesystem::remove(path);
}

// A set from its texts: ten groups of twenty rows.
std::string made_set(const std::string& kind, const std::string& noise,
                     const std::map<std::string, std::string>& tables) {
  const auto folder = std::filesystem::path(testing::TempDir()) / ("report-" + kind);
  std::filesystem::create_directories(folder);
  std::string files;
  for (const auto& [name, text] : tables) {
    files += fmt::format("{}{}: {}.csv", files.empty() ? "" : ", ", name, name);
    write_file_atomically(folder / (name + ".csv"), text);
  }
  write_file_atomically(folder / "measurement.yaml",
                        fmt::format("format: seam-measurement/1\nkind: {}\ntitle: made\nnoise: "
                                    "{{{}}}\ngroup: run\nfiles: {{{}}}\n",
                                    kind, noise, files));
  return folder;
}

Model with_effect(const std::string& effect) {
  return Model::from_config(ConfigNode::from_text(
      fmt::format("format: seam-model/1\neffects: {{{}: {{}}}}\n", effect), "made"));
}

nlohmann::json plots_of(const std::string& folder, const std::string& effect) {
  const auto problem = open_problem(folder);
  const CompareResult result = compare(*problem, with_effect(effect));
  ReportHeader header;
  header.data_folder = folder;
  header.doubts = {"units?"};
  const auto report = nlohmann::json::parse(compare_report(*problem, result, header));
  const std::string first = report["result"]["headline"].get<std::string>() + "\nunits?\n";
  EXPECT_EQ(compare_text(*problem, result, header.doubts).find(first), 0u);
  EXPECT_EQ(report["data"]["n"], report["result"]["observations"]);
  return report["plots"];
}

// A servo that follows its command by nine tenths: an ideal one is predicted at the command.
TEST(DataPictures, ServoTracksStandBesideTheirPredictions) {
  std::string rows = "run,time_s,joint,command_rad,measured_rad\n";
  for (int run = 0; run < 10; ++run) {
    for (int i = 0; i < 20; ++i) {
      const double command = 0.1 * std::sin(0.5 * i + run);
      rows += fmt::format("{},{:.3f},tilt,{:.6f},{:.6f}\n", run, 0.05 * i, command, 0.9 * command);
    }
  }
  const auto plots =
      plots_of(made_set("joints", "measured_rad: 0.001", {{"joints", rows}}), "ideal_servo");
  ASSERT_EQ(plots["series"].size(), 3u) << plots["series"];  // As many runs are held out.
  for (const auto& track : plots["series"]) {
    EXPECT_EQ(track["title"].get<std::string>().find("run "), 0u);
    EXPECT_NE(track["title"].get<std::string>().find(", tilt"), std::string::npos);
    ASSERT_EQ(track["lines"].size(), 3u);
    EXPECT_EQ(track["lines"][1]["name"], "measured");
    const auto &command = track["lines"][0]["points"], &measured = track["lines"][1]["points"],
               &predicted = track["lines"][2]["points"];
    ASSERT_GT(measured.size(), 10u);
    for (size_t i = 0; i < measured.size(); ++i) {
      EXPECT_NEAR(measured[i][1].get<double>(), 0.9 * command[i][1].get<double>(), 2e-6);
      if (i == 0) continue;  // An ideal servo is where the last row commanded.
      EXPECT_NEAR(predicted[i][1].get<double>(), command[i - 1][1].get<double>(), 2e-5);
    }
  }
}

TEST(DataPictures, WalksAreSeenFromAbove) {
  std::string rows = "run,time_s,vx_cmd_mps,vy_cmd_mps,omega_cmd_radps,x_m,y_m,theta_rad\n";
  for (int run = 0; run < 10; ++run) {
    for (int i = 0; i < 20; ++i)
      rows += fmt::format("{},{:.1f},0.1,0,0,{:.5f},{},0\n", run, 0.2 * i, 0.025 * i, run);
  }
  const auto plots = plots_of(
      made_set("odometry", "x_m: 0.002, y_m: 0.002, theta_rad: 0.003", {{"odometry", rows}}),
      "ideal_odometry");
  ASSERT_FALSE(plots["series"].empty());
  const auto& walk = plots["series"][0];
  EXPECT_EQ(walk["plane"], "world_m");
  const auto length = [&](int line) {
    const auto& points = walk["lines"][line]["points"];
    return points.back()[0].get<double>() - points[0][0].get<double>();
  };
  // It went a quarter farther than commanded.
  EXPECT_NEAR(length(0) / length(1), 1.25, 0.02);
}

// The bearings are 0.1 rad too far to the left: arrows of that angle across the line of sight.
std::string beacons() {
  std::string seen = "run,time_s,landmark,range_m,bearing_rad\n",
              poses = "run,time_s,x_m,y_m,theta_rad\n";
  const double places[2][2] = {{2, 1}, {2, -1}};
  for (int run = 0; run < 10; ++run) {
    for (int i = 0; i < 20; ++i) {
      const double x = 0.02 * i, y = 0.05 * run - 0.25;
      poses += fmt::format("{},{:.2f},{:.4f},{:.4f},0\n", run, 0.1 * i, x, y);
      const double dx = places[i % 2][0] - x, dy = places[i % 2][1] - y;
      seen += fmt::format("{},{:.2f},{},{:.5f},{:.5f}\n", run, 0.1 * i, i % 2, std::hypot(dx, dy),
                          std::atan2(dy, dx) + 0.1);
    }
  }
  return made_set("landmarks", "range_m: 0.03, bearing_rad: 0.006",
                  {{"observations", seen},
                   {"landmarks", "landmark,x_m,y_m\n0,2,1\n1,2,-1\n"},
                   {"poses", poses}});
}

TEST(DataPictures, LandmarksHaveTheirResidualsOverTheGround) {
  const auto plots = plots_of(beacons(), "ideal_detector");
  ASSERT_EQ(plots["arrows"].size(), 1u);
  const auto& map = plots["arrows"][0];
  EXPECT_EQ(map["plane"], "world_m");
  EXPECT_EQ(map["places"].size(), 2u);
  ASSERT_EQ(map["items"].size(), map["robot"].size());
  for (size_t i = 0; i < map["items"].size(); ++i) {
    const double x = map["items"][i][0], y = map["items"][i][1], dx = map["items"][i][2],
                 dy = map["items"][i][3];
    const double to_x = x - map["robot"][i][0].get<double>(),
                 to_y = y - map["robot"][i][1].get<double>();
    EXPECT_NEAR(dx, -0.1 * to_y, 1e-3);
    EXPECT_NEAR(dy, 0.1 * to_x, 1e-3);
  }
}

// What the found model leaves was not tested in the residuals of the first, nor the other way
// round.
TEST(ReportData, AStrengthStandsBesideItsOwnModelAlone) {
  const std::string folder = beacons();
  const auto problem = open_problem(folder);
  SearchResult result;
  result.base.assessment = compare(*problem, with_effect("ideal_detector")).base.assessment;
  result.best = result.base;
  result.steps = {{.effect = "ideal_detector"}};
  result.verdict = "unexplained_structure";
  result.base_structure = {
      {.residual = "bearing_rad", .moment = "mean", .covariate = "time", .strength = 10}};
  result.remaining = {
      {.residual = "range_m", .moment = "mean", .covariate = "range", .strength = 0.02}};
  const auto report =
      nlohmann::json::parse(diagnose_report(*problem, result, {.data_folder = folder}));
  int strengths = 0;
  ASSERT_EQ(report["plots"]["residuals"].size(), 4u);
  for (const auto& plot : report["plots"]["residuals"]) {
    const bool own = (plot["residual"] == "range_m") == (plot["stage"] == "after");
    EXPECT_EQ(plot.contains("strength"), own) << plot["residual"] << plot["stage"];
    strengths += plot.contains("strength");
  }
  EXPECT_EQ(strengths, 2);
  EXPECT_EQ(report["result"]["structure_of"], "explanation");
}

TEST(LensMap, LastDigitsAreNoDifference) {
  LensMap map{.columns = 2, .rows = 1, .width_px = 4, .height_px = 2, .size_px = {1e-14, 3e-13}};
  EXPECT_EQ(models_text({map}, "a", "b"), "a and b agree: no place differs by 1e-06 px\n");
  map.size_px[1] = 0.5;
  EXPECT_NE(models_text({map}, "a", "b").find("at most by 0.5 px"), std::string::npos);
}

}  // namespace
}  // namespace seam::measurement
