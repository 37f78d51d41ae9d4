// numpy's archives (.npz), written: a zip of arrays, not packed, so that numpy maps them quickly.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "sim_core/base/output.h"

namespace seam::app {

class NpzWriter {
 public:
  // Throws InputError where the file cannot be written.
  explicit NpzWriter(const std::filesystem::path& file) : file_(file) {}

  // As many values as the shape has; row by row.
  void add(const std::string& name, const std::vector<size_t>& shape, std::span<const double>);
  void add(const std::string& name, const std::vector<size_t>& shape, std::span<const int64_t>);
  void add(const std::string& name, const std::vector<size_t>& shape, std::span<const uint8_t>);
  // Texts, as numpy's fixed width of characters.
  void add(const std::string& name, const std::vector<std::string>& texts);
  // Throws InputError where the file cannot be kept.
  void finish();

 private:
  struct Entry {
    std::string name;
    uint32_t crc = 0, size = 0, place = 0;
  };
  void add_array(const std::string& name, const std::string& type, const std::vector<size_t>& shape,
                 std::string_view bytes);
  void write(std::string_view bytes);

  OutputFile file_;
  std::vector<Entry> entries_;
  uint64_t written_ = 0;
};

}  // namespace seam::app
