// The format: "MAT-File Format", The MathWorks, chapter 1 (Level 5).
#include "app/import/files/mat_file.h"

#include <fmt/ranges.h>

#include <cmath>
#include <cstdint>
#include <cstring>
#include <string_view>

#include "app/import/files/inflate.h"
#include "app/import/files/source_file.h"
#include "sim_core/base/error.h"

namespace seam::app {
namespace {

constexpr size_t kMaxArrays = 100'000;
constexpr size_t kMaxDimensions = 32;
enum : uint32_t { kInt8 = 1, kUint8, kInt16, kUint16, kInt32, kUint32, kSingle, kDouble = 9 };
enum : uint32_t { kInt64 = 12, kUint64 = 13, kMatrix = 14, kCompressed = 15, kUtf8 = 16 };
constexpr uint8_t kCharClass = 4, kFirstNumericClass = 6, kLastNumericClass = 15;

template <typename T>
T number(std::string_view bytes, size_t at, bool swapped) {
  char raw[sizeof(T)];
  for (size_t i = 0; i < sizeof(T); ++i) raw[i] = bytes[at + (swapped ? sizeof(T) - 1 - i : i)];
  T value;
  std::memcpy(&value, raw, sizeof(T));
  return value;
}

// Elements one after another.
class Elements {
 public:
  Elements(std::string_view bytes, bool swapped, const std::string& file)
      : bytes_(bytes), swapped_(swapped), file_(file) {}

  bool done() const { return at_ + 8 > bytes_.size(); }

  struct Element {
    uint32_t type = 0;
    std::string_view data;
  };
  Element next() {
    if (done()) fail("ends inside an element");
    const auto first = number<uint32_t>(bytes_, at_, swapped_);
    if (first >> 16 != 0) {  // A small element: type and length share a word.
      const uint32_t size = first >> 16;
      if (size > 4) fail("holds a small element that is not small");
      const Element element{first & 0xFFFF, bytes_.substr(at_ + 4, size)};
      at_ += 8;
      return element;
    }
    const uint64_t size = number<uint32_t>(bytes_, at_ + 4, swapped_);
    if (size > bytes_.size() - at_ - 8)
      fail(fmt::format("states an element of {} bytes where {} are left", size,
                       bytes_.size() - at_ - 8));
    const Element element{first, bytes_.substr(at_ + 8, size)};
    // Compressed elements alone are not padded.
    at_ += 8 + (first == kCompressed ? size : (size + 7) / 8 * 8);
    return element;
  }
  [[noreturn]] void fail(const std::string& why) const {
    throw InputError(fmt::format("{}: the MAT-file {}: damaged or cut", file_, why));
  }

 private:
  std::string_view bytes_;
  bool swapped_;
  const std::string& file_;
  size_t at_ = 0;
};

size_t size_of(uint32_t type) {
  switch (type) {
    case kInt8:
    case kUint8:
    case kUtf8:
      return 1;
    case kInt16:
    case kUint16:
    case kUtf8 + 1:
      return 2;  // UTF-16.
    case kInt32:
    case kUint32:
    case kSingle:
      return 4;
    case kDouble:
    case kInt64:
    case kUint64:
      return 8;
    default:
      return 0;
  }
}

double value_at(uint32_t type, std::string_view bytes, size_t at, bool swapped) {
  switch (type) {
    case kInt8:
      return number<int8_t>(bytes, at, swapped);
    case kUint8:
    case kUtf8:
      return number<uint8_t>(bytes, at, swapped);
    case kInt16:
      return number<int16_t>(bytes, at, swapped);
    case kUint16:
    case kUtf8 + 1:
      return number<uint16_t>(bytes, at, swapped);
    case kInt32:
      return number<int32_t>(bytes, at, swapped);
    case kUint32:
      return number<uint32_t>(bytes, at, swapped);
    case kSingle:
      return number<float>(bytes, at, swapped);
    case kInt64:
      return static_cast<double>(number<int64_t>(bytes, at, swapped));
    case kUint64:
      return static_cast<double>(number<uint64_t>(bytes, at, swapped));
    default:
      return number<double>(bytes, at, swapped);
  }
}

// One matrix; false where it is no array of numbers or characters.
bool read_matrix(std::string_view bytes, bool swapped, const std::string& file,
                 UnpackBudget& budget, std::string& name, MatArray& array) {
  Elements parts(bytes, swapped, file);
  const auto flags = parts.next();
  if (flags.data.size() < 8) parts.fail("has an array without flags");
  const auto kind = static_cast<uint8_t>(number<uint32_t>(flags.data, 0, swapped) & 0xFF);
  const auto dimensions = parts.next();
  if (dimensions.data.size() % 4 != 0 || dimensions.data.size() < 8 ||
      dimensions.data.size() > 4 * kMaxDimensions)
    parts.fail("has an array of odd dimensions");
  uint64_t count = 1;
  for (size_t at = 0; at < dimensions.data.size(); at += 4) {
    const auto size = number<int32_t>(dimensions.data, at, swapped);
    if (size < 0 || (size > 0 && count > UnpackBudget::kBytes / static_cast<uint64_t>(size)))
      parts.fail("has an array of impossible dimensions");
    count *= static_cast<uint64_t>(size);
    if (at == 0) array.rows = static_cast<size_t>(size);
  }
  name = std::string(parts.next().data);
  if (kind != kCharClass && (kind < kFirstNumericClass || kind > kLastNumericClass)) return false;
  array.is_text = kind == kCharClass;
  array.columns = array.rows > 0 ? count / array.rows : 0;
  if (count == 0) return true;
  const auto data = parts.next();
  const size_t size = size_of(data.type);
  if (size == 0) parts.fail(fmt::format("has values of the unknown type {}", data.type));
  if (data.data.size() / size < count)
    parts.fail(
        fmt::format("holds {} of the {} values of '{}'", data.data.size() / size, count, name));
  // A byte of the file becomes eight here.
  budget.take(count * sizeof(double));
  array.values.reserve(count);
  for (uint64_t i = 0; i < count; ++i)
    array.values.push_back(value_at(data.type, data.data, i * size, swapped));
  return true;
}

}  // namespace

MatFile MatFile::read(const std::filesystem::path& path) {
  return from_bytes(read_source(path), path.string());
}

MatFile MatFile::from_bytes(const std::string& bytes, const std::string& name) {
  MatFile mat;
  mat.file_ = name;
  if (bytes.starts_with("MATLAB 7.3") || bytes.starts_with("\x89HDF\r\n"))
    throw InputError(
        fmt::format("{}: found a MAT-file of version 7.3 (HDF5), expected version 5: save it with "
                    "save(..., '-v7')",
                    name));
  constexpr size_t kHeader = 128;
  if (bytes.size() < kHeader || !bytes.starts_with("MATLAB 5.0"))
    throw InputError(fmt::format("{}: found no MAT-file of version 5", name));
  const std::string_view mark = std::string_view(bytes).substr(126, 2);
  if (mark != "IM" && mark != "MI")
    throw InputError(fmt::format("{}: the MAT-file says no byte order: damaged", name));
  const bool swapped = mark == "MI";
  Elements elements(std::string_view(bytes).substr(kHeader), swapped, name);
  UnpackBudget budget(name);
  while (!elements.done()) {
    auto element = elements.next();
    std::string inner;
    if (element.type == kCompressed) {
      inner = inflated(element.data, Deflate::zlib, budget, name);
      Elements one(inner, swapped, name);
      element = one.next();
    }
    if (element.type != kMatrix) continue;
    std::string of;
    MatArray array;
    if (!read_matrix(element.data, swapped, name, budget, of, array)) continue;
    mat.arrays_[of] = std::move(array);
    if (mat.arrays_.size() > kMaxArrays)
      throw InputError(fmt::format("{}: more than {} arrays", name, kMaxArrays));
  }
  return mat;
}

const MatArray* MatFile::find(const std::string& name) const {
  const auto found = arrays_.find(name);
  return found == arrays_.end() ? nullptr : &found->second;
}

const MatArray& MatFile::at(const std::string& name) const {
  if (const MatArray* array = find(name)) return *array;
  std::vector<std::string> names;
  for (const auto& [known, array] : arrays_) names.push_back(known);
  throw InputError(fmt::format(
      "{}: array '{}' is missing; it holds {}", file_, name,
      names.empty() ? "no arrays of numbers" : fmt::format("{}", fmt::join(names, ", "))));
}

}  // namespace seam::app
