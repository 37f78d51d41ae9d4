#include "scheduler/server/server.h"

#include "scheduler/server/direct_lines.h"
#include "scheduler/server/grpc_listener.h"
#include "scheduler/server/services.h"
#include "scheduler/wire/wire.h"

namespace seam::scheduler {

struct Server::Implementation {
  Implementation(const ServerOptions& options, const Scenario& scenario, ClientHub& hub)
      : sessions{scenario, hub, tries, options.supervisor_token, options.watches} {}

  TokenTries tries;
  const SessionParts sessions;
  std::unique_ptr<grpc::Service> robots;
  std::unique_ptr<grpc::Service> supervisor;
  std::unique_ptr<grpc::Service> renderers;
  std::optional<GrpcListener> listener;
  std::optional<DirectLines> lines;
};

Server::Server(const ServerOptions& options, const Scenario& scenario, const World& world,
               ClientHub& hub, RunControl& control)
    : implementation_(std::make_unique<Implementation>(options, scenario, hub)) {
  Implementation& parts = *implementation_;
  parts.robots = make_robot_service(parts.sessions);
  parts.supervisor =
      make_supervisor_service(world, options.supervisor_token, hub, control, parts.tries);
  parts.renderers = make_render_service(options.renderers, parts.tries);
  ListenOptions listening{.addresses = options.addresses,
                          .tls = options.tls,
                          .limits = options.limits,
                          .most_received_bytes = WireLimits::kMaxReceivedBytes};
  if (!options.lines.empty()) {
    DirectLines& lines = parts.lines.emplace(parts.sessions);
    listening.others.push_back(
        {"unix:" + options.lines, Spoken::line,
         [&lines](int /*listener*/, int connection) { lines.add(connection); }});
  }
  parts.listener.emplace(
      std::move(listening),
      std::vector{parts.robots.get(), parts.supervisor.get(), parts.renderers.get()},
      [&hub](const std::string& what) { hub.note_fault(-1, "connections", what); });
  addresses_ = parts.listener->addresses();
}

Server::~Server() {
  if (implementation_->listener) implementation_->listener->stop_listening();
  implementation_->lines.reset();
  implementation_->listener.reset();
}

}  // namespace seam::scheduler
