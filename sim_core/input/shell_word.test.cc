#include "sim_core/input/shell_word.h"

#include <gtest/gtest.h>

namespace seam {
namespace {

TEST(ShellWord, StandsAsItIsWhereAShellReadsItSo) {
  EXPECT_EQ(shell_word("versions/001.yaml"), "versions/001.yaml");
  EXPECT_EQ(shell_word("a=b,c:d@e%+"), "a=b,c:d@e%+");
}

TEST(ShellWord, IsQuotedElse) {
  EXPECT_EQ(shell_word(""), "''");
  EXPECT_EQ(shell_word("two words"), "'two words'");
  EXPECT_EQ(shell_word("$(rm x)"), "'$(rm x)'");
  EXPECT_EQ(shell_word("it's"), R"('it'\''s')");
}

}  // namespace
}  // namespace seam
