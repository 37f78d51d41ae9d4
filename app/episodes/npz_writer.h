// numpy's archives (.npz), written: a zip of arrays, not packed, so that numpy maps them quickly.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "app/bundle/zip_writer.h"
#include "sim_core/base/output.h"

namespace seam::app {

class NpzWriter {
 public:
  // Throws InputError where the file cannot be written.
  explicit NpzWriter(const std::filesystem::path& file);
  NpzWriter(const NpzWriter&) = delete;  // The archive writes through it.
  NpzWriter& operator=(const NpzWriter&) = delete;

  // As many values as the shape has; row by row.
  void add(const std::string& name, const std::vector<size_t>& shape, std::span<const double>);
  void add(const std::string& name, const std::vector<size_t>& shape, std::span<const int64_t>);
  void add(const std::string& name, const std::vector<size_t>& shape, std::span<const uint8_t>);
  // Texts, as numpy's fixed width of characters.
  void add(const std::string& name, const std::vector<std::string>& texts);
  // Throws InputError where the file cannot be kept.
  void finish();

 private:
  void add_array(const std::string& name, const std::string& type, const std::vector<size_t>& shape,
                 std::string_view bytes);

  OutputFile file_;
  ZipWriter zip_;
};

}  // namespace seam::app
