// The answer to a request that cannot be met.
#pragma once

#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>

namespace seam::tools {

// The status of its answer, a sentence, and what else a page needs.
class Refusal : public std::runtime_error {
 public:
  Refusal(int status, const std::string& sentence, nlohmann::json more = nlohmann::json::object())
      : std::runtime_error(sentence), status_(status), more_(std::move(more)) {}
  int status() const { return status_; }
  const nlohmann::json& more() const { return more_; }

 private:
  int status_;
  nlohmann::json more_;
};

}  // namespace seam::tools
