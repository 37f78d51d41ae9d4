#include "sim_core/base/config.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
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
  // One letter of three agrees: nobody meant that.
  EXPECT_EQ(suggestion_for("foo", {"ros", "opencv"}), ", known: ros, opencv");
  EXPECT_EQ(suggestion_for("rso", {"ros", "opencv"}), ", known: ros, opencv");
  EXPECT_EQ(suggestion_for("roz", {"ros", "opencv"}), ", did you mean 'ros'?");
  EXPECT_NE(error_of("a: [1, 2\n", [](const auto&) {}).find("robot.yaml:"), std::string::npos);
  EXPECT_EQ(error_of("a: 1\n", [](const auto& root) { root.at("b"); }),
            "robot.yaml:1: key 'b' is missing");
}

TEST(Config, WhatStandsTwiceOrBehindTheEndIsNotPassedOver) {
  EXPECT_EQ(error_of("a: {b: 1, c: 2, b: 3}\n", [](const auto& root) { root.at("a").keys(); }),
            "robot.yaml:1: a: key 'b' stands twice");
  EXPECT_EQ(error_of("a: 1\n---\nb: 2\n", [](const auto&) {}),
            "robot.yaml:2: a second document begins, expected one in a file");
  EXPECT_EQ(error_of(std::string("a: 1\0\n", 6), [](const auto&) {}),
            "robot.yaml: byte 5 is a NUL: not a text file");
}

TEST(Config, HostileNestingIsRefused) {
  EXPECT_NE(error_of("a: " + std::string(100000, '['), [](const auto&) {}).find("nested deeper"),
            std::string::npos);
  std::string dashes;
  for (int i = 0; i < 100000; ++i) dashes += "- ";
  EXPECT_NE(error_of(dashes + "1", [](const auto&) {}).find("nested deeper"), std::string::npos);
}

TEST(Config, HostileAliasesAreRefused) {
  std::string bomb = "a0: &a0 [x, x, x, x, x, x, x, x, x]\n";
  for (int i = 1; i < 12; ++i) {
    const std::string before = fmt::format("*a{}", i - 1);
    bomb += fmt::format("a{0}: &a{0} [{1}, {1}, {1}, {1}, {1}, {1}]\n", i, before);
  }
  EXPECT_THAT(error_of(bomb, [](const auto&) {}), testing::HasSubstr("aliases unfold to more"));
  EXPECT_THAT(error_of("a: &a [1, *a]\n", [](const auto&) {}), testing::HasSubstr("by aliases"));
  EXPECT_EQ(error_of("a: &a {b: 1}\nc: *a\n", [](const auto& root) { root.at("c").at("b"); }),
            "no error");
}

TEST(Config, MapsOfManyKeysAreRefusedBeforeOneIsLookedUp) {
  std::string text;
  for (int i = 0; i < 90'000; ++i) text += "k" + std::to_string(i) + ": 1\n";
  EXPECT_EQ(error_of(text, [](const auto& root) { root.has("k0"); }),
            "robot.yaml:1: found 90000 keys, expected 5000 at most");
  EXPECT_EQ(error_of(text, [](const auto& root) { root.keys(); }),
            "robot.yaml:1: found 90000 keys, expected 5000 at most");
}

TEST(Config, ControlCharactersAreRefusedInKeysAndTexts) {
  EXPECT_EQ(error_of("a: \"x\\0y\"\n", [](const auto& root) { root.at("a").text(); }),
            "robot.yaml:1: a: found a NUL, expected plain text");
  EXPECT_EQ(error_of("\"x\\ey\": 1\n", [](const auto& root) { root.keys(); }),
            "robot.yaml:1: found a control character in a key, expected plain words");
  EXPECT_EQ(error_of("a: \"x\\ny\\e[2J\"\n", [](const auto& root) { root.at("a").text(); }),
            "no error");
}

}  // namespace
}  // namespace seam
