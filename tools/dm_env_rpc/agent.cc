#include "tools/dm_env_rpc/agent.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <optional>

#include "scheduler/wire/token.h"
#include "tools/dm_env_rpc/request_error.h"

namespace seam::tools::dm {

namespace {

using grpc::StatusCode;
using Settings = google::protobuf::Map<std::string, rpc::Tensor>;

void check_names(const Settings& settings, const std::vector<std::string>& known) {
  for (const auto& [name, value] : settings)
    if (std::find(known.begin(), known.end(), name) == known.end())
      throw RequestError(
          StatusCode::INVALID_ARGUMENT,
          fmt::format("settings: no setting '{}', expected {}", name.substr(0, 64),
                      known.empty() ? "none" : fmt::to_string(fmt::join(known, ", "))));
}

// The seed, the only setting of worlds and sequences.
std::optional<int64_t> seed_of(const Settings& settings) {
  check_names(settings, {"seed"});
  const auto seed = settings.find("seed");
  if (seed == settings.end()) return std::nullopt;
  return seed_in(seed->second, "setting 'seed'");
}

std::string text_of(const Settings& settings, const char* name) {
  const auto found = settings.find(name);
  return found == settings.end() ? "" : text_in(found->second, fmt::format("setting '{}'", name));
}

}  // namespace

Agent::~Agent() {
  try {
    leave();
  } catch (const std::exception&) {
    // The other agents learn of a run that ended badly.
  }
}

rpc::EnvironmentResponse Agent::answer(const rpc::EnvironmentRequest& request) {
  rpc::EnvironmentResponse response;
  const auto fail = [&](StatusCode code, const char* text) {
    response.Clear();
    response.mutable_error()->set_code(static_cast<int>(code));
    response.mutable_error()->set_message(text);
  };
  try {
    take(request, response);
  } catch (const RequestError& error) {
    fail(error.code(), error.what());
  } catch (const std::exception& error) {
    fail(StatusCode::INTERNAL, error.what());
  }
  return response;
}

void Agent::take(const rpc::EnvironmentRequest& request, rpc::EnvironmentResponse& response) {
  switch (request.payload_case()) {
    case rpc::EnvironmentRequest::kCreateWorld:
      return create(request.create_world(), *response.mutable_create_world());
    case rpc::EnvironmentRequest::kJoinWorld:
      return join(request.join_world(), *response.mutable_join_world());
    case rpc::EnvironmentRequest::kStep:
      *response.mutable_step() = joined("step").step(seat_.place, request.step(), cancelled_);
      return;
    case rpc::EnvironmentRequest::kReset:
      return reset(request.reset(), *response.mutable_reset());
    case rpc::EnvironmentRequest::kResetWorld:
      response.mutable_reset_world();
      return reset_world(request.reset_world());
    case rpc::EnvironmentRequest::kLeaveWorld:
      response.mutable_leave_world();
      return leave();
    case rpc::EnvironmentRequest::kDestroyWorld:
      response.mutable_destroy_world();
      return destroy(request.destroy_world());
    case rpc::EnvironmentRequest::kExtension:
      return extension(request.extension(), *response.mutable_extension());
    case rpc::EnvironmentRequest::PAYLOAD_NOT_SET:
      throw RequestError(StatusCode::INVALID_ARGUMENT,
                         "found a request of no kind that version 1 has, expected create_world, "
                         "join_world, step, reset, reset_world, leave_world, destroy_world or "
                         "extension");
  }
}

void Agent::create(const rpc::CreateWorldRequest& request, rpc::CreateWorldResponse& response) {
  const int64_t seed = seed_of(request.settings()).value_or(worlds_.kind().seed);
  response.set_world_name(worlds_.create(seed));
}

void Agent::check_token(const RobotInterface& robot, const std::string& token) const {
  if (robot.token().empty()) return;
  const std::string tried = "robot " + robot.robot();
  if (const double wait_s = tries_.wait_s(peer_, tried); wait_s > 0)
    throw RequestError(StatusCode::UNAVAILABLE, scheduler::wait_text(wait_s));
  if (scheduler::same_token(robot.token(), token)) return;
  tries_.note_wrong(peer_, tried);
  throw RequestError(StatusCode::UNAUTHENTICATED,
                     fmt::format("setting 'token': not the token of robot '{}'", robot.robot()));
}

void Agent::join(const rpc::JoinWorldRequest& request, rpc::JoinWorldResponse& response) {
  if (seat_.world)
    throw RequestError(
        StatusCode::FAILED_PRECONDITION,
        fmt::format("this stream has joined world '{}' as '{}': leave_world first, or join from "
                    "another stream",
                    seat_.world->name(), seat_.world->robot_of(seat_.place).robot()));
  const auto world = worlds_.find(request.world_name());
  check_names(request.settings(), {"robot", "token"});
  const std::string token = text_of(request.settings(), "token");
  const size_t place = world->join(text_of(request.settings(), "robot"));
  try {
    check_token(world->robot_of(place), token);
  } catch (...) {
    world->leave(place);
    throw;
  }
  seat_ = {world, place};
  *response.mutable_specs() = world->robot_of(place).specs();
}

World& Agent::joined(const char* what) const {
  if (!seat_.world)
    throw RequestError(StatusCode::FAILED_PRECONDITION,
                       fmt::format("{}: this stream has not joined a world: create_world, then "
                                   "join_world",
                                   what));
  return *seat_.world;
}

void Agent::reset(const rpc::ResetRequest& request, rpc::ResetResponse& response) {
  World& world = joined("reset");
  if (const auto seed = seed_of(request.settings())) world.seed_next(*seed);
  world.reset(seat_.place);
  *response.mutable_specs() = world.robot_of(seat_.place).specs();
}

void Agent::reset_world(const rpc::ResetWorldRequest& request) {
  const auto world = worlds_.find(request.world_name());
  if (const auto seed = seed_of(request.settings())) world->seed_next(*seed);
  world->reset_all(world == seat_.world ? std::optional(seat_.place) : std::nullopt, cancelled_);
}

void Agent::leave() {
  if (!seat_.world) return;
  const Seat left = std::exchange(seat_, {});
  left.world->leave(left.place);
}

void Agent::destroy(const rpc::DestroyWorldRequest& request) {
  worlds_.destroy(request.world_name());
}

void Agent::extension(const google::protobuf::Any& request, google::protobuf::Any& response) {
  properties::PropertyRequest property;
  if (!request.Is<properties::PropertyRequest>())
    throw RequestError(StatusCode::UNIMPLEMENTED,
                       fmt::format("extension: found '{}', expected "
                                   "dm_env_rpc.v1.extensions.properties.PropertyRequest",
                                   request.type_url().substr(0, 128)));
  if (!request.UnpackTo(&property))
    throw RequestError(StatusCode::INVALID_ARGUMENT,
                       "extension: found bytes that are no PropertyRequest");
  response.PackFrom(answer_property(property, worlds_, seat_));
}

}  // namespace seam::tools::dm
