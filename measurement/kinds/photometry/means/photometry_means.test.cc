// Smooth causes without a name in flat fields, made by a generator of its own: each is found with
// what it depends on, and sets that lack nothing, or an effect that has a name, have none.
#include "measurement/kinds/photometry/means/photometry_means.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <functional>

#include "measurement/kinds/kinds.h"
#include "measurement/search/search.h"
#include "measurement/search/without_name.h"
#include "sim_core/base/image.h"
#include "sim_core/base/output.h"
#include "sim_core/base/random.h"

namespace seam::measurement {
namespace {

constexpr int kColumns = 40, kRows = 30;
constexpr double kGain = 3000, kBlack = 90, kElectrons = 3, kRead = 3;

// A value's place from -1 to 1, its frame's time from 0 to 1, exposures over the first, and light.
struct Place {
  double x, y, time, exposure, light;
};
// What acts on the signal of a value, in DN above black.
using Cause = std::function<double(double signal_dn, const Place& place)>;

std::filesystem::path flat_fields(const std::string& name, uint64_t seed, const Cause& cause) {
  const auto folder = std::filesystem::path(testing::TempDir()) / ("means-" + name);
  std::filesystem::remove_all(folder);
  std::filesystem::create_directories(folder);
  const RandomStream random{seed, 7};
  std::string table = "frame,file,time_s,exposure_s,illumination\n";
  const std::vector<std::pair<double, int>> levels = {{0, 1},   {0.6, 1}, {0.2, 1}, {0.8, 1},
                                                      {0.4, 1}, {0.9, 1}, {0, 4},   {0.15, 4}};
  const int each = 5, frames = each * static_cast<int>(levels.size());
  for (int frame = 0; frame < frames; ++frame) {
    const auto [light, longer] = levels[static_cast<size_t>(frame / each)];
    Image image{.width_px = kColumns, .height_px = kRows, .bits = 16};
    const RandomStream of_frame = random.child(static_cast<uint64_t>(frame));
    for (int v = 0; v < kRows; ++v) {
      for (int u = 0; u < kColumns; ++u) {
        const Place place{2.0 * u / (kColumns - 1) - 1, 2.0 * v / (kRows - 1) - 1,
                          static_cast<double>(frame) / (frames - 1), static_cast<double>(longer),
                          light};
        const double signal = cause(kGain * light * longer, place);
        const double sigma = std::sqrt(kRead * kRead + std::max(0.0, signal) / kElectrons);
        const double dn =
            kBlack + signal + sigma * normal(of_frame, static_cast<uint64_t>(v * kColumns + u));
        image.samples.push_back(static_cast<uint16_t>(std::clamp(std::round(dn), 0.0, 4095.0)));
      }
    }
    write_png(folder / fmt::format("{}.png", frame), image);
    table += fmt::format("{0},{0}.png,{1},{2},{3}\n", frame, 0.3 * frame, 0.01 * longer, light);
  }
  write_file_atomically(folder / "frames.csv", table);
  write_file_atomically(
      folder / "measurement.yaml",
      fmt::format("format: seam-measurement/1\nkind: photometry\ntitle: means\ncamera: {{width_px: "
                  "{}, height_px: {}, bits: 12}}\ngroup: frame\nfiles: {{frames: frames.csv}}\n",
                  kColumns, kRows));
  return folder;
}

Model nominal() {
  return Model::from_config(ConfigNode::from_text(
      "format: seam-model/1\neffects: {linear_response: {gain_dn: {value: 2900, free: true}, "
      "black_dn: {value: 92, free: true}}, read_noise: {sigma_dn: {value: 3.2, free: true}}, "
      "shot_noise: {electrons_per_dn: {value: 3.2, free: true}}}\n",
      "model"));
}

std::optional<UnnamedCause> cause_in(const std::filesystem::path& folder) {
  const auto problem = open_problem(folder);
  const Model given = nominal();
  problem->prepare(given);
  const Assessment base = assess(*problem, given, refitted_unknowns(given));
  auto cause = unnamed_beside(*problem, {{.assessment = base}}, kMaterial, KnownCauses{1});
  std::filesystem::remove_all(folder);
  return cause;
}

double patch(const Place& p, double x, double y, double width) {
  return std::exp(-(std::pow(p.x - x, 2) + std::pow(p.y - y, 2)) / (2 * width * width));
}

TEST(PhotometryMeans, NothingIsFoundWhereNothingIsMissing) {
  for (const uint64_t seed : {1, 2, 3})
    EXPECT_FALSE(
        cause_in(flat_fields("none", seed, [](double signal, const Place&) { return signal; })));
}

TEST(PhotometryMeans, ACauseIsFoundWithWhatItDependsOn) {
  struct Case {
    std::string name, depends_on;
    Cause cause;
  };
  const std::vector<Case> cases = {
      {"weaker", "time", [](double s, const Place& p) { return s * (1 - 0.01 * p.time); }},
      {"warmer", "time", [](double s, const Place& p) { return s + 8 * p.time * p.time; }},
      {"patch", "column",
       [](double s, const Place& p) { return s * (1 - 0.02 * patch(p, 0.3, -0.2, 0.3)); }},
      {"mist", "time",
       [](double s, const Place& p) { return s * (1 - 0.05 * p.time * patch(p, -0.4, 0.1, 0.4)); }},
      {"leak", "exposure_s",
       [](double s, const Place& p) { return s + 12 * p.exposure * patch(p, 1, 0, 0.5); }},
  };
  for (const Case& c : cases) {
    const auto cause = cause_in(flat_fields(c.name, 11, c.cause));
    ASSERT_TRUE(cause) << c.name;
    const auto has = [&](const std::vector<std::string>& names) {
      return std::find(names.begin(), names.end(), c.depends_on) != names.end();
    };
    EXPECT_TRUE(std::any_of(cause->depends_on.begin(), cause->depends_on.end(), has)) << c.name;
    EXPECT_GT(cause->lead, 100) << c.name;
    EXPECT_LT(cause->error_after, 1.1) << c.name;
  }
}

// Brighter frames are not later here: a lamp that loses 3 % of its light is no bent response.
TEST(PhotometryMeansSlow, AWeakerLampIsNoFluctuation) {
  const auto folder =
      flat_fields("search", 5, [](double s, const Place& p) { return s * (1 - 0.03 * p.time); });
  const auto problem = open_problem(folder);
  const SearchResult result = search(*problem, nominal(), {}, [](const std::string&) {});
  std::filesystem::remove_all(folder);
  EXPECT_EQ(result.verdict, "unexplained_structure");
  EXPECT_TRUE(result.steps.empty());
  EXPECT_FALSE(result.mimics.empty());
  ASSERT_TRUE(result.unnamed);
  EXPECT_EQ(result.unnamed->depends_on.front(), std::vector<std::string>{"time"});
  // 3 % in 11.7 s.
  ASSERT_TRUE(result.suggestion);
  EXPECT_THAT(result.suggestion->formula, testing::ContainsRegex("^gain: 1 - 0.0025[0-9]* [*] t$"));
}

}  // namespace
}  // namespace seam::measurement
