// The files that a plan names, by the names that it gives them: read from the disk once, and kept
// with the results, so that these can be made again anywhere.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>

namespace seam::app {

class PlanFiles {
 public:
  PlanFiles() = default;
  explicit PlanFiles(std::filesystem::path folder) : folder_(std::move(folder)) {}
  explicit PlanFiles(std::map<std::string, std::string> kept) : texts_(std::move(kept)) {}

  // Throws InputError where it is not there.
  const std::string& text(const std::string& name);
  const std::map<std::string, std::string>& texts() const { return texts_; }

 private:
  std::optional<std::filesystem::path> folder_;  // None: only what was kept.
  std::map<std::string, std::string> texts_;
};

}  // namespace seam::app
