// What the viewer asks about one log (docs/viewer_api.md), as JSON texts and PNG bytes; no HTTP.
// All members may be called from several threads.
#pragma once

#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "scheduler/log/log.h"
#include "sim_core/base/error.h"

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

struct ViewPicture {
  std::string png;
  std::map<std::string, std::string> headers;
};

class ViewData {
 public:
  // Reads the whole log once. `id` is "a" or "b".
  ViewData(const std::string& path, std::string id);
  ~ViewData();

  std::string info();  // One entry of /api/info's `logs`.
  std::string truth(const Query& query);
  std::string state(const Query& query);
  std::string events(const Query& query);
  std::string steps(const Query& query);
  std::string debug(const Query& query);
  std::string series(const Query& query);
  std::string frames(const Query& query);
  std::string frame_rows(const Query& query);
  ViewPicture frame(const Query& query);

  const scheduler::Log& log() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace seam::tools
