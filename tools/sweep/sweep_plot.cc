// `seam sweep plot`: a statistic against one or two parameters, drawn by gnuplot.
#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <filesystem>

#include "app/scratch_folder.h"
#include "app/sweep/curve.h"
#include "app/sweep/table.h"
#include "sim_core/base/error.h"
#include "sim_core/base/files.h"
#include "sim_core/base/output.h"
#include "tools/command.h"
#include "tools/experiments/plot.h"
#include "tools/sweep/sweep.h"

namespace seam::tools {
namespace {

namespace fs = std::filesystem;

struct SweepPlotOptions {
  std::string file, value, over, by, statistic = "mean", out, csv;
};

app::CurveStatistic statistic_named(const std::string& name) {
  const auto* found =
      std::find(std::begin(app::kCurveStatistics), std::end(app::kCurveStatistics), name);
  return static_cast<app::CurveStatistic>(found - std::begin(app::kCurveStatistics));
}

bool is_number(const std::string& text) {
  double number = 0;
  const auto [rest, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  return error == std::errc() && rest == text.data() + text.size();
}

std::string cell_of(const std::optional<double>& value) {
  return value && std::isfinite(*value) ? fmt::format("{}", *value) : "";
}

std::string curve_csv(const SweepPlotOptions& options, const std::vector<app::CurvePoint>& points) {
  std::vector<std::string> header = {options.over};
  if (!options.by.empty()) header.push_back(options.by);
  header.insert(header.end(), {"n", options.statistic, "low", "high"});
  std::string csv = app::csv_line(header);
  for (const app::CurvePoint& point : points) {
    std::vector<std::string> cells = {point.x};
    if (!options.by.empty()) cells.push_back(point.by);
    cells.insert(cells.end(), {fmt::format("{}", point.count), cell_of(point.estimate.value),
                               cell_of(point.estimate.low), cell_of(point.estimate.high)});
    csv += app::csv_line(cells);
  }
  return csv;
}

// Text between gnuplot's double quotes.
std::string gnuplot_text(const std::string& text) {
  std::string quoted = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') quoted += '\\';
    quoted += c == '\n' ? ' ' : c;
  }
  return quoted + '"';
}

std::string label(const std::string& text) {
  return gnuplot_text(text) + " noenhanced";
}

// "ball error (m)" of ball_error_m: names end in their unit.
std::string named_with_unit(std::string name) {
  constexpr const char* kUnits[][2] = {{"_px", "px"},   {"_mps", "m/s"}, {"_radps", "rad/s"},
                                       {"_rad", "rad"}, {"_dn", "DN"},   {"_mm", "mm"},
                                       {"_m", "m"},     {"_ms", "ms"},   {"_ns", "ns"},
                                       {"_us", "us"},   {"_s", "s"},     {"_hz", "Hz"}};
  std::string unit;
  for (const auto& [ending, written] : kUnits) {
    if (!unit.empty() || !name.ends_with(ending) || name.size() == std::string(ending).size())
      continue;
    unit = fmt::format(" ({})", written);
    name.resize(name.size() - std::string(ending).size());
  }
  std::replace(name.begin(), name.end(), '_', ' ');
  return name + unit;
}

// Words instead of numbers stand side by side, in the order of the plan.
std::string data_of(const std::vector<app::CurvePoint>& points, const std::string& series,
                    const std::vector<std::string>& words) {
  std::string data;
  for (const app::CurvePoint& point : points) {
    if (point.by != series || !std::isfinite(point.estimate.value)) continue;
    const auto place = std::find(words.begin(), words.end(), point.x) - words.begin();
    data += fmt::format("{},{},{},{}\n", words.empty() ? point.x : fmt::format("{}", place),
                        point.estimate.value, point.estimate.low.value_or(point.estimate.value),
                        point.estimate.high.value_or(point.estimate.value));
  }
  return data;
}

std::vector<std::string> in_order(const std::vector<app::CurvePoint>& points,
                                  std::string app::CurvePoint::*member) {
  std::vector<std::string> words;
  for (const app::CurvePoint& point : points) {
    if (std::find(words.begin(), words.end(), point.*member) == words.end())
      words.push_back(point.*member);
  }
  return words;
}

// In the colours and with the thin frame of the report's plots.
std::string look_of(const std::string& kind, size_t series) {
  constexpr const char* kTerminals[][2] = {
      {"png", "pngcairo size 1440,900 fontscale 1.6 font 'DejaVu Sans,12' background '#ffffff'"},
      {"svg",
       "svg size 720,450 dynamic font 'Inter,DejaVu Sans,sans-serif,12' background '#ffffff'"},
      {"pdf", "pdfcairo size 16cm,10cm fontscale 0.7 font 'DejaVu Sans,12'"}};
  std::string script;
  for (const auto& [name, terminal] : kTerminals)
    if (kind == name) script = fmt::format("set terminal {}\n", terminal);
  script += fmt::format("set datafile separator ','\nset output 'plot.{}'\n", kind);
  script +=
      "set border 3 lc rgb '#8a93a0' lw 1\nset tics nomirror scale 0.5 textcolor rgb '#4a5462'\n"
      "set xlabel textcolor rgb '#18202b'\nset ylabel textcolor rgb '#18202b'\n"
      "set grid y lc rgb '#e2e5e9' lt 1 lw 1\n"
      "set key outside right top Left reverse samplen 2 width 1 textcolor rgb '#18202b'\n"
      "set bars 0\n";
  constexpr const char* kColours[] = {"#0072b2", "#d55e00", "#009e73", "#cc79a7",
                                      "#e69f00", "#56b4e9", "#4a5462"};
  for (size_t i = 0; i < series; ++i)
    script += fmt::format("set linetype {} lc rgb '{}' lw 1.5 pt 7 ps 0.6\n", i + 1,
                          kColours[i % std::size(kColours)]);
  return script;
}

// Draws in a folder of its own; returns whether there is a picture.
bool draw(const SweepPlotOptions& options, const std::vector<app::CurvePoint>& points,
          const std::string& kind, const fs::path& folder) {
  const bool numeric = std::all_of(points.begin(), points.end(),
                                   [](const auto& point) { return is_number(point.x); });
  const std::vector<std::string> words =
      numeric ? std::vector<std::string>() : in_order(points, &app::CurvePoint::x);
  const std::vector<std::string> series = in_order(points, &app::CurvePoint::by);
  const bool banded = numeric && in_order(points, &app::CurvePoint::x).size() > 1;
  std::string script = look_of(kind, series.size());
  script += fmt::format("set xlabel {}\nset ylabel {}\n", label(named_with_unit(options.over)),
                        label(options.statistic + " of " + named_with_unit(options.value)));
  for (size_t i = 0; i < words.size(); ++i)
    script += fmt::format("{} ({} {})\n", i == 0 ? "set xtics" : "set xtics add",
                          gnuplot_text(words[i]), i);
  script += "set offsets graph 0.05, graph 0.05, 0, 0\nplot ";
  for (size_t i = 0; i < series.size(); ++i) {
    const std::string file = fmt::format("data{}.csv", i);
    write_file_atomically(folder / file, data_of(points, series[i], words));
    const std::string title =
        options.by.empty() ? "notitle"
                           : "title " + label(named_with_unit(options.by) + " = " + series[i]);
    // Along a quantity the interval is a band; words and a single value have a bar each.
    const std::string before = i == 0 ? "" : ", ";
    script += banded ? fmt::format(
                           "{0}'{1}' using 1:3:4 with filledcurves lt {2} fs transparent solid "
                           "0.15 noborder notitle, '' using 1:2 with linespoints lt {2} {3}",
                           before, file, i + 1, title)
                     : fmt::format("{0}'{1}' using 1:2:3:4 with yerrorbars lt {2} {3}", before,
                                   file, i + 1, title);
  }
  return run_gnuplot(folder, "plot." + kind, script + "\n");
}

// What the picture is to be, by its name.
std::string kind_of_picture(const std::string& out) {
  const std::string ending = fs::path(out).extension().string();
  for (const char* kind : {"png", "svg", "pdf"})
    if (ending == std::string(".") + kind) return kind;
  throw UsageError(fmt::format("--out {}: expected a name that ends in .png, .svg or .pdf", out));
}

void plot_results(const SweepPlotOptions& options) {
  const std::string kind = options.out.empty() ? "" : kind_of_picture(options.out);
  OutputFile picture(options.out, {.inputs = {options.file}});
  OutputFile csv(options.csv, {.inputs = {options.file, options.out}});
  const auto results = app::ResultsFile::for_reading(options.file);
  const auto points = app::curve_of(results, statistic_named(options.statistic), options.value,
                                    options.over, options.by);
  if (points.empty())
    throw InputError(
        fmt::format("{}: no finished run has a value '{}'", options.file, options.value));
  const std::string table = curve_csv(options, points);
  std::fputs(table.c_str(), stdout);
  if (csv) csv.fill(table);
  if (!picture) return;
  const app::ScratchFolder scratch("plot");
  if (!draw(options, points, kind, scratch.path())) throw ExitCode{1};
  picture.fill(read_file(scratch.path() / ("plot." + kind)));
}

}  // namespace

void add_sweep_plot(app::Command sweep) {
  app::Command command = sweep.add_subcommand(
      "plot", "A statistic with its 95 % interval against one or two parameters");
  auto options = std::make_shared<SweepPlotOptions>();
  command.add_option("RESULTS", options->file, "A file that `seam sweep` made").required();
  command.add_option("--value", options->value, "The column of which the statistic is computed")
      .required();
  command.add_option("--over", options->over, "The parameter along the page").required();
  command.add_option("--by", options->by, "A second parameter: a line for each of its values");
  command
      .add_option("--statistic", options->statistic,
                  "mean (interval by Student's t), deviation (chi-squared), median (order\n"
                  "statistics) or rate of values other than 0 (Wilson)")
      .one_of({"mean", "deviation", "median", "rate"})
      .show_default();
  command.add_option("--out", options->out,
                     "The picture: PNG, SVG or PDF by its name; drawn by gnuplot");
  command.add_option("--csv", options->csv, "What is drawn; it goes to standard output, too");
  command.footer(
      "Example: seam sweep plot results.sqlite --value error_m --over x_m --by camera --out "
      "error.png");
  command.callback([options] { plot_results(*options); });
}

}  // namespace seam::tools
