// `seam new-effect NAME --stage S`: a working template of an effect, as a plugin that builds
// outside the tree, with a test by its worked examples. Its file can be moved into
// effects/catalogue/STAGE/ as it is.
#include <algorithm>
#include <cstdio>
#include <filesystem>

#include "effects/registry.h"
#include "sim_core/base/error.h"
#include "sim_core/base/output.h"
#include "tools/command.h"

namespace seam::tools {
namespace {

// What differs between stages: kinds, header, and a hook with two worked examples.
struct StageTemplate {
  const char* stage;
  const char* kinds;
  const char* header;
  const char* hook;
  const char* given;     // Of its two worked examples: what is given,
  const char* expected;  // which quantity is expected,
  double at_small;       // and its value at size 0.01
  double at_large;       // and at size 0.2.
};

// Lower-case letters, digits and '_', of which the first is a letter.
bool is_effect_name(const std::string& name) {
  const auto is_letter = [](char c) { return c >= 'a' && c <= 'z'; };
  return !name.empty() && is_letter(name[0]) && std::all_of(name.begin(), name.end(), [&](char c) {
    return is_letter(c) || (c >= '0' && c <= '9') || c == '_';
  });
}

// As clang-format lays it out behind its name.
const char* const kGain =
    "gain =\n          [](Values p, const ImagePoint& point) {\n"
    "            return p[0] == 0 ? 1 : 1 - p[0] * point.v / point.height_px;\n          }";

const StageTemplate kTemplates[] = {
    {"timing", "kPoints | kFrames", "stages/timing.h",
     "timing = [](Values p, Timing& timing) { timing.latency_s += p[0]; }", "{\"stamp_s\", 1}",
     "start_s", 1.01, 1.2},
    {"joint", "kJoints | kRanges", "stages/servo.h",
     "servo = [](Values p, ServoModel& servo) { servo.sag_rad += p[0]; }",
     "{\"command_s\", 0}, {\"command_rad\", 0}, {\"at_s\", 0.1}", "joint_rad", -0.01, -0.2},
    {"mount", "kPoints | kLandmarks | kFrames", "model.h",
     "mount = [](Values p, Pose& X_LC) { X_LC.p.x += p[0]; }", "{\"z_m\", 2}", "link_x_m", 2.01,
     2.2},
    {"geometry", "kPoints | kFrames", "stages/geometry.h",
     "geometry = [](Values p, ImagePoint& point) { point.cx += p[0]; }", "{\"z_m\", 1}", "u_px",
     88.51, 88.7},
    {"corner_detector", "kPoints", "stages/geometry.h",
     "corner_detector = [](Values p, ImagePoint& point) { point.u += p[0]; }", "{\"z_m\", 1}",
     "u_px", 88.51, 88.7},
    {"radiometry", "kPhotometry | kFrames", "stages/optics.h", kGain, "{\"v_px\", 72}", "gain",
     0.995, 0.9},
    {"light", "kPhotometry", "stages/optics.h", kGain, "{\"v_px\", 72}", "gain", 0.995, 0.9},
    {"sensor", "kPhotometry | kFrames", "stages/sensor/sensor.h",
     "sensor = [](Values p, SensorChain& chain) { chain.black_dn += p[0]; }", "{\"light\", 0.5}",
     "mean_dn", 108.01, 108.2},
    {"detector", "kLandmarks", "stages/detector.h",
     "detector = [](Values p, Detection& seen) { seen.range_m += p[0]; }", "{\"range_m\", 2}",
     "range_m", 2.01, 2.2},
    {"locomotion", "kOdometry", "stages/walk/locomotion.h",
     "locomotion = [](Values p, Locomotion& walk) { walk.vx_scale += p[0]; }",
     "{\"vx_mps\", 0.2}, {\"for_s\", 5}", "x_m", 1.01, 1.2},
    {"target", "kPoints", "stages/target.h",
     "target = [](Values p, TargetShape& shape) { shape.warp_x_m += p[0]; }", "{\"half_m\", 1}",
     "z_m", 0.01, 0.2},
};

// A worked example as clang-format lays it out.
std::string example_text(const StageTemplate& t, double size, double expected, size_t behind) {
  const std::string parts[] = {fmt::format(".values = {{{}}},", size),
                               fmt::format(".given = {{{}}},", t.given),
                               fmt::format(".expected = {{{{\"{}\", {}}}}}", t.expected, expected)};
  constexpr size_t kIndent = 16, kColumns = 100;
  const bool fits =
      kIndent + parts[0].size() + parts[1].size() + parts[2].size() + 4 + behind <= kColumns;
  const std::string between = fits ? " " : "\n" + std::string(kIndent + 1, ' ');
  return "{" + parts[0] + between + parts[1] + between + parts[2] + "}";
}

std::string effect_text(const std::string& name, const StageTemplate& t) {
  return fmt::format(R"(// {0}: say here what it is and where its formula comes from.
#include "effects/{1}"

namespace seam::effects {{

EffectDefinition {0}() {{
  return {{
      .name = "{0}",
      .stage = Stage::{2},
      .kinds = {3},
      .parameters = {{{{.name = "size",
                      .min = -0.5,
                      .max = 0.5,
                      .scale = 0.01,
                      .help = "What it is, in which unit, with which sign."}}}},
      .help = "What the effect is, in a sentence.",
      .formula = "its formula",
      .signature = "what it leaves in residuals when it is missing",
      .example = "{0}: {{size: 0.01}}",
      // Sines, powers and the like: sim_core/base/maths.h, so that all machines give the same bits.
      .{4},
      // Two or more, computed elsewhere: by hand, or by a few lines of another program.
      .proof = {{{5},
                {6}}},
  }};
}}

}}  // namespace seam::effects
)",
                     name, t.header, t.stage, t.kinds, t.hook, example_text(t, 0.01, t.at_small, 1),
                     example_text(t, 0.2, t.at_large, 2));
}

std::filesystem::path own_program() {
  std::error_code error;
  return std::filesystem::read_symlink("/proc/self/exe", error);
}

// The headers that belong to this program: beside it where it is installed, else those of the tree
// that it was built from.
std::string own_headers() {
  const std::filesystem::path program = own_program();
  const auto installed = program.parent_path().parent_path() / "include/seam";
  return std::filesystem::exists(installed / "effects/plugin.h") ? installed.string()
                                                                 : SEAM_SOURCE_DIR;
}

std::string cmake_text(const std::string& name) {
  return fmt::format(R"(cmake_minimum_required(VERSION 3.25)
project({0} LANGUAGES CXX)
# The headers and the program of the SEAM that wrote this file.
# Others: -DSEAM_INCLUDE=DIR -DSEAM_PROGRAM=FILE.
find_path(SEAM_INCLUDE effects/plugin.h HINTS "{1}" PATH_SUFFIXES seam REQUIRED)
find_program(SEAM_PROGRAM seam HINTS "{2}" REQUIRED)
find_package(fmt REQUIRED)
enable_testing()

# Functions of SEAM (sim_core/base/maths.h) are found in the program that loads the plugin.
add_library({0} MODULE {0}.cc plugin.cc)
set_target_properties({0} PROPERTIES PREFIX "")
target_include_directories({0} PRIVATE ${{SEAM_INCLUDE}})
target_compile_features({0} PRIVATE cxx_std_20)
target_compile_options({0} PRIVATE -ffp-contract=off)
target_link_libraries({0} PRIVATE fmt::fmt)
# Whatever its hook: the worked examples are met, and the effect is absent at its neutral values.
add_test(NAME {0} COMMAND ${{SEAM_PROGRAM}} --plugin $<TARGET_FILE:{0}> effects {0} --prove)
)",
                     name, own_headers(), own_program().parent_path().string());
}

std::string plugin_text(const std::string& name) {
  return fmt::format(R"(#include "effects/plugin.h"

namespace seam::effects {{
EffectDefinition {0}();
}}

SEAM_PLUGIN(effects) {{
  effects.push_back(seam::effects::{0}());
}}
)",
                     name);
}

std::string next_steps(const std::string& name, const std::string& stage,
                       const std::filesystem::path& folder) {
  return fmt::format(
      "{1}: an effect of stage {2}, and a plugin of it.\n"
      "Build it, and compare it with its worked examples:\n"
      "  cmake -S {1} -B {1}/build && cmake --build {1}/build && ctest --test-dir {1}/build\n"
      "  seam --plugin {1}/build/{0}.so effects {0}\n"
      "Into SEAM: {0}.cc belongs into effects/catalogue/{2}/ as it is (docs/effect.md)\n",
      name, folder.string(), stage);
}

}  // namespace

void add_new_effect(app::Command app) {
  app::Command command = app.add_subcommand(
      "new-effect", "Writes a working template of an effect, with a test by its worked examples");
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
      "Examples:\n  seam new-effect camera_slip --stage geometry\n"
      "  cmake -S camera_slip -B build-slip && cmake --build build-slip\n"
      "  seam --plugin build-slip/camera_slip.so effects camera_slip --prove");
  command.callback([name, stage, out] {
    if (!is_effect_name(*name)) {
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
    make_output_folder(folder);
    const std::filesystem::path source = folder / (*name + ".cc");
    if (std::filesystem::exists(source))
      throw InputError(fmt::format("{}: exists already", source.string()));
    write_file_atomically(source, effect_text(*name, *found));
    write_file_atomically(folder / "plugin.cc", plugin_text(*name));
    write_file_atomically(folder / "CMakeLists.txt", cmake_text(*name));
    std::fputs(next_steps(*name, *stage, folder).c_str(), stdout);
  });
}

}  // namespace seam::tools
