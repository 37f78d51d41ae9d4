// The parameters of a request to the viewer, and what is wrong with them.
#pragma once

#include <cstdint>
#include <map>
#include <stdexcept>
#include <string>

namespace seam::tools {

// The request names something that is not there (404), other bad requests are UsageErrors (400).
class NotFound : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

// The request's parameters by name.
using Query = std::map<std::string, std::string>;
// Numbers from a query, or the default; throw UsageError naming the parameter.
double number_of(const Query& query, const std::string& name, double fallback);
int64_t integer_of(const Query& query, const std::string& name, int64_t fallback);
std::string text_of(const Query& query, const std::string& name, const std::string& fallback);

}  // namespace seam::tools
