// What the viewer asks about one log (docs/reference/viewer_api.md), as JSON texts and PNG bytes;
// no HTTP. All members may be called from several threads.
#pragma once

#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "scheduler/log/log.h"
#include "tools/viewer/view_query.h"

namespace seam::tools {

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
  std::string find(const Query& query);
  std::string lanes(const Query& query);
  std::string steps(const Query& query);
  std::string decisions(const Query& query);
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
