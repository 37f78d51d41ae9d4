#include "tools/workbench/look/columns.h"

#include <algorithm>
#include <bit>
#include <cstring>

#include "sim_core/base/error.h"
#include "sim_core/base/files.h"

namespace seam::tools {

static_assert(std::endian::native == std::endian::little && sizeof(float) == 4);

std::vector<float>& Columns::add(const std::string& name) {
  names_.push_back(name);
  return columns_.emplace_back(rows_, std::nanf(""));
}

void Columns::add(const std::string& name, const std::vector<double>& values) {
  std::vector<float>& column = add(name);
  for (size_t i = 0; i < std::min(rows_, values.size()); ++i)
    column[i] = static_cast<float>(values[i]);
}

std::string head_bytes(const nlohmann::json& head) {
  std::string text = head.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
  text.resize((text.size() + 3) / 4 * 4, ' ');
  const auto length = static_cast<uint32_t>(text.size());
  std::string bytes(sizeof length, '\0');
  std::memcpy(bytes.data(), &length, sizeof length);
  return bytes + text;
}

std::string Columns::bytes(nlohmann::json head) const {
  head["n"] = rows_;
  head["columns"] = names_;
  std::string bytes = head_bytes(head);
  for (const auto& column : columns_)
    bytes.append(reinterpret_cast<const char*>(column.data()), column.size() * sizeof(float));
  return bytes;
}

std::vector<float> column_of(const std::filesystem::path& file, const std::string& name) {
  const std::string bytes = read_file(file);
  uint32_t length = 0;
  if (bytes.size() < sizeof length) throw InputError(file.string() + ": is cut off");
  std::memcpy(&length, bytes.data(), sizeof length);
  if (bytes.size() - sizeof length < length) throw InputError(file.string() + ": is cut off");
  const auto head = nlohmann::json::parse(bytes.substr(sizeof length, length));
  const size_t rows = head.at("n");
  const std::vector<std::string> names = head.at("columns");
  const auto found = std::find(names.begin(), names.end(), name);
  if (found == names.end()) return {};
  const size_t at =
      sizeof length + length + static_cast<size_t>(found - names.begin()) * rows * sizeof(float);
  if (at + rows * sizeof(float) > bytes.size()) throw InputError(file.string() + ": is cut off");
  std::vector<float> values(rows);
  std::memcpy(values.data(), bytes.data() + at, rows * sizeof(float));
  return values;
}

}  // namespace seam::tools
