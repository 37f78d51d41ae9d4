// A configuration described once: the same description reads a YAML file (with errors that name
// file, line and key), writes it back, and makes its JSON schema. A struct's description is a
// function `void describe(ConfigTable&, T&)` that names each field with its help and range.
#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "sim_core/base/config.h"
#include "sim_core/base/time.h"

namespace seam {

struct ConfigKey {
  const char* key;
  const char* help;  // A sentence with the unit.
  bool required = false;
};

// A file that a configuration names, of a kind that other layers read.
struct FileName {
  std::string name;         // Relative to the folder, and inside it.
  std::string folder;       // Of the configuration that names it.
  std::string fingerprint;  // Of its content where a log was written; empty: whatever it holds.
};

class ConfigTable {
 public:
  using Describe = std::function<void(ConfigTable&)>;
  virtual ~ConfigTable() = default;

  // The file's `format:` line; may be left out of a map in place.
  virtual void format(const char* expected) = 0;
  virtual void number(ConfigKey key, double& value, Range range) = 0;
  virtual void integer(ConfigKey key, int64_t& value, int64_t min, int64_t max) = 0;
  virtual void boolean(ConfigKey key, bool& value) = 0;
  virtual void text(ConfigKey key, std::string& value) = 0;
  virtual void texts(ConfigKey key, std::vector<std::string>& value) = 0;
  virtual void numbers(ConfigKey key, std::span<double> value) = 0;
  // The first `count` of a size's three numbers.
  virtual void sizes(ConfigKey key, Vec3& value, size_t count) = 0;
  virtual void choice(ConfigKey key, size_t& value, const std::vector<std::string>& words) = 0;
  virtual void object(ConfigKey key, const Describe& describe) = 0;
  // A map in place, or the path of a YAML file (relative to this file) that holds it.
  virtual void file_or_object(ConfigKey key, const Describe& describe) = 0;
  // As `file_or_object`, kept as YAML text: for files that other layers read. `name` says where it
  // came from.
  virtual void file_or_yaml(ConfigKey key, std::string& yaml, std::string& name) = 0;
  // The name of a file inside this configuration's folder; written with folder and fingerprint.
  virtual void file_name(ConfigKey key, FileName& value) = 0;
  // `describe_item(table, i)` is called for each item; when reading, `resize(count)` comes first.
  virtual void list(ConfigKey key, size_t count, size_t limit,
                    const std::function<void(size_t)>& resize,
                    const std::function<void(ConfigTable&, size_t)>& describe_item) = 0;
  // A map of names that the file chooses to texts or to numbers (blank: left out).
  virtual void texts_by_name(ConfigKey key, std::map<std::string, std::string>& value) = 0;
  virtual void numbers_by_name(ConfigKey key, std::map<std::string, double>& value,
                               Range range) = 0;
  // A map that its own reader reads later: here it is known and part of the schema.
  virtual void elsewhere(ConfigKey key, const Describe& describe) = 0;
  // People may add keys of their own to this map; only what looks like a slip is an error.
  virtual void allow_notes() {}
  // A condition on what was read; the message says what was found and what was expected.
  virtual void require(bool condition, const char* key, const std::string& message) = 0;

  // A description whose keys depend on a choice names all of them where this is true.
  virtual bool names_alternatives() const { return false; }
  // A description may leave out what is not there where this is true.
  virtual bool writes() const { return false; }

  // Seconds in the file, nanoseconds in memory.
  void seconds(ConfigKey key, SimDuration& value, Range range_s) {
    double s = value.s();
    number(key, s, range_s);
    value = SimDuration::from_s(s);
  }
  void vec3(ConfigKey key, Vec3& value) { numbers(key, std::span<double>(&value.x, 3)); }
  template <class Enum>
  void choice_of(ConfigKey key, Enum& value, const std::vector<std::string>& words) {
    auto index = static_cast<size_t>(value);
    choice(key, index, words);
    value = static_cast<Enum>(index);
  }
};

// Reads the node into whatever `describe` names; unknown keys are errors.
void read_config(const ConfigNode& node, const ConfigTable::Describe& describe);
// The values as a YAML document (files that were read become maps in place).
std::string write_config(const ConfigTable::Describe& describe);
// JSON Schema (2020-12) of the description.
std::string config_schema(const std::string& title, const ConfigTable::Describe& describe);

}  // namespace seam
