// Logs of named signals, from CSV, JSON or numpy's archives: a column a signal, a row an instant.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace seam::app {

struct SignalLog {
  std::string file;
  std::vector<std::string> names;
  std::vector<std::string> full_names;         // With the units that stand beside them.
  std::vector<std::vector<double>> values;     // By signal, NaN where a row has none.
  std::vector<std::vector<int64_t>> exact_ns;  // By signal, of seconds: what a double cannot hold.
  std::map<std::string, std::vector<std::string>> texts;  // Signals that are words.
  // Lists of words that each row repeats, or that stand once for all: names of joints.
  std::map<std::string, std::vector<std::string>> lists;
  // Of signals, the first cell that is neither a number nor blank.
  struct OddCell {
    std::string place, text;
  };
  std::map<std::string, OddCell> odd;
  std::map<std::string, double> constants;  // What stands once for the whole log (JSON).
  std::vector<std::string> places;          // "file:line" or "file: entries[3]" of each row.

  size_t rows() const { return places.size(); }
  // The place of a signal, -1 where none of the names is there: without regard to case, and where
  // none is there as it stands, to blanks and a unit at its end (goal position [deg], goal_deg).
  int find(const std::vector<std::string>& names) const;
  // The name of one among the signals that are words, found likewise; empty where none is there.
  std::string find_words(const std::vector<std::string>& names) const;
};

// CSV by its rows; JSON as a list of objects (anywhere in it), as an object of equally long lists,
// or with such lists in objects below; numpy's archives (.npz) by their arrays of one or two
// dimensions. Lists in rows and cells, and columns of arrays, become signals NAME[0], NAME[1].
// Throws InputError.
SignalLog read_signals(const std::filesystem::path& path);
SignalLog signals_of_text(std::string text, const std::string& name);
// Of numpy's archive, into an empty log.
void read_npz_signals(SignalLog& log, const std::string& bytes);

}  // namespace seam::app
