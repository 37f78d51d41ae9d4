// The specification names the messages that the manifest does.
#include "scheduler/log/log_manifest.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <regex>

#include "scheduler/log/log_records.h"
#include "sim_core/base/files.h"

namespace seam::scheduler {
namespace {

using Row = std::pair<std::string, std::string>;

// Topic and message of each row of the specification's table.
std::vector<Row> rows_of_the_specification() {
  const std::string text = read_file(SEAM_SOURCE_DIR "/replays/FORMAT.md");
  const std::regex row(R"(\n\| `(/[^`]+)` \| `([^`]+)` \|)");
  std::vector<Row> rows;
  for (std::sregex_iterator found(text.begin(), text.end(), row), end; found != end; ++found) {
    rows.emplace_back((*found)[1], (*found)[2]);
  }
  return rows;
}

TEST(LogManifest, IsTheTableOfTheSpecification) {
  std::vector<Row> rows;
  for (const Topic topic : kTopics) rows.emplace_back(topic_name(topic), schema_name(topic));
  rows.emplace_back(std::string(kPictures.topic) + "ROBOT", kPictures.schema);
  rows.emplace_back(kTransforms.topic, kTransforms.schema);
  rows.emplace_back(kSceneUpdates.topic, kSceneUpdates.schema);
  rows.emplace_back(kPrinted.topic, kPrinted.schema);
  EXPECT_EQ(rows_of_the_specification(), rows);
}

TEST(LogManifest, EveryMessageOfItHasItsSchema) {
  for (const Topic topic : kTopics) {
    EXPECT_THAT(descriptor_set_of(schema_name(topic)), ::testing::Not(::testing::IsEmpty()));
  }
}

}  // namespace
}  // namespace seam::scheduler
