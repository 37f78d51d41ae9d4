// The user's own compiler, called for one file after the other.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace seam::open_r {

struct Toolchain {
  std::string cxx, cc;            // Programs, by name or path.
  std::filesystem::path headers;  // The folder of OPEN-R's.
};

struct CompilerResult {
  int code = 0;
  std::string output;
};

// Runs a program; what it prints goes to its result. Throws Fault where it cannot be started.
CompilerResult run_program(const std::vector<std::string>& command);

std::vector<std::string> compile_command(const Toolchain& tools,
                                         const std::filesystem::path& source,
                                         const std::vector<std::string>& flags,
                                         const std::filesystem::path& object);
std::vector<std::string> link_command(const Toolchain& tools,
                                      const std::vector<std::filesystem::path>& objects,
                                      const std::vector<std::string>& libraries,
                                      const std::filesystem::path& result);

// What a program lacks, by name, from what the compiler said of it: "the header ERA201D1.h: ...".
std::vector<std::string> lacks(const std::string& output);

}  // namespace seam::open_r
