// The worlds of this server, by name.
#pragma once

#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "tools/dm_env_rpc/world.h"

namespace seam::tools::dm {

// What all worlds have in common.
struct WorldKind {
  std::string scenario;  // Its name.
  int64_t seed = 1;      // Where a client gives none.
  double duration_s = 0;
  std::vector<RobotInterface> robots;  // Those that agents may join as.
  RunCommand command;
  size_t most_worlds = 1;
};

class Worlds {
 public:
  explicit Worlds(WorldKind kind) : kind_(std::move(kind)) {}
  const WorldKind& kind() const { return kind_; }

  // All throw RequestError.
  std::string create(int64_t seed);
  std::shared_ptr<World> find(const std::string& name) const;
  void destroy(const std::string& name);
  std::vector<std::string> names() const;
  // The server ends.
  void close();

 private:
  const WorldKind kind_;
  mutable std::mutex mutex_;
  std::map<std::string, std::shared_ptr<World>> worlds_;
  uint64_t created_ = 0;
};

}  // namespace seam::tools::dm
