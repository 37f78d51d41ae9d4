// The one writer of imported sets. Files gather in a folder beside the one asked for, which takes
// its name when the set is whole and checked: an error leaves nothing behind.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "measurement/imaging/instruments.h"
#include "measurement/sets/csv.h"
#include "measurement/sets/set.h"

namespace seam::app {

class SetDraft {
 public:
  // Claims the folder: throws InputError where it exists and holds anything, or cannot be made.
  explicit SetDraft(std::filesystem::path out);
  ~SetDraft();
  SetDraft(const SetDraft&) = delete;
  SetDraft& operator=(const SetDraft&) = delete;

  // By which a set is checked whose kind needs them.
  measurement::Instruments instruments;

  // Of measurement.yaml.
  std::string kind, title, group;
  measurement::CameraFacts camera;
  std::map<std::string, double> noise;
  std::string rig;  // YAML; empty: none.
  std::string scene;
  // The nominal model's effects, YAML, each on a line of its own, indented by two blanks.
  std::string effects;

  // A table under `files:`, as NAME.csv.
  void add_table(const std::string& name, const measurement::CsvWriter& table);
  // Any other file by its path inside the set; folders are made.
  void add_file(const std::string& name, std::string_view bytes);

  // Sentences for people.
  void did(std::string what) { did_.push_back(std::move(what)); }
  // Replaces the last one.
  void did_instead(std::string what) { did_.back() = std::move(what); }
  void could_not_know(std::string what) { unknown_.push_back(std::move(what)); }
  void warn(std::string what) { warnings_.push_back(std::move(what)); }

  // Writes measurement.yaml and nominal.yaml, opens and checks the set as analyses will, and gives
  // it its name. Throws InputError with what is wrong with it. `came_from` says what was read.
  void finish(const std::string& came_from);

  // What was done, what is odd, what could not be known, one a line.
  std::string text() const;

 private:
  std::string set_yaml(const std::string& came_from) const;
  void check();
  // People know the folder by the name it is to get.
  std::string by_its_name(std::string text) const;

  std::filesystem::path out_, folder_;
  bool is_protocol_ = false;  // Nothing is measured in it yet.
  std::map<std::string, std::string> files_;
  std::vector<std::string> did_, unknown_, warnings_;
};

// A text in quotes of YAML.
std::string yaml_text(std::string_view text);

// A text as a cell of CSV without quotes: what would end it becomes an underscore.
std::string csv_word(std::string text);

// The shortest decimal that reads back as this number.
std::string exact(double value);
// Nanoseconds as decimal seconds.
std::string seconds_text(int64_t ns);

}  // namespace seam::app
