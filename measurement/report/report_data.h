// The document of a report page (docs/reference/report_data.md) for the analysis commands: their
// result and what its plots show. Filled into the page by report.h.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "measurement/report/lens_map.h"
#include "measurement/report/results.h"

namespace seam::measurement {

struct ReportHeader {
  std::string command;  // As it was typed.
  std::string model_file;
  std::string data_folder;
  LeftOut left_out;  // Rows that take no part.
  Doubts doubts;
};

// A model by effect and parameter: value, sigma (null where none was fitted), and whether it is
// free.
nlohmann::json effects_json(const effects::Model& model);

std::string compare_report(const Problem& problem, const CompareResult& result,
                           const ReportHeader& header);
std::string diagnose_report(const Problem& problem, const SearchResult& result,
                            const ReportHeader& header);
std::string discover_report(const Problem& problem, const SearchResult& result,
                            const ReportHeader& header);

// Two models beside each other.
std::string models_report(const std::vector<LensMap>& maps, const std::string& a,
                          const std::string& b, const ReportHeader& header);

// The versions of a model; needs no data.
std::string history_json(const Model& model);
std::string history_report(const Model& model, const ReportHeader& header);

}  // namespace seam::measurement
