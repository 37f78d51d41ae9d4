// The start of a file, by which imports recognise what they read.
#pragma once

#include <algorithm>
#include <optional>
#include <string>
#include <vector>

#include "app/import/files/text_table.h"

namespace seam::app {

using Names = std::vector<std::string>;

struct FileLook {
  std::string name, extension;
  std::string start;               // The first bytes.
  std::optional<TextTable> table;  // Of the first rows, where it is one.

  bool has_column(const Names& names) const { return table && table->find(names) >= 0; }
  // Of JSON.
  bool has_key(const Names& names) const {
    return std::any_of(names.begin(), names.end(), [this](const std::string& name) {
      return holds(('"' + name + '"').c_str());
    });
  }
  bool holds(const char* text) const { return start.find(text) != std::string::npos; }
  bool ends(const Names& ends) const {
    return std::find(ends.begin(), ends.end(), extension) != ends.end();
  }
};

}  // namespace seam::app
