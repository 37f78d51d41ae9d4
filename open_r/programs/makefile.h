// What a Makefile of an OPEN-R program says: variables, rules and their commands. Nothing of it is
// run.
#pragma once

#include <map>
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
  // `given`: variables that the Makefile's `?=` leave alone, such as those of the environment.
  static Makefile read(std::string_view text, std::map<std::string, std::string> given);

  std::string expand(std::string_view text) const;
  std::string value(const std::string& name) const { return expand("$(" + name + ")"); }
  const std::vector<MakeRule>& rules() const { return rules_; }
  const std::map<std::string, std::string>& variables() const { return variables_; }

 private:
  void take(const std::string& line);

  std::map<std::string, std::string> variables_, given_;
  std::vector<MakeRule> rules_;
};

std::vector<std::string> words_of(std::string_view text);

}  // namespace seam::open_r
