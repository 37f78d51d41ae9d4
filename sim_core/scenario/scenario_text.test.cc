// A scenario that is written and read again is the same one, whatever its fields hold: logs keep
// the scenario as text, and a run that goes on from a log must be the run that was logged.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <yaml-cpp/yaml.h>

#include <array>
#include <functional>
#include <map>

#include "sim_core/base/random.h"
#include "sim_core/scenario/scenario.h"
#include "sim_core/world/world.h"

namespace seam {
namespace {

const std::string kRoot = SEAM_SOURCE_DIR;

// One of each: a robot of legs, an arm, all kinds of objects, models with names and numbers.
std::string full_scenario() {
  const std::string ers210 =
      "    body: '" + kRoot + "/models/robot_ers210.yaml'\n    camera: {model: '" + kRoot +
      "/models/ers210_full.yaml', clock: {drift_ppm: 3.5, jitter_sigma_s: 0.001}}\n";
  return "format: seam-scenario/1\nname: full\nduration_s: 1.5\nlighting: {lambert: true, "
         "direction: [0.3, -0.2, 0.9], ambient: 0.3, diffuse: 0.7}\nrobots:\n"
         "  - id: legs\n    team: red\n    pose: {x_m: 0.1, y_m: 0.2, theta_rad: 0.3}\n" +
         ers210 +
         "    behaviour: {command: [head_swing, '--rate', '1e5'], decision_latency_s: 0.01}\n"
         "    sensors: {joints: {sigma: 0.002, latency_s: 0.004}}\n    head_rad: [0.1, 0.2, 0.05]\n"
         "  - id: arm\n    team: blue\n    pose: {x_m: 1.1, y_m: -0.2, theta_rad: 0.7}\n"
         "    token: secret\n    body: {urdf: scenarios/arm/arm.urdf, camera: {link: camera}}\n"
         "objects:\n"
         "  - {shape: rectangle, centre_m: [1, 2, 3], size_m: [4.2, 2.7], normal: [1, 1, 0.5], "
         "rgb: "
         "[0.1, 0.2, 0.3]}\n"
         "  - {shape: sphere, centre_m: [0.8, 0.1, 0.042], radius_m: 0.042, rgb: [0.9, 0.3, 0.02], "
         "velocity_mps: [0.1, 0.5, 0.2]}\n"
         "  - {shape: cylinder, base_m: [2.2, 1.45, 0.1], radius_m: 0.05, height_m: 0.4, rgb: "
         "[0.9, "
         "0.4, 0.5]}\n"
         "  - {shape: box, centre_m: [1.5, -0.5, 0.1], size_m: [0.27, 0.15, 0.2], yaw_rad: 0.4, "
         "rgb: [0.2, 0.2, 0.2]}\n"
         "  - {shape: board, pattern: chessboard, columns: 4, rows: 3, pitch_m: 0.03, pose: {x_m: "
         "0.5, roll_rad: 0.2, pitch_rad: -0.3, yaw_rad: 0.1}}\n";
}

using Leaves = std::map<std::string, std::string>;

// Each number and word of a document, by its path.
void each_leaf(YAML::Node node, const std::string& path,
               const std::function<void(const std::string&, YAML::Node)>& visit) {
  if (node.IsMap()) {
    for (auto item : node) each_leaf(item.second, path + "." + item.first.as<std::string>(), visit);
  } else if (node.IsSequence()) {
    for (size_t i = 0; i < node.size(); ++i)
      each_leaf(node[i], path + "[" + std::to_string(i) + "]", visit);
  } else {
    visit(path, node);
  }
}

Leaves leaves_of(const std::string& text) {
  Leaves leaves;
  each_leaf(YAML::Load(text), "", [&](const std::string& path, const YAML::Node& node) {
    leaves[path] = node.as<std::string>("");
  });
  return leaves;
}

bool is_time(const std::string& path) {
  return path.ends_with("_s") && !path.ends_with("bytes_per_s");
}
int64_t nanoseconds(const std::string& seconds) {
  return SimDuration::from_s(std::strtod(seconds.c_str(), nullptr)).ns();
}

// The numbers of a scenario a little off, with all their digits. Times are whole nanoseconds. What
// other layers read (a model's numbers) is kept as text whatever it is.
std::string disturbed(const std::string& text, RandomStream random) {
  YAML::Node root = YAML::Load(text);
  size_t place = 0;
  each_leaf(root, "", [&](const std::string& path, YAML::Node node) {
    const std::string old = node.as<std::string>("");
    double value = 0;
    size_t read = 0;
    try {
      value = std::stod(old, &read);
    } catch (const std::exception&) {
      return;
    }
    // Whole numbers (counts, seeds) have no last digits; the world's step is a multiple of others.
    const bool whole = old.find_first_not_of("-0123456789") == std::string::npos && value != 0;
    if (read != old.size() || whole || path == ".step_s") return;
    // At the end of a joint's range.
    if (value == 0 && (path.ends_with("start_rad") || path.ends_with("min_rad"))) return;
    const double u = uniform(random, place++);
    if (is_time(path))
      node = fmt::format("{:.9f}", value * (1 + 1e-3 * u) + (value == 0 ? 1e-3 * u : 0));
    else
      node = fmt::format("{}", value * (1 - 1e-6 * u) + (value == 0 ? 1e-4 * u : 0));
  });
  YAML::Emitter out;
  out << root;
  return out.c_str();
}

TEST(ScenarioText, WrittenAndReadItIsTheSameWhateverItsFieldsHold) {
  const std::string whole = Scenario::from_text(full_scenario(), kRoot + "/full.yaml").to_yaml();
  size_t others = 0;
  for (uint64_t trial = 0; trial < 8; ++trial) {
    const std::string given = disturbed(whole, RandomStream(trial).child("scenario"));
    const std::string once = Scenario::from_text(given, "given").to_yaml();
    ASSERT_EQ(Scenario::from_text(once, "once").to_yaml(), once) << trial;
    // What is kept is what was given, to the last digit.
    const Leaves wanted = leaves_of(given), kept = leaves_of(once), plain = leaves_of(whole);
    for (const auto& [path, value] : wanted) {
      ASSERT_TRUE(kept.contains(path)) << path;
      char* end = nullptr;
      const double number = std::strtod(value.c_str(), &end);
      if (*end != '\0' || value.empty())
        EXPECT_EQ(kept.at(path), value) << path;
      else if (is_time(path))
        EXPECT_EQ(nanoseconds(kept.at(path)), nanoseconds(value)) << path;
      else
        EXPECT_EQ(std::strtod(kept.at(path).c_str(), nullptr), number) << path;
      others += value != plain.at(path);
    }
  }
  EXPECT_GT(others, 8 * 200u) << "most numbers must have been changed";
}

TEST(ScenarioText, KeepsTextsAndWholeNumbersOfAnySort) {
  for (const std::string& text :
       {std::string("~"), std::string("true"), std::string("1e5"), std::string("0x10"),
        std::string(" spaces "), std::string("a: b # c"), std::string("'\"\\"),
        std::string("lines\nand\ttabs\r\n"), std::string("\xc3\xa4\xe2\x82\xac"), std::string("-"),
        std::string(""), std::string("null"), std::string("\x01\x7f"), std::string("<<"),
        std::string("00012"), std::string("1_000")}) {
    Scenario scenario = Scenario::from_text(full_scenario(), kRoot + "/full.yaml");
    scenario.name = scenario.description = text;
    scenario.robots[0].behaviour.command = {"head_swing", text, text};
    scenario.robots[1].token = text;
    scenario.supervisor_token = scenario.render_token = text;
    scenario.seed = std::numeric_limits<int64_t>::max();
    const std::string once = scenario.to_yaml();
    const Scenario again = Scenario::from_text(once, "again");
    EXPECT_EQ(again.to_yaml(), once) << text;
    EXPECT_EQ(again.name, text);
    EXPECT_EQ(again.description, text);
    EXPECT_EQ(again.robots[0].behaviour.command, scenario.robots[0].behaviour.command) << text;
    EXPECT_EQ(again.robots[1].token, text);
    EXPECT_EQ(again.supervisor_token, text);
    EXPECT_EQ(again.render_token, text);
    EXPECT_EQ(again.seed, scenario.seed);
  }
}

TEST(ScenarioText, TheWorldsLightHasLengthOneWhateverTheScenarioSays) {
  const Scenario scenario = Scenario::from_text(full_scenario(), kRoot + "/full.yaml");
  const Scenario again = Scenario::from_text(scenario.to_yaml(), "again");
  EXPECT_EQ(scenario.lighting.direction_W, Vec3(0.3, -0.2, 0.9));
  EXPECT_EQ(again.lighting.direction_W, scenario.lighting.direction_W);
  const Vec3 light = World(scenario).lighting().direction_W;
  EXPECT_NEAR(glm::length(light), 1, 1e-15);
  EXPECT_EQ(World(again).lighting().direction_W, light);
}

}  // namespace
}  // namespace seam
