#include "scheduler/server/server.h"

#include <grpc/support/log.h>
#include <grpcpp/ext/proto_server_reflection_plugin.h>
#include <grpcpp/grpcpp.h>
#include <grpcpp/health_check_service_interface.h>

#include <cstdlib>
#include <deque>
#include <mutex>

#include "proto/client_channel.h"
#include "scheduler/server/descriptors.h"
#include "scheduler/server/listen_address.h"
#include "scheduler/server/services.h"
#include "scheduler/wire/wire.h"
#include "sim_core/base/error.h"

namespace seam::scheduler {

struct Server::Implementation {
  TokenTries tries;
  std::unique_ptr<grpc::Service> robots;
  std::unique_ptr<grpc::Service> supervisor;
  std::unique_ptr<grpc::Service> renderers;
  std::unique_ptr<grpc::Server> server;
};

namespace {

bool is_local(const std::string& address) {
  for (const char* prefix : {"unix:", "127.0.0.1:", "localhost:", "[::1]:"})
    if (address.rfind(prefix, 0) == 0) return true;
  return false;
}

std::shared_ptr<grpc::ServerCredentials> credentials_for(const ServerOptions& options,
                                                         const std::string& address) {
  // A Unix socket is protected by the file system's rights.
  if (address.rfind("unix:", 0) == 0 || (!options.tls && is_local(address)))
    return grpc::InsecureServerCredentials();
  if (!options.tls)
    throw UsageError(fmt::format(
        "{}: plain connections are served on a Unix socket or loopback only; give --certs DIR "
        "(`seam certs DIR` makes a test set)",
        address));
  grpc::SslServerCredentialsOptions tls(GRPC_SSL_REQUEST_AND_REQUIRE_CLIENT_CERTIFICATE_AND_VERIFY);
  tls.pem_root_certs = options.tls->ca;
  tls.pem_key_cert_pairs.push_back({options.tls->key, options.tls->certificate});
  return grpc::SslServerCredentials(tls);
}

// Once in a process: both change what servers built later offer.
void enable_plugins() {
  static std::once_flag once;
  std::call_once(once, [] {
    grpc::EnableDefaultHealthCheckService(true);
    // Errors come to our users as ours, in one line; GRPC_VERBOSITY brings gRPC's own log back.
    if (std::getenv("GRPC_VERBOSITY") == nullptr)
      gpr_set_log_verbosity(static_cast<gpr_log_severity>(GPR_LOG_SEVERITY_ERROR + 1));
    grpc::reflection::InitProtoReflectionServerBuilderPlugin();
  });
}

constexpr int kHandshake_ms = 5'000;
constexpr int kIdle_ms = 5 * 60'000;  // Without a call; clients connect again when they have one.

void set_limits(grpc::ServerBuilder& builder) {
  builder.SetMaxReceiveMessageSize(WireLimits::kMaxMessageBytes);
  builder.SetMaxSendMessageSize(kMaxServerMessageBytes);
  builder.AddChannelArgument(GRPC_ARG_MAX_CONCURRENT_STREAMS, 64);
  // Small messages in lockstep: probing the bandwidth would double the packets.
  builder.AddChannelArgument(GRPC_ARG_HTTP2_BDP_PROBE, 0);
  // A dead peer is noticed within 15 s, also while it owes nothing.
  builder.AddChannelArgument(GRPC_ARG_KEEPALIVE_TIME_MS, 10'000);
  builder.AddChannelArgument(GRPC_ARG_KEEPALIVE_TIMEOUT_MS, 5'000);
  builder.AddChannelArgument(GRPC_ARG_KEEPALIVE_PERMIT_WITHOUT_CALLS, 1);
  builder.AddChannelArgument(GRPC_ARG_HTTP2_MIN_RECV_PING_INTERVAL_WITHOUT_DATA_MS, 5'000);
  builder.AddChannelArgument(GRPC_ARG_HTTP2_MAX_PINGS_WITHOUT_DATA, 0);
  // Who connects and says nothing, and who is through with saying something, makes room.
  builder.AddChannelArgument("grpc.server_handshake_timeout_ms", kHandshake_ms);
  builder.AddChannelArgument(GRPC_ARG_MAX_CONNECTION_IDLE_MS, kIdle_ms);
  // A listening address that is taken is an error, not a share of its connections.
  builder.AddChannelArgument(GRPC_ARG_ALLOW_REUSEPORT, 0);
}

}  // namespace

Server::Server(const ServerOptions& options, const Scenario& scenario, const World& world,
               ClientHub& hub, RunControl& control)
    : implementation_(std::make_unique<Implementation>()) {
  for (const std::string& address : options.addresses) check_listen_address(address);
  enable_plugins();
  raise_descriptor_limit();
  implementation_->robots = make_robot_service(scenario, hub, implementation_->tries);
  implementation_->supervisor = make_supervisor_service(world, options.supervisor_token, hub,
                                                        control, implementation_->tries);
  implementation_->renderers = make_render_service(options.renderers, implementation_->tries);
  grpc::ServerBuilder builder;
  set_limits(builder);
  std::vector<int> ports(options.addresses.size(), 0);
  for (size_t i = 0; i < options.addresses.size(); ++i)
    builder.AddListeningPort(options.addresses[i], credentials_for(options, options.addresses[i]),
                             &ports[i]);
  builder.RegisterService(implementation_->robots.get());
  builder.RegisterService(implementation_->supervisor.get());
  builder.RegisterService(implementation_->renderers.get());
  {
    const std::vector<std::string>& addresses = options.addresses;
    const std::deque<SocketClaim> claims(addresses.begin(), addresses.end());
    implementation_->server = builder.BuildAndStart();
  }
  for (size_t i = 0; i < options.addresses.size(); ++i) {
    std::string address = options.addresses[i];
    if (!implementation_->server || ports[i] <= 0)
      throw InputError(fmt::format("{}: cannot listen on this address", address));
    if (address.rfind("unix:", 0) != 0)
      address = address.substr(0, address.rfind(':') + 1) + std::to_string(ports[i]);
    addresses_.push_back(address);
  }
}

Server::~Server() {
  if (implementation_->server) {
    implementation_->server->Shutdown(std::chrono::system_clock::now() + std::chrono::seconds(1));
    implementation_->server->Wait();
  }
}

}  // namespace seam::scheduler
