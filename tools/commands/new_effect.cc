// `seam new-effect NAME --stage S`: a working template of an effect with its test, as a plugin
// that builds outside the tree; its file can be moved into effects/catalogue/STAGE/ as it is.
#include <cstdio>
#include <filesystem>
#include <regex>

#include "effects/registry.h"
#include "sim_core/base/error.h"
#include "sim_core/base/output.h"
#include "tools/command.h"

namespace seam::tools {
namespace {

// What differs between stages: kinds, header, hook, and what the example's hook does.
struct StageTemplate {
  const char* stage;
  const char* kinds;
  const char* header;
  const char* hook;
  const char* test;
  const char* given;     // Of its two worked examples: what is given,
  const char* expected;  // which quantity is expected,
  double at_small;       // and its value at size 0.01
  double at_large;       // and at size 0.2.
};

const StageTemplate kTemplates[] = {
    {"timing", "kPoints | kFrames", "stages/timing.h",
     "      .timing = [](Values p, Timing& timing) { timing.latency_s += p[0]; },\n",
     "  seam::effects::Timing timing;\n  effect.timing(values, timing);\n  return "
     "timing.latency_s;\n",
     "{\"stamp_s\", 1}", "start_s", 1.01, 1.2},
    {"joint", "kJoints | kRanges", "stages/servo.h",
     "      .servo = [](Values p, ServoModel& servo) { servo.latency_s += p[0]; },\n",
     "  seam::effects::ServoModel servo;\n  effect.servo(values, servo);\n  return "
     "servo.latency_s;\n",
     "{\"command_s\", 0}, {\"command_rad\", 0.5}, {\"at_s\", 0.1}", "joint_rad", 0.5, 0},
    {"mount", "kPoints | kLandmarks | kFrames", "model.h",
     "      .mount = [](Values p, Pose& X_LC) { X_LC.p.x += p[0]; },\n",
     "  seam::Pose X_LC;\n  effect.mount(values, X_LC);\n  return X_LC.p.x;\n", "{\"z_m\", 2}",
     "link_x_m", 2.01, 2.2},
    {"geometry", "kPoints | kFrames", "stages/geometry.h",
     "      .geometry = [](Values p, ImagePoint& point) { point.cx += p[0]; },\n",
     "  seam::effects::ImagePoint point;\n  effect.geometry(values, point);\n  return point.cx;\n",
     "{\"z_m\", 1}", "u_px", 88.51, 88.7},
    {"corner_detector", "kPoints", "stages/geometry.h",
     "      .corner_detector = [](Values p, ImagePoint& point) { point.u += p[0]; },\n",
     "  seam::effects::ImagePoint point;\n  effect.corner_detector(values, point);\n  return "
     "point.u;\n",
     "{\"z_m\", 1}", "u_px", 88.51, 88.7},
    {"radiometry", "kPhotometry | kFrames", "stages/optics.h",
     "      .gain = [](Values p, const ImagePoint& point) { return p[0] == 0 ? 1 : 1 - p[0] * "
     "point.v / point.height_px; },\n",
     "  const seam::effects::ImagePoint point{.v = 72, .width_px = 178, .height_px = 144};\n"
     "  return 1 - effect.gain(values, point);\n",
     "{\"v_px\", 72}", "gain", 0.995, 0.9},
    {"light", "kPhotometry", "stages/optics.h",
     "      .gain = [](Values p, const ImagePoint& point) { return p[0] == 0 ? 1 : 1 - p[0] * "
     "point.v / point.height_px; },\n",
     "  const seam::effects::ImagePoint point{.v = 72, .width_px = 178, .height_px = 144};\n"
     "  return 1 - effect.gain(values, point);\n",
     "{\"v_px\", 72}", "gain", 0.995, 0.9},
    {"sensor", "kPhotometry | kFrames", "stages/sensor/sensor.h",
     "      .sensor = [](Values p, SensorChain& chain) { chain.black_dn += p[0]; },\n",
     "  seam::effects::SensorChain chain;\n  effect.sensor(values, chain);\n  return "
     "chain.black_dn;\n",
     "{\"light\", 0.5}", "mean_dn", 108.01, 108.2},
    {"detector", "kLandmarks", "stages/detector.h",
     "      .detector = [](Values p, Detection& seen) { seen.range_m += p[0]; },\n",
     "  seam::effects::Detection seen;\n  effect.detector(values, seen);\n  return "
     "seen.range_m;\n",
     "{\"range_m\", 2}", "range_m", 2.01, 2.2},
    {"locomotion", "kOdometry", "stages/walk/locomotion.h",
     "      .locomotion = [](Values p, Locomotion& walk) { walk.vx_scale += p[0]; },\n",
     "  seam::effects::Locomotion walk;\n  effect.locomotion(values, walk);\n  return "
     "walk.vx_scale;\n",
     "{\"vx_mps\", 0.2}, {\"for_s\", 5}", "x_m", 1.01, 1.2},
    {"target", "kPoints", "stages/target.h",
     "      .target = [](Values p, TargetShape& shape) { shape.warp_x_m += p[0]; },\n",
     "  seam::effects::TargetShape shape;\n  effect.target(values, shape);\n  return "
     "shape.warp_x_m;\n",
     "{\"half_m\", 1}", "z_m", 0.01, 0.2},
};

std::string effect_text(const std::string& name, const StageTemplate& t) {
  return fmt::format(R"(// {0}: say here what it is and where its formula comes from.
#include "effects/{1}"

namespace seam::effects {{

EffectDefinition {0}() {{
  return {{
      .name = "{0}",
      .stage = Stage::{2},
      .kinds = {3},
      .parameters = {{{{.name = "size", .min = -0.5, .max = 0.5, .scale = 0.01,
                      .help = "What it is, in which unit, with which sign."}}}},
      .help = "What the effect is, in a sentence.",
      .formula = "its formula",
      .signature = "what it leaves in residuals when it is missing",
      .example = "{0}: {{size: 0.01}}",
{4}      // Two or more, computed elsewhere: by hand, or by a few lines of another program.
      .proof = {{{{.values = {{0.01}}, .given = {{{5}}}, .expected = {{{{"{6}", {7}}}}}}},
                {{.values = {{0.2}}, .given = {{{5}}}, .expected = {{{{"{6}", {8}}}}}}}}},
  }};
}}

}}  // namespace seam::effects
)",
                     name, t.header, t.stage, t.kinds, t.hook, t.given, t.expected, t.at_small,
                     t.at_large);
}

std::string test_text(const std::string& name, const StageTemplate& t) {
  return fmt::format(
      R"(// A plain program: exit code 0 when the effect is absent at its neutral value and acts otherwise.
#include <cmath>
#include <cstdio>

#include "effects/{1}"

namespace seam::effects {{
EffectDefinition {0}();
}}

// How far the effect moves what it acts on.
double moved_by(double size) {{
  const seam::effects::EffectDefinition effect = seam::effects::{0}();
  const double numbers[] = {{size}};
  const seam::effects::Values values(numbers);
{2}}}

int main() {{
  const double start = moved_by(0);
  const bool absent = std::abs(start) == 0;
  const bool acts = std::abs(moved_by(0.01) - start) > 0;
  std::printf("neutral is absent: %s, acts: %s\n", absent ? "yes" : "no", acts ? "yes" : "no");
  return absent && acts ? 0 : 1;
}}
)",
      name, t.header, t.test);
}

// The headers that belong to this program: beside it where it is installed, else those of the tree
// that it was built from.
std::string own_headers() {
  std::error_code error;
  const auto program = std::filesystem::read_symlink("/proc/self/exe", error);
  const auto installed = program.parent_path().parent_path() / "include/seam";
  return std::filesystem::exists(installed / "effects/plugin.h") ? installed.string()
                                                                 : SEAM_SOURCE_DIR;
}

std::string cmake_text(const std::string& name) {
  return fmt::format(R"(cmake_minimum_required(VERSION 3.25)
project({0} LANGUAGES CXX)
# The headers of the SEAM that wrote this file; others: -DSEAM_INCLUDE=DIR.
find_path(SEAM_INCLUDE effects/plugin.h HINTS "{1}" PATH_SUFFIXES seam REQUIRED)
find_package(fmt REQUIRED)
enable_testing()

add_library({0} MODULE {0}.cc plugin.cc)
set_target_properties({0} PROPERTIES PREFIX "")
add_executable(test_{0} {0}.cc {0}.test.cc)
foreach(target {0} test_{0})
  target_include_directories(${{target}} PRIVATE ${{SEAM_INCLUDE}})
  target_compile_features(${{target}} PRIVATE cxx_std_20)
  target_compile_options(${{target}} PRIVATE -ffp-contract=off)
  target_link_libraries(${{target}} PRIVATE fmt::fmt)
endforeach()
add_test(NAME {0} COMMAND test_{0})
)",
                     name, own_headers());
}

std::string plugin_text(const std::string& name) {
  return fmt::format(R"(#include "effects/plugin.h"

namespace seam::effects {{
EffectDefinition {0}();
}}

SEAM_PLUGIN(effects) {{ effects.push_back(seam::effects::{0}()); }}
)",
                     name);
}

}  // namespace

void add_new_effect(app::Command app) {
  app::Command command =
      app.add_subcommand("new-effect", "Writes a working template of an effect, with its test");
  auto name = std::make_shared<std::string>(), stage = std::make_shared<std::string>(),
       out = std::make_shared<std::string>();
  command.add_option("NAME", *name, "Its name, in lower_case").required();
  command
      .add_option(
          "--stage", *stage,
          "timing, joint, mount, geometry (the lens, as images show it, too), corner_detector "
          "(where "
          "a detector reports a point: measured points alone), radiometry, light, sensor, detector "
          "(of ranges and bearings), locomotion or target")
      .required();
  command.add_option("--out", *out, "The folder to write (default: NAME)");
  command.footer(
      "Examples:\n  seam new-effect thermal_focus --stage geometry\n"
      "  cmake -S thermal_focus -B build-focus && cmake --build build-focus\n"
      "  seam --plugin build-focus/thermal_focus.so effects thermal_focus");
  command.callback([name, stage, out] {
    if (!std::regex_match(*name, std::regex("[a-z][a-z0-9_]*"))) {
      throw UsageError(
          fmt::format("'{}' is no name for an effect, expected lower_case letters", *name));
    }
    if (effects::find_effect(*name))
      throw UsageError(fmt::format("effect '{}' exists already, expected a new name", *name));
    const StageTemplate* found = nullptr;
    std::vector<std::string> stages;
    for (const StageTemplate& t : kTemplates) {
      stages.push_back(t.stage);
      if (*stage == t.stage) found = &t;
    }
    if (!found)
      throw UsageError(fmt::format("unknown stage '{}'{}", *stage, suggestion_for(*stage, stages)));
    const std::filesystem::path folder = out->empty() ? *name : *out;
    std::filesystem::create_directories(folder);
    const std::filesystem::path source = folder / (*name + ".cc");
    if (std::filesystem::exists(source))
      throw InputError(fmt::format("{}: exists already", source.string()));
    write_file_atomically(source, effect_text(*name, *found));
    write_file_atomically(folder / (*name + ".test.cc"), test_text(*name, *found));
    write_file_atomically(folder / "plugin.cc", plugin_text(*name));
    write_file_atomically(folder / "CMakeLists.txt", cmake_text(*name));
    std::printf(
        "%s: an effect of stage %s, its test, and a plugin of it.\n"
        "  cmake -S %s -B %s/build && cmake --build %s/build && ctest "
        "--test-dir %s/build\n"
        "  seam --plugin %s/build/%s.so effects %s\n",
        folder.c_str(), stage->c_str(), folder.c_str(), folder.c_str(), folder.c_str(),
        folder.c_str(), folder.c_str(), name->c_str(), name->c_str());
  });
}

}  // namespace seam::tools
