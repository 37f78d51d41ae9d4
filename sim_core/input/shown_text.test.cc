#include "sim_core/input/shown_text.h"

#include <gtest/gtest.h>

namespace seam {
namespace {

TEST(ShownText, PlainTextStays) {
  EXPECT_EQ(shown("robot_1 5 °C, Größe 日本 😀"), "robot_1 5 °C, Größe 日本 😀");
}

TEST(ShownText, WhatActsOnTerminalsIsSpelledOut) {
  EXPECT_EQ(shown("\x1b[31mred\x07"), "\\x1b[31mred\\x07");
  EXPECT_EQ(shown(std::string_view("a\0b\x7f", 4)), "a\\x00b\\x7f");
  EXPECT_EQ(shown("\xc2\x9b"
                  "2J"),
            "\\xc2\\x9b2J");  // CSI as one character.
  EXPECT_EQ(shown("\xe2\x80\xae"
                  "gpj.exe"),
            "\\u202egpj.exe");  // Right to left from here on.
  EXPECT_EQ(shown("a\nb\tc"), "a\\x0ab\\x09c");
  EXPECT_EQ(shown_lines("a\nb\tc\r"), "a\nb\tc\\x0d");
}

TEST(ShownText, BytesThatAreNoUtf8AreSpelledOut) {
  EXPECT_EQ(shown("\xff"
                  "a\xc3"),
            "\\xffa\\xc3");
  EXPECT_EQ(shown("\xc0\xaf"), "\\xc0\\xaf");           // A slash in two bytes.
  EXPECT_EQ(shown("\xed\xa0\x80"), "\\xed\\xa0\\x80");  // Half of a surrogate pair.
}

}  // namespace
}  // namespace seam
