// The gRPC services; only server.cc and the services' own files include this.
#pragma once

#include <grpcpp/impl/service_type.h>

#include <memory>

#include "scheduler/loop/run_control.h"
#include "scheduler/remote_render/remote_renderer.h"
#include "scheduler/server/client_hub.h"
#include "sim_core/world/world.h"

namespace seam::scheduler {

std::unique_ptr<grpc::Service> make_robot_service(const Scenario& scenario, ClientHub& hub);
std::unique_ptr<grpc::Service> make_supervisor_service(const World& world, std::string token,
                                                       ClientHub& hub, RunControl& control);
// None: renderers are told that the server renders.
std::unique_ptr<grpc::Service> make_render_service(RemoteRenderer* renderer);

}  // namespace seam::scheduler
