// Listeners of a gRPC server: plain and TLS connections, limits on what peers may take, health and
// reflection. Whatever we serve by gRPC goes through it.
#pragma once

#include <grpcpp/impl/service_type.h>

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "scheduler/listen/accept_loop.h"
#include "scheduler/listen/tls_texts.h"

namespace seam::scheduler {

struct ListenOptions {
  // "unix:/path" or "host:port"; port 0 is a free one. Without TLS only Unix sockets and loopback
  // are allowed (UsageError).
  std::vector<std::string> addresses;
  std::optional<TlsTexts> tls;
  std::optional<ConnectionLimits> limits;  // None: connection_limits().
  int most_received_bytes = 0;             // Of one message.
  int most_threads = 0;                    // For calls; 0: as many as there are calls.
  std::vector<Endpoint> others;            // Beside the addresses: what is no gRPC.
};

class GrpcListener {
 public:
  // Listens when it returns; throws InputError when an address cannot be had. The services outlive
  // it. `report`: something that a person should know.
  GrpcListener(ListenOptions options, const std::vector<grpc::Service*>& services,
               AcceptLoop::Report report);
  // Takes no connections any more; streams that are still open get a second to end.
  ~GrpcListener();
  GrpcListener(const GrpcListener&) = delete;
  GrpcListener& operator=(const GrpcListener&) = delete;

  // Takes no connections any more.
  void stop_listening();
  // As asked for, with the ports that were given.
  const std::vector<std::string>& addresses() const { return addresses_; }

 private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
  std::vector<std::string> addresses_;
};

}  // namespace seam::scheduler
