// MAT-files of version 5 (MATLAB's -v6 and -v7), numeric arrays alone. A reader of our own, in
// memory and bounded, because these files come from strangers: every length is checked against what
// is left before memory is taken.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace seam::app {

struct MatArray {
  size_t rows = 0, columns = 0;  // Further dimensions are folded into the columns.
  std::vector<double> values;    // Column by column, as stored; real parts.
  bool is_text = false;          // Characters, as numbers.

  double at(size_t row, size_t column) const { return values[column * rows + row]; }
};

class MatFile {
 public:
  // Throws InputError for anything else, HDF5 (-v7.3) by name.
  static MatFile read(const std::filesystem::path& path);
  static MatFile from_bytes(const std::string& bytes, const std::string& name);

  const std::string& file() const { return file_; }
  const std::map<std::string, MatArray>& arrays() const { return arrays_; }
  // Null where there is none.
  const MatArray* find(const std::string& name) const;
  // Throws with the names that are there.
  const MatArray& at(const std::string& name) const;

 private:
  std::string file_;
  std::map<std::string, MatArray> arrays_;
};

}  // namespace seam::app
