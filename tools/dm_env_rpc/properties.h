// The properties of dm_env_rpc: what a client may look up beside its agent's observations. They
// concern the server and the agent's own world, never where anything in the world is.
#pragma once

#include "dm_env_rpc/v1/extensions/properties.pb.h"
#include "tools/dm_env_rpc/worlds.h"

namespace seam::tools::dm {

namespace properties = rpc::extensions::properties;

// An agent's place in a world; no world: a stream that has not joined.
struct Seat {
  std::shared_ptr<World> world;
  size_t place = 0;
};

// The seed of a setting or property. Throws RequestError.
int64_t seed_in(const rpc::Tensor& tensor, const std::string& what);

// Throws RequestError.
properties::PropertyResponse answer_property(const properties::PropertyRequest& request,
                                             const Worlds& worlds, const Seat& seat);

}  // namespace seam::tools::dm
