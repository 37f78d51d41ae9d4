// The gRPC services; only server.cc and the services' own files include this.
#pragma once

#include <grpcpp/impl/service_type.h>

#include <memory>

#include "scheduler/clients/client_hub.h"
#include "scheduler/clients/token_tries.h"
#include "scheduler/loop/run_control.h"
#include "scheduler/remote_render/remote_renderer.h"
#include "scheduler/server/robot_session.h"
#include "sim_core/world/world.h"

namespace seam::scheduler {

// The parts outlive the service.
std::unique_ptr<grpc::Service> make_robot_service(const SessionParts& parts);
std::unique_ptr<grpc::Service> make_supervisor_service(const World& world, std::string token,
                                                       ClientHub& hub, RunControl& control,
                                                       TokenTries& tries);
// None: renderers are refused, as the server renders.
std::unique_ptr<grpc::Service> make_render_service(RemoteRenderer* renderer, TokenTries& tries);

}  // namespace seam::scheduler
