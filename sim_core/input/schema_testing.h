// For tests: a schema in docs/ is the program's own.
#pragma once

#include <gtest/gtest.h>

#include <string>

#include "sim_core/base/error.h"
#include "sim_core/base/files.h"
#include "sim_core/base/output.h"

namespace seam {

// Where they differ, the schema as it should be is written beside the page, to be looked at and
// moved into its place.
inline void expect_page_is(const std::string& path, const std::string& current) {
  std::string checked_in;
  try {
    checked_in = read_file(path);
  } catch (const InputError&) {
  }
  if (current != checked_in) write_file_atomically(path + ".new", current);
  EXPECT_TRUE(current == checked_in) << "compare " << path << " with " << path << ".new";
}

}  // namespace seam
