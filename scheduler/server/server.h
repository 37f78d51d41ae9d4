// The gRPC server of a run: robots' and renderers' streams, the supervisor's calls, health and
// reflection. proto/seam/v1/ is the contract.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "scheduler/clients/client_hub.h"
#include "scheduler/listen/connection_count.h"
#include "scheduler/listen/tls_texts.h"
#include "scheduler/loop/run_control.h"
#include "scheduler/remote_render/remote_renderer.h"
#include "scheduler/server/watch.h"
#include "sim_core/scenario/scenario.h"
#include "sim_core/world/world.h"

namespace seam::scheduler {

struct ServerOptions {
  // "unix:/path" or "host:port"; port 0 is a free one. Without TLS only Unix sockets and loopback
  // are allowed (UsageError).
  std::vector<std::string> addresses;
  std::optional<TlsTexts> tls;
  std::string supervisor_token;
  RemoteRenderer* renderers = nullptr;     // Where frames are rendered by other processes.
  std::optional<ConnectionLimits> limits;  // None: connection_limits().
  WatchSource* watches = nullptr;          // What a script may watch; outlives the server.
  // The path of a Unix socket for direct lines (proto/line.h); empty: none.
  std::string lines;
};

class Server {
 public:
  // Listens when it returns; throws InputError when an address cannot be had. The world is read on
  // the loop's thread only (RunControl::post).
  Server(const ServerOptions& options, const Scenario& scenario, const World& world, ClientHub& hub,
         RunControl& control);
  // Streams that are still open get a second to take their Goodbye.
  ~Server();
  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;

  // As asked for, with the ports that were given.
  const std::vector<std::string>& addresses() const { return addresses_; }

 private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
  std::vector<std::string> addresses_;
};

}  // namespace seam::scheduler
