#include "open_r/programs/compiler.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace seam::open_r {
namespace {

using Names = std::vector<std::string>;

// What g++ and the assembler say, and what a user reads of it.
TEST(Lacks, AreNamed) {
  EXPECT_EQ(lacks("a.cc:1:10: fatal error: ODA.h: No such file or directory\n"),
            Names{"the header ODA.h"});
  EXPECT_EQ(lacks("a.cc:1:2: error: #error \"DNS is refused: because\"\n"),
            Names{"DNS is refused: because"});
  EXPECT_EQ(lacks("/tmp/x.s:35: Error: no such instruction: `mfc0 $2,$12'\n"),
            Names{"a MIPS processor: `mfc0 $2,$12'"});
  EXPECT_EQ(lacks("a.c:5:13: error: conflicting types for 'jpeg_mem_dest'; have 'void(int)'\n"),
            Names{"one meaning of jpeg_mem_dest: a library of this machine has that name, too; "
                  "rename it"});
  EXPECT_EQ(lacks("a.h:58:18: error: 'int Now()' should have been declared inside '::'\n"),
            Names{"the name int Now(): g++ refuses '::' before a name that it has not seen; leave "
                  "'::' out"});
  EXPECT_EQ(lacks("a.cc:3:1: error: call to 'New' declared with attribute error: New is refused\n"),
            Names{"New is refused"});
}

// Each lack once, whatever the quotes.
TEST(Lacks, AreNamedOnce) {
  EXPECT_EQ(lacks("a.cc:1:1: error: \xe2\x80\x98Walk\xe2\x80\x99 was not declared in this scope\n"
                  "a.cc:2:1: error: 'Walk' was not declared in this scope\n"),
            Names{"the name Walk"});
}

TEST(Commands, OwnFolderComesBeforeTheHeaders) {
  const Toolchain tools{"g++", "cc", "/headers"};
  const Names words = compile_command(tools, "/p/a.cc", {"-DERS210"}, "/o/a.o");
  const auto place = [&](const std::string& word) {
    return std::find(words.begin(), words.end(), word) - words.begin();
  };
  EXPECT_LT(place("-I/o"), place("-isystem/headers/system"));
  EXPECT_LT(place("-std=gnu++98"), place("-DERS210"));
  EXPECT_LT(static_cast<size_t>(place("-isystem/headers/network")), words.size());
  // C has no such standard.
  const Names c = compile_command(tools, "/p/a.c", {}, "/o/a.o");
  EXPECT_EQ(c.front(), "cc");
  EXPECT_EQ(std::find(c.begin(), c.end(), "-std=gnu++98"), c.end());
}

}  // namespace
}  // namespace seam::open_r
