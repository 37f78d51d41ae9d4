// The formats: APPNOTE.TXT of PKWARE (zip), and numpy.lib.format (npy).
#include "app/import/files/npz.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>
#include <string_view>

#include "app/import/files/inflate.h"
#include "app/import/files/python_literal.h"
#include "sim_core/base/error.h"

namespace seam::app {
namespace {

// Little-endian numbers at a place that was checked.
template <typename T>
T number(std::string_view bytes, size_t at) {
  T value;
  std::memcpy(&value, bytes.data() + at, sizeof(T));
  return value;
}

[[noreturn]] void damaged(const std::string& name, const char* why) {
  throw InputError(fmt::format("{}: {}: damaged or cut", name, why));
}

double value_at(char type, size_t size, const char* at, const std::string& name) {
  const auto as = [&]<typename T>(T) {
    T value;
    std::memcpy(&value, at, sizeof(T));
    return static_cast<double>(value);
  };
  if (type == 'f' && size == 8) return as(double{});
  if (type == 'f' && size == 4) return as(float{});
  if (type == 'i' && size == 8) return as(int64_t{});
  if (type == 'i' && size == 4) return as(int32_t{});
  if (type == 'i' && size == 2) return as(int16_t{});
  if (type == 'i' && size == 1) return as(int8_t{});
  if (type == 'u' && size == 8) return as(uint64_t{});
  if (type == 'u' && size == 4) return as(uint32_t{});
  if (type == 'u' && size == 2) return as(uint16_t{});
  if ((type == 'u' || type == 'b') && size == 1) return as(uint8_t{});
  throw InputError(
      fmt::format("{}: found numbers of type {}{}, which is unknown", name, type, size));
}

// Texts of a fixed width; what is no ASCII becomes a question mark.
std::vector<std::string> texts_in(std::string_view data, size_t count, size_t width, size_t step) {
  std::vector<std::string> texts(count);
  for (size_t k = 0; k < count; ++k) {
    const std::string_view text = data.substr(k * width, width);
    for (size_t i = 0; i < width && text[i] != 0; i += step) {
      const bool wide = std::any_of(text.begin() + static_cast<std::ptrdiff_t>(i) + 1,
                                    text.begin() + static_cast<std::ptrdiff_t>(i + step),
                                    [](char byte) { return byte != 0; });
      texts[k] += wide ? '?' : text[i];
    }
  }
  return texts;
}

// False where the array holds objects, or has more dimensions than are asked for.
bool read_npy(std::string_view bytes, const std::string& name, size_t most_dimensions,
              UnpackBudget& budget, NpyArray& array) {
  if (bytes.size() < 10 || !bytes.starts_with("\x93NUMPY")) damaged(name, "no array of numpy");
  const bool first_version = bytes[6] == 1;
  const size_t head = first_version ? 10 : 12;
  if (bytes.size() < head) damaged(name, "its head is short");
  const size_t length = first_version ? number<uint16_t>(bytes, 8) : number<uint32_t>(bytes, 8);
  if (length > bytes.size() - head) damaged(name, "its head is longer than it");
  constexpr size_t kMostHead = 64 << 10, kMostDimensions = 32;  // Numpy's own limits.
  if (length > kMostHead) damaged(name, "its head is too long");
  const auto facts = python_literal(std::string(bytes.substr(head, length)), name);
  if (!facts.is_object() || !facts.contains("descr") || !facts["descr"].is_string() ||
      !facts.contains("shape") || !facts["shape"].is_array())
    damaged(name, "its head says no type and shape");
  const auto type = facts["descr"].get<std::string>();
  uint64_t count = 1;
  if (facts["shape"].size() > kMostDimensions) damaged(name, "its shape is impossible");
  for (const auto& size : facts["shape"]) {
    const double value = size.is_number() ? size.get<double>() : -1;
    if (!(value >= 0 && value <= 1e9 && value == std::floor(value)))
      damaged(name, "its shape is impossible");
    array.shape.push_back(static_cast<size_t>(value));
    if (value > 0 && count > UnpackBudget::kBytes / static_cast<uint64_t>(value))
      damaged(name, "its shape is impossible");
    count *= static_cast<uint64_t>(value);
  }
  if (type.size() < 3 || type[1] == 'O' || type[1] == 'V') return false;
  if (array.shape.size() > most_dimensions) return false;
  const size_t size = static_cast<size_t>(std::clamp(std::atoi(type.c_str() + 2), 0, 1'000'000));
  const std::string_view data = bytes.substr(head + length);
  const size_t width = size * (type[1] == 'U' ? 4 : 1);
  if (width == 0 || count * width > data.size()) {
    if (count > 0 && width > 0) damaged(name, "it holds fewer values than its shape says");
    return true;
  }
  if (type[1] == 'U' || type[1] == 'S') {
    budget.take(count * (sizeof(std::string) + size));
    array.texts = texts_in(data, count, width, type[1] == 'U' ? 4 : 1);
    return true;
  }
  if (type[0] == '>')
    throw InputError(fmt::format("{}: found big-endian numbers, expected little-endian", name));
  const bool by_column = facts.contains("fortran_order") && facts["fortran_order"].is_boolean() &&
                         facts["fortran_order"].get<bool>() && array.shape.size() > 1;
  if (by_column)
    throw InputError(fmt::format("{}: found an array by columns, expected one by rows", name));
  // A byte of the file becomes eight here.
  budget.take(count * sizeof(double));
  array.values.reserve(count);
  for (uint64_t i = 0; i < count; ++i)
    array.values.push_back(value_at(type[1], size, data.data() + i * size, name));
  return true;
}

}  // namespace

std::map<std::string, NpyArray> read_npz(const std::string& bytes, const std::string& name,
                                         size_t most_dimensions) {
  constexpr size_t kEndRecord = 22, kEntry = 46, kLocal = 30;
  constexpr uint16_t kStored = 0, kDeflated = 8;
  const std::string_view all = bytes;
  const size_t end = all.rfind("PK\x05\x06");
  if (end == std::string_view::npos || all.size() - end < kEndRecord)
    damaged(name, "no end of a zip archive");
  const size_t entries = number<uint16_t>(all, end + 10);
  size_t at = number<uint32_t>(all, end + 16);
  std::map<std::string, NpyArray> arrays;
  UnpackBudget budget(name);
  for (size_t i = 0; i < entries; ++i) {
    if (at > all.size() || all.size() - at < kEntry || all.substr(at, 4) != "PK\x01\x02")
      damaged(name, "its list of files ends early");
    const auto method = number<uint16_t>(all, at + 10);
    const uint64_t packed = number<uint32_t>(all, at + 20);
    const size_t name_size = number<uint16_t>(all, at + 28);
    const size_t skip = name_size + number<uint16_t>(all, at + 30) + number<uint16_t>(all, at + 32);
    const size_t local = number<uint32_t>(all, at + 42);
    if (all.size() - at - kEntry < skip) damaged(name, "its list of files ends early");
    std::string of(all.substr(at + kEntry, name_size));
    at += kEntry + skip;
    if (local > all.size() || all.size() - local < kLocal) damaged(name, "a file lies outside");
    const size_t data =
        local + kLocal + number<uint16_t>(all, local + 26) + number<uint16_t>(all, local + 28);
    if (data > all.size() || packed > all.size() - data) damaged(name, "a file lies outside");
    if (method != kStored && method != kDeflated)
      throw InputError(fmt::format("{}: packed by method {}, expected deflate", name, method));
    const std::string_view stored = all.substr(data, packed);
    std::string unpacked;
    if (method == kDeflated) {
      unpacked = inflated(stored, Deflate::raw, budget, name);
    } else {
      // Many entries may name the same bytes.
      budget.take(stored.size());
    }
    const std::string_view content = method == kDeflated ? unpacked : stored;
    if (of.ends_with(".npy")) of.resize(of.size() - 4);
    NpyArray array;
    if (read_npy(content, name + ": " + of, most_dimensions, budget, array))
      arrays[of] = std::move(array);
  }
  return arrays;
}

std::string base85_decoded(const std::string& text, const std::string& name) {
  constexpr std::string_view kAlphabet =
      "0123456789ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz!#$%&()*+-;<=>?@^_`{|}~";
  std::string out;
  for (size_t at = 0; at < text.size(); at += 5) {
    uint64_t value = 0;
    const size_t given = std::min<size_t>(5, text.size() - at);
    for (size_t i = 0; i < 5; ++i) {
      const size_t digit = i < given ? kAlphabet.find(text[at + i]) : 84;
      if (digit == std::string_view::npos)
        throw InputError(fmt::format("{}: found '{}', which base 85 has not", name, text[at + i]));
      value = value * 85 + digit;
    }
    if (value > 0xFFFFFFFFu) throw InputError(fmt::format("{}: no base 85: damaged", name));
    for (size_t i = 0; i + 1 < given; ++i) out += static_cast<char>(value >> (24 - 8 * i));
  }
  return out;
}

}  // namespace seam::app
