#include "tools/dm_env_rpc/properties.h"

#include <fmt/format.h>

#include <functional>

#include "tools/dm_env_rpc/request_error.h"

namespace seam::tools::dm {

namespace {

using grpc::StatusCode;

struct Property {
  rpc::TensorSpec spec;  // Of one that is only listable: its name alone.
  std::string description;
  std::function<rpc::Tensor()> read;
  std::function<void(const rpc::Tensor&)> write;
};

std::string parent_of(const std::string& key) {
  const size_t dot = key.rfind('.');
  return dot == std::string::npos ? "" : key.substr(0, dot);
}

std::vector<Property> properties_of(const Worlds& worlds, const Seat& seat) {
  const WorldKind& kind = worlds.kind();
  std::vector<std::string> robots;
  for (const RobotInterface& robot : kind.robots) robots.push_back(robot.robot());
  std::vector<Property> all = {
      {spec_of("duration_s", rpc::DOUBLE),
       "Simulated seconds of a whole sequence",
       [&kind] { return tensor_of(kind.duration_s); },
       {}},
      {spec_of("robots", rpc::STRING, {-1}),
       "Robots that agents may join as (setting 'robot')",
       [robots] { return tensor_of(robots); },
       {}},
      {spec_of("scenario", rpc::STRING),
       "The scenario's name",
       [&kind] { return tensor_of(kind.scenario); },
       {}},
      {spec_of("version", rpc::STRING),
       "SEAM's version",
       [] { return tensor_of(std::string(SEAM_VERSION)); },
       {}},
  };
  if (!seat.world) return all;
  World& world = *seat.world;
  all.push_back({spec_of("world", rpc::INVALID_DATA_TYPE), "The world that is joined", {}, {}});
  all.push_back({spec_of("world.name", rpc::STRING),
                 "As create_world answered",
                 [&world] { return tensor_of(world.name()); },
                 {}});
  all.push_back({spec_of("world.robot", rpc::STRING),
                 "The robot that this stream is",
                 [&seat] { return tensor_of(seat.world->robot_of(seat.place).robot()); },
                 {}});
  all.push_back({spec_of("world.seed", rpc::INT64), "Of the next sequence; each has one more",
                 [&world] { return tensor_of(world.next_seed()); },
                 [&world](const rpc::Tensor& value) {
                   world.seed_next(seed_in(value, "property 'world.seed'"));
                 }});
  all.push_back({spec_of("world.sequence", rpc::INT64),
                 "How many sequences have begun",
                 [&world] { return tensor_of(world.sequences()); },
                 {}});
  if (!worlds.kind().command.logs.empty())
    all.push_back({spec_of("world.log", rpc::STRING),
                   "The name of the newest sequence's log",
                   [&world] {
                     const int64_t newest = world.sequences();
                     return tensor_of(newest > 0 ? world.log_of(newest) : std::string());
                   },
                   {}});
  return all;
}

bool has_children(const std::vector<Property>& all, const std::string& key) {
  for (const Property& property : all)
    if (parent_of(property.spec.name()) == key) return true;
  return false;
}

const Property& find(const std::vector<Property>& all, const std::string& key) {
  for (const Property& property : all)
    if (property.spec.name() == key) return property;
  throw RequestError(
      StatusCode::NOT_FOUND,
      fmt::format("key: no property '{}', expected one that list_property names; those of a world "
                  "are there once it is joined",
                  key.substr(0, 64)));
}

void list(const std::vector<Property>& all, const std::string& key,
          properties::ListPropertyResponse& response) {
  if (!key.empty()) {
    find(all, key);
    if (!has_children(all, key))
      throw RequestError(StatusCode::INVALID_ARGUMENT,
                         fmt::format("key: property '{}' has none below it", key));
  }
  for (const Property& property : all) {
    if (parent_of(property.spec.name()) != key) continue;
    properties::PropertySpec& listed = *response.add_values();
    *listed.mutable_spec() = property.spec;
    listed.set_is_readable(static_cast<bool>(property.read));
    listed.set_is_writable(static_cast<bool>(property.write));
    listed.set_is_listable(has_children(all, property.spec.name()));
    listed.set_description(property.description);
  }
}

}  // namespace

int64_t seed_in(const rpc::Tensor& tensor, const std::string& what) {
  constexpr int64_t kMost = int64_t{1} << 62;  // Further sequences count on from it.
  const int64_t seed = integer_in(tensor, what);
  if (seed < -kMost || seed > kMost)
    throw RequestError(StatusCode::OUT_OF_RANGE,
                       fmt::format("{}: found {}, expected -2^62 to 2^62", what, seed));
  return seed;
}

properties::PropertyResponse answer_property(const properties::PropertyRequest& request,
                                             const Worlds& worlds, const Seat& seat) {
  const std::vector<Property> all = properties_of(worlds, seat);
  properties::PropertyResponse response;
  switch (request.payload_case()) {
    case properties::PropertyRequest::kReadProperty: {
      const Property& property = find(all, request.read_property().key());
      if (!property.read)
        throw RequestError(StatusCode::PERMISSION_DENIED,
                           fmt::format("key: property '{}' has no value, expected one below it",
                                       property.spec.name()));
      *response.mutable_read_property()->mutable_value() = property.read();
      return response;
    }
    case properties::PropertyRequest::kWriteProperty: {
      const Property& property = find(all, request.write_property().key());
      if (!property.write)
        throw RequestError(
            StatusCode::PERMISSION_DENIED,
            fmt::format("key: property '{}' cannot be written", property.spec.name()));
      property.write(request.write_property().value());
      response.mutable_write_property();
      return response;
    }
    case properties::PropertyRequest::kListProperty:
      list(all, request.list_property().key(), *response.mutable_list_property());
      return response;
    case properties::PropertyRequest::PAYLOAD_NOT_SET:
      break;
  }
  throw RequestError(StatusCode::INVALID_ARGUMENT,
                     "extension: found an empty PropertyRequest, expected read_property, "
                     "write_property or list_property");
}

}  // namespace seam::tools::dm
