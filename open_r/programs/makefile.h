// What a Makefile of an OPEN-R program says: variables, rules and their commands. Nothing of it is
// run.
#pragma once

#include <cstddef>
#include <map>
#include <set>
#include <string>
#include <string_view>
#include <vector>

namespace seam::open_r {

struct MakeRule {
  std::vector<std::string> targets, prerequisites;
  std::vector<std::string> commands;
};

class Makefile {
 public:
  // `file`: its name, for what is said of it. `given`: variables that the Makefile's `?=` leave
  // alone, such as those of the environment.
  static Makefile read(std::string file, std::string_view text,
                       std::map<std::string, std::string> given);

  // Throws Fault where a variable names itself, or where this Makefile's variables grow too large.
  std::string expand(std::string_view text) const;
  std::string value(const std::string& name) const { return expand("$(" + name + ")"); }
  const std::vector<MakeRule>& rules() const { return rules_; }
  const std::map<std::string, std::string>& variables() const { return variables_; }

 private:
  void take(const std::string& line);

  std::string file_;
  int line_ = 0;
  std::map<std::string, std::string> variables_, given_;
  std::set<std::string> expanded_;             // Those of `:=`.
  std::map<std::string, std::string> places_;  // "Makefile:3", of variables.
  mutable size_t spent_ = 0;                   // What all that was expanded took.
  std::vector<MakeRule> rules_;
};

std::vector<std::string> words_of(std::string_view text);

}  // namespace seam::open_r
