// `seam sweep table`: results as CSV on standard output.
#include <cstdio>

#include "app/sweep/table.h"
#include "sim_core/base/error.h"
#include "tools/sweep/sweep.h"

namespace seam::tools {
namespace {

struct SweepTableOptions {
  std::string file;
  std::string format = "csv";
};

void print_table(const SweepTableOptions& options) {
  if (options.format == "parquet")
    throw UsageError(
        "--format parquet: no package of Debian 12 writes Parquet, expected csv. Convert the CSV "
        "where pandas and pyarrow, or duckdb, are installed:\n"
        "  python3 -c \"import pandas; "
        "pandas.read_csv('results.csv').to_parquet('results.parquet')\"\n"
        "  duckdb -c \"COPY (FROM 'results.csv') TO 'results.parquet'\"");
  const auto results = app::ResultsFile::for_reading(options.file);
  std::fputs(app::csv_line(app::table_columns(results.plan())).c_str(), stdout);
  results.each([&](const app::RunRecord& record) {
    std::fputs(app::csv_line(app::table_cells(results.plan(), record)).c_str(), stdout);
  });
}

}  // namespace

void add_sweep_table(app::Command sweep) {
  app::Command command = sweep.add_subcommand(
      "table", "Prints results as CSV: a header and a line a run, in the order of the plan");
  auto options = std::make_shared<SweepTableOptions>();
  command.add_option("RESULTS", options->file, "A file that `seam sweep` made").required();
  command
      .add_option("--format", options->format,
                  "`csv`; for `parquet` the error says how to convert it")
      .one_of({"csv", "parquet"})
      .show_default();
  command.footer(
      "Equal results give equal bytes, in whatever order, on however many machines and after\n"
      "however many interruptions they were made. A cell is blank where a value is missing or no\n"
      "finite number. Intervals and plots of it: docs/reference/analysis.md.\n"
      "Example: seam sweep table results.sqlite > results.csv");
  command.callback([options] { print_table(*options); });
}

}  // namespace seam::tools
