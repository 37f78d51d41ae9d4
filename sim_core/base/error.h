// The two kinds of errors that end an operation. The world's fault (file, network, user) is an
// InputError: readers throw it, and the program's entry points turn it into one clear line and an
// exit code. A bug of ours is a failed SEAM_CHECK: it prints the values and ends the process, in
// release builds too.
#pragma once

#include <fmt/format.h>

#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace seam {

// Bad input. `what()` reads "file:line: key: found X, expected Y".
class InputError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

// The command line was used wrongly (exit code 2).
class UsageError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

// The known name that the given one misspells; null: none is near.
const std::string* near_name(std::string_view unknown, const std::vector<std::string>& known);

// ", did you mean 'x'?" for the known name nearest to the given one, or the list of known names
// when none is near.
std::string suggestion_for(std::string_view unknown, const std::vector<std::string>& known);

[[noreturn]] void check_failed(const char* file, int line, const char* condition,
                               const std::string& values);

}  // namespace seam

#define SEAM_CHECK(condition, ...)                                                              \
  do {                                                                                          \
    if (!(condition))                                                                           \
      ::seam::check_failed(__FILE_NAME__, __LINE__, #condition, ::fmt::format("" __VA_ARGS__)); \
  } while (false)
