#include "sim_core/body/state.h"

#include <fmt/format.h>

#include <bit>

#include "sim_core/base/error.h"
#include "sim_core/base/hash.h"

namespace seam {
namespace {

constexpr size_t kMaxListLength = 1 << 20;

}  // namespace

void StateVisitor::text(std::string_view name, std::string& value) {
  value.resize(list_size(name, value.size()));
  for (size_t begin = 0; begin < value.size(); begin += 8) {
    const size_t count = std::min<size_t>(8, value.size() - begin);
    uint64_t bits = 0;
    for (size_t i = 0; i < count; ++i)
      bits |= static_cast<uint64_t>(static_cast<uint8_t>(value[begin + i])) << (8 * i);
    auto number = static_cast<int64_t>(bits);
    field(name, number);
    bits = static_cast<uint64_t>(number);
    for (size_t i = 0; i < count; ++i) value[begin + i] = static_cast<char>(bits >> (8 * i));
  }
}

size_t StateVisitor::list_size(std::string_view name, size_t size) {
  auto number = static_cast<int64_t>(size);
  field(name, number);
  if (number < 0 || number > static_cast<int64_t>(kMaxListLength)) {
    throw InputError(fmt::format("snapshot: {}: found a list of {} entries, expected at most {}",
                                 name, number, kMaxListLength));
  }
  return static_cast<size_t>(number);
}

uint64_t StateSection::hash() const {
  StateWords words;
  for (const Field& field : fields) {
    std::visit([&](auto value) { words.field("", value); }, field.value);
  }
  return words.hash();
}

StateDifference first_difference(const std::vector<StateSection>& a,
                                 const std::vector<StateSection>& b) {
  for (size_t s = 0; s < std::max(a.size(), b.size()); ++s) {
    if (s >= a.size() || s >= b.size()) return {(s < a.size() ? a : b)[s].name, "", true};
    if (a[s].name != b[s].name) return {a[s].name, "", true};
    const auto& x = a[s].fields;
    const auto& y = b[s].fields;
    for (size_t f = 0; f < std::max(x.size(), y.size()); ++f) {
      if (f >= x.size() || f >= y.size()) return {a[s].name, (f < x.size() ? x : y)[f].name, true};
      if (!(x[f] == y[f])) return {a[s].name, x[f].name, true};
    }
  }
  return {};
}

void SnapshotWriter::field(std::string_view, double& value) {
  auto bits = static_cast<int64_t>(std::bit_cast<uint64_t>(value));
  field("", bits);
}

void SnapshotWriter::field(std::string_view, int64_t& value) {
  for (int i = 0; i < 8; ++i) bytes_ += static_cast<char>(static_cast<uint64_t>(value) >> (8 * i));
}

uint64_t SnapshotReader::next(std::string_view name) {
  if (bytes_.size() - position_ < 8)
    throw InputError(fmt::format("snapshot: ends before field '{}'", name));
  uint64_t bits = 0;
  for (int i = 0; i < 8; ++i) {
    bits |= static_cast<uint64_t>(static_cast<uint8_t>(bytes_[position_ + static_cast<size_t>(i)]))
            << (8 * i);
  }
  position_ += 8;
  return bits;
}

void SnapshotReader::field(std::string_view name, double& value) {
  value = std::bit_cast<double>(next(name));
}

void SnapshotReader::field(std::string_view name, int64_t& value) {
  value = static_cast<int64_t>(next(name));
}

void SnapshotReader::finish() const {
  if (position_ != bytes_.size()) {
    throw InputError(
        fmt::format("snapshot: {} bytes left over, made by another scenario or version?",
                    bytes_.size() - position_));
  }
}

void StateLister::field(std::string_view name, double& value) {
  fields_.push_back({scope_ + std::string(name), value});
}

void StateLister::field(std::string_view name, int64_t& value) {
  fields_.push_back({scope_ + std::string(name), value});
}

void StateWords::field(std::string_view, double& value) {
  words_.push_back(std::bit_cast<int64_t>(value == 0 ? 0.0 : value));
}

void StateWords::field(std::string_view, int64_t& value) {
  words_.push_back(value);
}

uint64_t StateWords::hash(size_t begin) const {
  static_assert(std::endian::native == std::endian::little, "the hash is over little-endian bytes");
  Hasher hasher;
  hasher.add_bytes({reinterpret_cast<const uint8_t*>(words_.data() + begin),
                    (words_.size() - begin) * sizeof(int64_t)});
  return hasher.digest();
}

}  // namespace seam
