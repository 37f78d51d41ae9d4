// State by name: one walk over an object's fields serves snapshots, restoring, hashes and naming
// the field in which two runs differ, so that these cannot drift apart.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <type_traits>
#include <variant>
#include <vector>

#include "sim_core/base/time.h"

namespace seam {

// Visited fields may be read or replaced. Lists visit their length first, then resize, then items.
class StateVisitor {
 public:
  virtual ~StateVisitor() = default;
  virtual void field(std::string_view name, double& value) = 0;
  virtual void field(std::string_view name, int64_t& value) = 0;

  void field(std::string_view name, SimTime& value) {
    int64_t ns = value.ns();
    field(name, ns);
    value = SimTime::from_ns(ns);
  }
  void field(std::string_view name, SimDuration& value) {
    int64_t ns = value.ns();
    field(name, ns);
    value = SimDuration::from_ns(ns);
  }
  void field(std::string_view name, bool& value) {
    int64_t number = value ? 1 : 0;
    field(name, number);
    value = number != 0;
  }
  template <class Enum>
  requires std::is_enum_v<Enum>
  void field(std::string_view name, Enum& value) {
    auto number = static_cast<int64_t>(value);
    field(name, number);
    value = static_cast<Enum>(number);
  }
  // Bytes: the length, then 8 bytes a field.
  void text(std::string_view name, std::string& value);
  // Names of the fields that follow start with this and a dot, until the next call.
  virtual void scope(std::string_view) {}
  // A list whose items have `void visit(StateVisitor&)`.
  template <class Item>
  void list(std::string_view name, std::vector<Item>& items) {
    items.resize(list_size(name, items.size()));
    for (Item& item : items) item.visit(*this);
  }
  // The length to resize to; refuses lengths over the limit.
  size_t list_size(std::string_view name, size_t size);
};

// One part of the state (a robot, the ball, the referee, ...) with its fields in their order.
struct StateSection {
  std::string name;
  struct Field {
    std::string name;
    std::variant<double, int64_t> value;
    bool operator==(const Field&) const = default;
  };
  std::vector<Field> fields;
  // Over the values' canonical bytes in order (names do not count).
  uint64_t hash() const;
};

// The first difference of two states: "robot/red1", "x_m"; empty names when they are equal.
struct StateDifference {
  std::string section;
  std::string field;
  bool found = false;
};
StateDifference first_difference(const std::vector<StateSection>& a,
                                 const std::vector<StateSection>& b);

// Visitors. The bytes of a snapshot are the fields as 8 little-endian bytes each, in order.
class SnapshotWriter final : public StateVisitor {
 public:
  using StateVisitor::field;
  void field(std::string_view name, double& value) override;
  void field(std::string_view name, int64_t& value) override;
  std::string take() { return std::move(bytes_); }

 private:
  std::string bytes_;
};

// Throws InputError when the bytes end too early; `finish` when some are left over.
class SnapshotReader final : public StateVisitor {
 public:
  using StateVisitor::field;
  explicit SnapshotReader(std::string_view bytes) : bytes_(bytes) {}
  void field(std::string_view name, double& value) override;
  void field(std::string_view name, int64_t& value) override;
  void finish() const;

 private:
  uint64_t next(std::string_view name);
  std::string_view bytes_;
  size_t position_ = 0;
};

class StateLister final : public StateVisitor {
 public:
  using StateVisitor::field;
  void field(std::string_view name, double& value) override;
  void field(std::string_view name, int64_t& value) override;
  void scope(std::string_view name) override {
    scope_ = name.empty() ? "" : std::string(name) + ".";
  }
  std::vector<StateSection::Field> take() { return std::move(fields_); }

 private:
  std::string scope_;
  std::vector<StateSection::Field> fields_;
};

// The values' 64 bits in order, without the names. -0.0 counts as 0.0.
class StateWords final : public StateVisitor {
 public:
  using StateVisitor::field;
  // The memory of `used` is used again.
  explicit StateWords(std::vector<int64_t> used = {}) : words_(std::move(used)) { words_.clear(); }
  void field(std::string_view name, double& value) override;
  void field(std::string_view name, int64_t& value) override;
  // Of the words from number `begin` on, as their little-endian bytes; over all it is
  // StateSection's.
  uint64_t hash(size_t begin = 0) const;
  const std::vector<int64_t>& words() const { return words_; }
  std::vector<int64_t> take() { return std::move(words_); }

 private:
  std::vector<int64_t> words_;
};

// What identifies a state, found in one visit: a hash of each section, and the words of all its
// fields.
struct StateDigest {
  std::vector<uint64_t> section_hashes;
  std::vector<int64_t> words;
};

}  // namespace seam
