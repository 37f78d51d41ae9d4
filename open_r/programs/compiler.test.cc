#include "open_r/programs/compiler.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "open_r/files/fault.h"
#include "open_r/programs/makefile.h"

namespace seam::open_r {
namespace {

using Names = std::vector<std::string>;

// The ways in which Makefiles name the objects of sources.
TEST(Makefiles, ObjectsAreNamedBySources) {
  const Makefile makefile =
      Makefile::read("Makefile",
                     "SRCS = A.cc B.cc \\\n  notes.txt\nEXTRA = ../share/C.o\n"
                     "OBJS = $(patsubst %.cc,%.o,$(filter %.cc,$(SRCS))) $(EXTRA)\n"
                     "ENDINGS = $(SRCS:.cc=.o) ${SRCS:%.cc=obj/%.o}\n"
                     "FLAGS = -I.\nFLAGS := $(FLAGS) -DX\nFLAGS += $(FLAGS)\nOPEN = $(SRCS\nSHELL "
                     "= $(shell rm -rf /)\n"
                     "all.bin: $(OBJS) Stub.o\n",
                     {});
  EXPECT_EQ(words_of(makefile.value("OBJS")), (Names{"A.o", "B.o", "../share/C.o"}));
  EXPECT_EQ(words_of(makefile.value("ENDINGS")),
            (Names{"A.o", "B.o", "notes.txt", "obj/A.o", "obj/B.o", "notes.txt"}));
  EXPECT_EQ(makefile.rules().at(0).prerequisites, (Names{"A.o", "B.o", "../share/C.o", "Stub.o"}));
  EXPECT_EQ(makefile.value("OPEN") + makefile.value("SHELL"), "");
  EXPECT_EQ(words_of(makefile.value("FLAGS")), (Names{"-I.", "-DX", "-I.", "-DX"}));
}

std::string fault_of(const std::string& text, const std::string& variable) {
  try {
    static_cast<void>(Makefile::read("p/Makefile", text, {}).value(variable));
  } catch (const Fault& fault) {
    return fault.what();
  }
  return "";
}

TEST(Makefiles, VariablesWithoutEndAreRefused) {
  EXPECT_EQ(fault_of("A = x\nCXXFLAGS = $(CXXFLAGS) $(CXXFLAGS) -O2\n", "CXXFLAGS"),
            "p/Makefile:2: the variable CXXFLAGS names itself, expected := or +=");
  EXPECT_EQ(fault_of("A = $(B)\nB = $(A)\n", "A"),
            "p/Makefile:1: the variable A names itself, expected := or +=");
  // Each twice the one before, whether there is something in the first or not.
  for (const std::string first : {"", "words"}) {
    std::string chain = "V0 = " + first + "\n", at_once = "V := " + first + " x\n";
    for (int i = 1; i < 100; ++i) {
      const std::string before = "$(V" + std::to_string(i - 1) + ")";
      chain += "V" + std::to_string(i) + " = " + before + before + "\n";
      at_once += "V := $(V)$(V)\n";
    }
    EXPECT_NE(fault_of(chain, "V99").find("grow to more than"), std::string::npos);
    EXPECT_NE(fault_of(at_once, "V").find("grow to more than"), std::string::npos);
  }
}

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
