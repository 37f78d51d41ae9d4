// `seam import`: files of other programs as a measurement set.
#include "app/import/import.h"

#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <limits>
#include <memory>
#include <utility>

#include "app/import/recognise.h"
#include "app/predictors/instruments.h"
#include "sim_core/base/error.h"
#include "tools/command.h"

namespace seam::tools {
namespace {

struct ImportFlags {
  std::string kind, out, map, unit, time_unit, length_unit, board, target, size, camera, part,
      title, reverse, off_where;
  std::optional<double> spacing, base, radius, metres_per_tick;
  std::vector<std::string> sources;
};

// What stands before and behind the sign in each entry of a list, OURS=THEIRS,OURS=THEIRS.
std::map<std::string, std::string> names_in(const std::string& map) {
  std::map<std::string, std::string> names;
  for (size_t start = 0; start < map.size();) {
    const size_t end = std::min(map.find(',', start), map.size());
    const std::string entry = map.substr(start, end - start);
    const size_t equals = entry.find('=');
    if (equals == std::string::npos || equals == 0 || equals + 1 == entry.size())
      throw UsageError(
          fmt::format("--map {}: expected OURS=THEIRS, like command=goal_position", entry));
    if (!names.emplace(entry.substr(0, equals), entry.substr(equals + 1)).second)
      throw UsageError(fmt::format("--map {}: '{}' stands twice", map, entry.substr(0, equals)));
    start = end + 1;
  }
  return names;
}

// A unit for all quantities, or UNIT,OURS=UNIT,... for some of their own: these go to `own`.
std::string units_in(const char* option, const std::string& text, void (*check)(const std::string&),
                     std::map<std::string, std::string>& own) {
  std::string general;
  for (size_t start = 0; start < text.size();) {
    const size_t end = std::min(text.find(',', start), text.size());
    const std::string entry = text.substr(start, end - start);
    const size_t equals = entry.find('=');
    const std::string unit = equals == std::string::npos ? entry : entry.substr(equals + 1);
    check(unit);
    if (equals != std::string::npos ? !own.emplace(entry.substr(0, equals), unit).second
                                    : !std::exchange(general, unit).empty())
      throw UsageError(
          fmt::format("{} {}: '{}' stands twice, expected one unit of each", option, text, entry));
    start = end + 1;
  }
  return general;
}

std::pair<int, int> pair_in(const std::string& flag, const std::string& text, const char* example) {
  if (text.empty()) return {0, 0};
  int first = 0, second = 0;
  char end = 0;
  if (std::sscanf(text.c_str(), "%6dx%6d%c", &first, &second, &end) != 2 || first < 2 || second < 2)
    throw UsageError(fmt::format("--{} {}: expected two counts, like {}", flag, text, example));
  return {first, second};
}

// Those that the user gave and that mean nothing to the kind.
void check_options(const ImportFlags& flags, const app::ImportKind& kind) {
  const std::pair<const char*, bool> given[] = {
      {"map", !flags.map.empty()},
      {"unit", !flags.unit.empty()},
      {"time-unit", !flags.time_unit.empty()},
      {"length-unit", !flags.length_unit.empty()},
      {"board", !flags.board.empty()},
      {"spacing", flags.spacing.has_value()},
      {"target", !flags.target.empty()},
      {"size", !flags.size.empty()},
      {"camera", !flags.camera.empty()},
      {"part", !flags.part.empty()},
      {"reverse", !flags.reverse.empty()},
      {"off-where", !flags.off_where.empty()},
      {"base", flags.base.has_value()},
      {"radius", flags.radius.has_value()},
      {"metres-per-tick", flags.metres_per_tick.has_value()},
  };
  for (const auto& [option, is_given] : given) {
    const bool known =
        std::find(kind.options.begin(), kind.options.end(), option) != kind.options.end();
    if (is_given && !known)
      throw UsageError(fmt::format("--{} means nothing to {}, whose options are --{}", option,
                                   kind.name, fmt::join(kind.options, ", --")));
  }
}

// SIGNAL=VALUE, where a value of "none" is a blank cell.
std::pair<std::string, double> off_where_in(const std::string& text) {
  const size_t equals = text.find('=');
  const std::string value = equals == std::string::npos ? "" : text.substr(equals + 1);
  const bool none = value == "none";
  double number = std::numeric_limits<double>::quiet_NaN();
  const auto [end, error] = std::from_chars(value.data(), value.data() + value.size(), number);
  const bool is_number =
      error == std::errc() && end == value.data() + value.size() && std::isfinite(number);
  if (equals == 0 || value.empty() || (!none && !is_number))
    throw UsageError(
        fmt::format("--off-where {}: expected SIGNAL=NUMBER or SIGNAL=none, like command=0", text));
  return {text.substr(0, equals), none ? std::numeric_limits<double>::quiet_NaN() : number};
}

std::vector<std::string> listed(const std::string& text) {
  std::vector<std::string> names;
  for (size_t start = 0; start < text.size();) {
    const size_t end = std::min(text.find(',', start), text.size());
    if (end > start) names.push_back(text.substr(start, end - start));
    start = end + 1;
  }
  return names;
}

app::ImportRequest request_of(const ImportFlags& flags) {
  app::ImportRequest request{.names = names_in(flags.map),
                             .reversed = listed(flags.reverse),
                             .target = flags.target,
                             .camera = flags.camera,
                             .part = flags.part};
  for (const std::string& source : flags.sources) request.sources.emplace_back(source);
  std::tie(request.board_columns, request.board_rows) = pair_in("board", flags.board, "9x6");
  std::tie(request.width_px, request.height_px) = pair_in("size", flags.size, "640x480");
  if (!flags.off_where.empty()) request.off_where = off_where_in(flags.off_where);
  // A unit that is none is said before anything is read.
  const auto units = [&](const char* option, const std::string& text, auto check) {
    return units_in(option, text, check, request.own_units);
  };
  request.unit = units("--unit", flags.unit, [](const std::string& u) { app::radians_in(u); });
  request.time_unit =
      units("--time-unit", flags.time_unit, [](const std::string& u) { app::nanoseconds_in(u); });
  request.length_unit =
      units("--length-unit", flags.length_unit, [](const std::string& u) { app::metres_in(u); });
  const double metres = request.length_unit.empty() ? 1 : app::metres_in(request.length_unit);
  const auto length = [&](const char* option, std::optional<double> value, double factor) {
    if (value && !(*value > 0 && *value < 1e6))
      throw UsageError(fmt::format("--{} {}: expected a distance above 0", option, *value));
    return value.value_or(0) * factor;
  };
  request.spacing_m = length("spacing", flags.spacing, metres);
  request.base_m = length("base", flags.base, metres);
  request.radius_m = length("radius", flags.radius, metres);
  request.metres_per_tick = length("metres-per-tick", flags.metres_per_tick, 1);
  return request;
}

std::string kinds_help() {
  std::string help = "Kinds:\n";
  for (const app::ImportKind& kind : app::import_kinds()) {
    help += fmt::format("  {:9} {}\n", kind.name, kind.help);
    if (!kind.options.empty())
      help += fmt::format("            --{}\n", fmt::join(kind.options, ", --"));
    if (!kind.quantities.empty())
      help += fmt::format("            names for --map: {}\n", fmt::join(kind.quantities, ", "));
  }
  return help;
}

}  // namespace

void add_import(app::Command app) {
  app::Command command = app.add_subcommand(
      "import", "Makes a measurement set with a nominal model from files of other programs");
  auto flags = std::make_shared<ImportFlags>();
  command.add_option("KIND", flags->kind, "What the files are").required();
  command.add_option("SOURCE", flags->sources, "The files or folders").required();
  command.add_option("--out", flags->out, "The folder to write, a new or an empty one").required();
  command.add_option(
      "--map", flags->map,
      "The files' names of SEAM's quantities: OURS=THEIRS,OURS=THEIRS, like command=goal");
  command.add_option(
      "--unit", flags->unit,
      "Of angles: rad, mrad, deg, turns or ticks:N a turn; OURS=UNIT,... for single ones");
  command.add_option("--time-unit", flags->time_unit, "Of times: s, ms, us or ns; likewise");
  command.add_option("--length-unit", flags->length_unit,
                     "Of lengths: m, cm, mm, um or in; likewise");
  command
      .add_option("--target", flags->target,
                  "What is on a target of pictures (default: chessboard)")
      .one_of({"chessboard", "circles", "asymmetric_circles"});
  command.add_option("--board", flags->board,
                     "Inner corners or circles of the target, COLUMNSxROWS");
  command.add_option("--spacing", flags->spacing,
                     "Between the target's corners, in metres or the unit of --length-unit");
  command.add_option("--base", flags->base,
                     "Between the two wheels of a body, in metres or the unit of --length-unit; "
                     "left out: estimated");
  command.add_option("--radius", flags->radius,
                     "Of these wheels, likewise; with --unit left=ticks:N a turn");
  command.add_option("--metres-per-tick", flags->metres_per_tick,
                     "Instead of the radius: how far a wheel rolls for each tick");
  command.add_option("--part", flags->part, "What of a log: joints, odometry or frames")
      .one_of({"joints", "odometry", "frames"});
  command.add_option("--size", flags->size, "Of the images, WIDTHxHEIGHT in pixels");
  command.add_option("--camera", flags->camera,
                     "Which camera or robot, where the files hold several; of pictures also "
                     "several, for a set of a rig: left,right");
  command.add_option("--reverse", flags->reverse,
                     "Joints whose measured angles count the other way than their commands: "
                     "JOINT,JOINT; they get the other sign");
  command.add_option("--off-where", flags->off_where,
                     "Rows in which the drive is off, by a value of a signal: command=0, or "
                     "command=none for a blank cell; they get torque_enable 0");
  command.add_option("--title", flags->title, "A line for people");
  command.footer(
      kinds_help() +
      "The set holds measurement.yaml, its tables and nominal.yaml, the model to start from. It "
      "is\n"
      "opened and checked as analyses do before it gets its name; what was done and what the "
      "files\n"
      "do not say is printed and kept in measurement.yaml under `imported`.\n"
      "Example: seam import servo log.csv --map command=goal,measured=angle --unit deg --out arm");
  command.callback([flags] {
    const app::ImportKind& kind = app::import_kind_named(flags->kind);
    check_options(*flags, kind);
    const app::ImportRequest request = request_of(*flags);
    const std::string text =
        app::import_set(kind, request, flags->title, flags->out, app::instruments());
    std::printf("%s", text.c_str());
  });
}

}  // namespace seam::tools
