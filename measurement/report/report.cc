#include "measurement/report/report.h"

#include <nlohmann/json.hpp>

#include "sim_core/base/error.h"
#include "sim_core/base/files.h"
#include "sim_core/system/own_files.h"

namespace seam::measurement {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr std::string_view kMarker = "__SEAM_REPORT_DATA__";

std::string escaped(std::string_view text) {
  std::string out;
  for (char c : text) {
    switch (c) {
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '&':
        out += "&amp;";
        break;
      default:
        out += c;
    }
  }
  return out;
}

bool is_leaf(const json& value) {
  return !value.is_object() && !value.is_array();
}

std::string leaf_text(const json& value) {
  return escaped(value.is_string() ? value.get<std::string>() : value.dump());
}

// Names become rows; a list becomes numbered rows, of which a page shows the first hundred.
void append_table(const json& value, std::string& out) {
  constexpr size_t kMostRows = 100;
  if (is_leaf(value)) {
    out += leaf_text(value);
    return;
  }
  out += "<table>";
  size_t row = 0;
  for (const auto& [name, item] : value.items()) {
    if (++row > kMostRows) {
      out += fmt::format("<tr><th>and {} more</th></tr>", value.size() - kMostRows);
      break;
    }
    out += "<tr><th>" + escaped(name) + "</th><td>";
    append_table(item, out);
    out += "</td></tr>";
  }
  out += "</table>";
}

}  // namespace

fs::path find_report_template() {
  return find_shared("report.html");
}

std::string fill_report_template(std::string_view page_template, std::string_view json) {
  size_t marker = page_template.find(kMarker);
  if (marker == std::string_view::npos) {
    throw InputError(fmt::format("report template: found no {}, expected it once", kMarker));
  }
  std::string page(page_template.substr(0, marker));
  for (size_t i = 0; i < json.size(); ++i) {
    // "</script>" in a title would end the data's own script element; "<!--" changes how it is
    // read.
    bool opens =
        json[i] == '<' && i + 1 < json.size() && (json[i + 1] == '/' || json[i + 1] == '!');
    if (opens) {
      page += "\\u003c";
    } else {
      page += json[i];
    }
  }
  page += page_template.substr(marker + kMarker.size());
  return page;
}

std::string plain_report(std::string_view text) {
  json report = json::parse(text);
  std::string page =
      "<!doctype html><html lang=\"en\"><meta charset=\"utf-8\"><title>SEAM report</title>"
      "<style>body{font:15px/1.5 sans-serif;margin:32px}th{text-align:left;vertical-align:top;"
      "font-weight:500;color:#4a5462;padding:2px 16px 2px 0}td{vertical-align:top}</style>"
      "<p>This build has no page template (npm was not there), so these are tables without "
      "plots.</p>";
  for (const char* part : {"title", "command", "result", "data", "model", "tables"}) {
    if (!report.contains(part)) continue;
    page += fmt::format("<h2>{}</h2>", part);
    append_table(report[part], page);
  }
  return page + "</html>\n";
}

void write_report(OutputFile& out, std::string_view json) {
  const fs::path page_template = find_report_template();
  out.fill(page_template.empty() ? plain_report(json)
                                 : fill_report_template(read_file(page_template), json));
}

}  // namespace seam::measurement
