#include "sim_core/base/config.h"

#include <gtest/gtest.h>

#include <functional>

#include "sim_core/base/error.h"

namespace seam {
namespace {

std::string error_of(const std::string& text, const std::function<void(const ConfigNode&)>& read) {
  try {
    read(ConfigNode::from_text(text, "robot.yaml"));
  } catch (const InputError& error) {
    return error.what();
  }
  return "no error";
}

TEST(Config, ErrorsNameFileLineAndKey) {
  EXPECT_EQ(error_of("a: 1\nb: {c: x}\n", [](const auto& root) { root.at("b").at("c").number(); }),
            "robot.yaml:2: b.c: found 'x', expected a number");
  EXPECT_EQ(error_of("a: 7\n",
                     [](const auto& root) {
                       root.at("a").number({0, 1});
                     }),
            "robot.yaml:1: a: found 7, expected a number from 0 to 1");
  EXPECT_EQ(error_of("a: .nan\n", [](const auto& root) { root.at("a").number(); }),
            "robot.yaml:1: a: found '.nan', expected a finite number");
  EXPECT_EQ(error_of("a: 1\nperiod_ss: 2\n",
                     [](const auto& root) {
                       root.at("a");
                       root.find("period_s");
                       root.finish();
                     }),
            "robot.yaml:2: unknown key 'period_ss', did you mean 'period_s'?");
  EXPECT_NE(error_of("a: [1, 2\n", [](const auto&) {}).find("robot.yaml:"), std::string::npos);
  EXPECT_EQ(error_of("a: 1\n", [](const auto& root) { root.at("b"); }),
            "robot.yaml:1: key 'b' is missing");
}

TEST(Config, HostileNestingIsRefused) {
  EXPECT_NE(error_of("a: " + std::string(100000, '['), [](const auto&) {}).find("nested deeper"),
            std::string::npos);
  std::string dashes;
  for (int i = 0; i < 100000; ++i) dashes += "- ";
  EXPECT_NE(error_of(dashes + "1", [](const auto&) {}).find("nested deeper"), std::string::npos);
}

}  // namespace
}  // namespace seam
