// `seam sweep table`: results as CSV on standard output.
#include <cstdio>

#include "app/sweep/table.h"
#include "tools/sweep/sweep.h"

namespace seam::tools {

void add_sweep_table(app::Command sweep) {
  app::Command command = sweep.add_subcommand(
      "table", "Prints results as CSV: a header and a line a run, in the order of the plan");
  auto file = std::make_shared<std::string>();
  command.add_option("RESULTS", *file, "A file that `seam sweep` made").required();
  command.footer(
      "Equal results give equal bytes, in whatever order, on however many machines and after\n"
      "however many interruptions they were made. A cell is blank where a value is missing or no\n"
      "finite number.\n"
      "Example: seam sweep table results.sqlite > results.csv");
  command.callback([file] {
    const auto results = app::ResultsFile::for_reading(*file);
    std::fputs(app::csv_line(app::table_columns(results.plan())).c_str(), stdout);
    results.each([&](const app::RunRecord& record) {
      std::fputs(app::csv_line(app::table_cells(results.plan(), record)).c_str(), stdout);
    });
  });
}

}  // namespace seam::tools
