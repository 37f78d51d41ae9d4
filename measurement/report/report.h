// The report page: one HTML file that works offline. docs/reference/report_data.md is the contract
// for what the page is made from.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "sim_core/base/output.h"

namespace seam::measurement {

// The page's template `share/seam/report.html`, beside the running program or one folder above it
// (as for test programs and installed trees), or in $SEAM_SHARE; empty where it was not built.
std::filesystem::path find_report_template();

// The page as text: `json`, a "seam-report/1" document, put into the template's marker so that no
// text in it can end the script that holds it. Throws InputError for a template without the marker.
std::string fill_report_template(std::string_view page_template, std::string_view json);

// A page of plain tables with the same numbers, for builds without the template.
std::string plain_report(std::string_view json);

// Writes the page to a file that was claimed before; nothing where none was asked for.
void write_report(OutputFile& out, std::string_view json);

}  // namespace seam::measurement
