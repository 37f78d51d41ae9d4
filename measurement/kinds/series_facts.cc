#include "measurement/kinds/series_facts.h"

namespace seam::measurement {

void describe_rows(const MeasurementSet& set, const CsvTable& table, int channels, Facts& facts) {
  facts.title = set.title;
  facts.fingerprint = set.fingerprint();
  facts.file = table.file();
  facts.group_of_row = number_groups(table.texts(set.group), facts.groups);
  facts.time_of_row.resize(table.rows());
  facts.series_of_row.resize(table.rows());
  for (size_t row = 0; row < table.rows(); ++row) {
    facts.line_of_row.push_back(table.line(row));
    for (int channel = 0; channel < channels; ++channel) {
      facts.row_of.push_back(static_cast<int>(row));
      facts.channel_of.push_back(channel);
    }
  }
}

void add_series(const MeasurementSet& set, const CsvTable& table, size_t number,
                const std::vector<size_t>& rows, const std::vector<double>& time_s, Facts& facts) {
  for (size_t k = 0; k < rows.size(); ++k) {
    facts.time_of_row[rows[k]] = time_s[k];
    facts.series_of_row[rows[k]] = static_cast<int>(number);
    if (facts.group_of_row[rows[k]] != facts.group_of_row[rows[0]])
      table.fail(rows[k], set.group, table.cell(rows[k], set.group), "one group a run");
  }
}

}  // namespace seam::measurement
