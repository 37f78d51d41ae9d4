#include "tools/dm_env_rpc/worlds.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "tools/dm_env_rpc/request_error.h"

namespace seam::tools::dm {

std::string Worlds::create(int64_t seed) {
  const std::lock_guard lock(mutex_);
  if (worlds_.size() >= kind_.most_worlds)
    throw RequestError(grpc::StatusCode::RESOURCE_EXHAUSTED,
                       fmt::format("there are {} worlds, as many as there may be: destroy one "
                                   "(destroy_world), or give `seam serve --worlds N`",
                                   worlds_.size()));
  const std::string name = fmt::format("world{}", ++created_);
  worlds_[name] = std::make_shared<World>(name, kind_.robots, kind_.command, seed);
  return name;
}

std::shared_ptr<World> Worlds::find(const std::string& name) const {
  const std::lock_guard lock(mutex_);
  const auto found = worlds_.find(name);
  if (found == worlds_.end())
    throw RequestError(grpc::StatusCode::NOT_FOUND,
                       fmt::format("world_name: no world '{}', expected one that create_world made",
                                   name.substr(0, 64)));
  return found->second;
}

void Worlds::destroy(const std::string& name) {
  const auto world = find(name);
  if (const auto joined = world->joined(); !joined.empty())
    throw RequestError(
        grpc::StatusCode::FAILED_PRECONDITION,
        fmt::format("world '{}': agents are joined as {}, expected that they leave first", name,
                    fmt::join(joined, ", ")));
  const std::lock_guard lock(mutex_);
  worlds_.erase(name);
}

std::vector<std::string> Worlds::names() const {
  const std::lock_guard lock(mutex_);
  std::vector<std::string> names;
  for (const auto& [name, world] : worlds_) names.push_back(name);
  return names;
}

void Worlds::close() {
  const std::lock_guard lock(mutex_);
  for (const auto& [name, world] : worlds_) world->close();
}

}  // namespace seam::tools::dm
