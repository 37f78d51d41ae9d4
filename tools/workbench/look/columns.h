// A table as the page reads it at once: the length of a head (4 bytes, little-endian), the head as
// JSON, then columns of 32-bit floats in the head's order. NaN: no value.
#pragma once

#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace seam::tools {

// What a binary answer begins with: the head's length and the head, filled up to a multiple of 4.
std::string head_bytes(const nlohmann::json& head);

class Columns {
 public:
  explicit Columns(size_t rows) : rows_(rows) {}

  size_t rows() const { return rows_; }
  // Another one, without values; valid until the next.
  std::vector<float>& add(const std::string& name);
  void add(const std::string& name, const std::vector<double>& values);
  std::string bytes(nlohmann::json head) const;

 private:
  size_t rows_;
  std::vector<std::string> names_;
  std::vector<std::vector<float>> columns_;
};

// One column of such a file; empty where it has none of that name. Throws InputError.
std::vector<float> column_of(const std::filesystem::path& file, const std::string& name);

}  // namespace seam::tools
