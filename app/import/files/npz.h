// numpy's archives (.npz: a zip of .npy), in memory and bounded.
#pragma once

#include <map>
#include <string>
#include <vector>

namespace seam::app {

struct NpyArray {
  std::vector<size_t> shape;       // Empty: a number alone.
  std::vector<double> values;      // Row by row; empty where it holds text.
  std::vector<std::string> texts;  // Of an array of text.

  size_t size(size_t dimension) const { return dimension < shape.size() ? shape[dimension] : 1; }
};

// Arrays of numbers and of text by name; others (of objects), and those of more dimensions than
// that, are left out. Throws InputError.
std::map<std::string, NpyArray> read_npz(const std::string& bytes, const std::string& name,
                                         size_t most_dimensions = 32);

// RFC 1924's alphabet, as Python's base64.b85encode. Throws InputError for other characters.
std::string base85_decoded(const std::string& text, const std::string& name);

}  // namespace seam::app
