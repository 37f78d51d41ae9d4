#include "measurement/report/report.h"

#include <gtest/gtest.h>

#include <filesystem>

#include "sim_core/base/error.h"
#include "sim_core/base/files.h"

namespace seam::measurement {
namespace {

constexpr const char* kTemplate =
    R"(<script type="application/json" id="data">__SEAM_REPORT_DATA__</script><p>page</p>)";

TEST(Report, DataStandsWhereTheMarkerWas) {
  EXPECT_EQ(fill_report_template(kTemplate, R"({"n": 1})"),
            R"(<script type="application/json" id="data">{"n": 1}</script><p>page</p>)");
}

TEST(Report, NoTextCanEndTheScript) {
  std::string page = fill_report_template(kTemplate, R"({"title": "</script><!-- a < b"})");
  EXPECT_NE(page.find(R"("\u003c/script>\u003c!-- a < b")"), std::string::npos) << page;
}

TEST(Report, TemplateWithoutMarkerIsAnError) {
  EXPECT_THROW(fill_report_template("<p>other</p>", "{}"), InputError);
}

TEST(Report, PlainPageShowsTheNumbersAndEscapesText) {
  std::string page =
      plain_report(R"({"title": "a<b", "result": {"error": 3.5, "steps": [{"effect": "x"}]}})");
  EXPECT_NE(page.find("a&lt;b"), std::string::npos);
  EXPECT_NE(page.find("3.5"), std::string::npos);
  EXPECT_NE(page.find("<th>effect</th><td>x</td>"), std::string::npos);
}

TEST(Report, WritesAPageWithOrWithoutTheTemplate) {
  auto path = std::filesystem::temp_directory_path() / "seam_report_test.html";
  OutputFile page(path);
  write_report(page, R"({"format": "seam-report/1", "result": {"error": 2.25}})");
  EXPECT_NE(read_file(path).find("2.25"), std::string::npos);
  std::filesystem::remove(path);
}

}  // namespace
}  // namespace seam::measurement
