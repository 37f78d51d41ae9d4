#include "sim_core/input/json_input.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "sim_core/base/error.h"

namespace seam {
namespace {

std::string message_of(const std::string& text) {
  try {
    json_from_text(text, "r.json", "a result");
  } catch (const InputError& error) {
    return error.what();
  }
  return "no error";
}

TEST(JsonInput, ReadsValues) {
  EXPECT_EQ(json_from_text(R"({"a": [1, 2]})", "r.json", "a result")["a"][1], 2);
}

TEST(JsonInput, DepthIsBounded) {
  const auto nested = [](int depth) { return std::string(depth, '[') + std::string(depth, ']'); };
  EXPECT_EQ(message_of(nested(60)), "no error");
  EXPECT_EQ(message_of(nested(200'000)), "r.json: nested deeper than 64 levels");
  EXPECT_EQ(message_of(std::string(200'000, '[')), "r.json: nested deeper than 64 levels");
  EXPECT_EQ(message_of("[1,"), "r.json: byte 4: found no JSON, expected a result");
}

TEST(JsonInput, NumbersBeyondAllBoundsAreTheFilesFault) {
  EXPECT_EQ(message_of("[1e309]"), "r.json: holds a number that no double can, expected a result");
}

}  // namespace
}  // namespace seam
