#include "scheduler/server/grpc_listener.h"

#include <grpc/support/log.h>
#include <grpcpp/ext/proto_server_reflection_plugin.h>
#include <grpcpp/grpcpp.h>
#include <grpcpp/health_check_service_interface.h>

#include <cstdlib>
#include <mutex>

#include "proto/client_channel.h"
#include "scheduler/listen/descriptors.h"
#include "scheduler/listen/listen_address.h"
#include "sim_core/base/error.h"

namespace seam::scheduler {

namespace {

using Acceptor = std::unique_ptr<grpc::experimental::ExternalConnectionAcceptor>;

bool is_local(const std::string& address) {
  for (const char* prefix : {"unix:", "127.0.0.1:", "localhost:", "[::1]:"})
    if (address.rfind(prefix, 0) == 0) return true;
  return false;
}

Spoken spoken_at(const ListenOptions& options, const std::string& address) {
  // A Unix socket is protected by the file system's rights.
  if (address.rfind("unix:", 0) == 0 || (!options.tls && is_local(address))) return Spoken::http2;
  if (!options.tls)
    throw UsageError(fmt::format(
        "{}: plain connections are served on a Unix socket or loopback only; give --certs DIR "
        "(`seam certs DIR` makes a test set)",
        address));
  return Spoken::tls;
}

std::shared_ptr<grpc::ServerCredentials> credentials_of(const TlsTexts& texts) {
  grpc::SslServerCredentialsOptions tls(GRPC_SSL_REQUEST_AND_REQUIRE_CLIENT_CERTIFICATE_AND_VERIFY);
  tls.pem_root_certs = texts.ca;
  tls.pem_key_cert_pairs.push_back({texts.key, texts.certificate});
  return grpc::SslServerCredentials(tls);
}

Acceptor add_acceptor(grpc::ServerBuilder& builder,
                      const std::shared_ptr<grpc::ServerCredentials>& credentials) {
  using Experimental = grpc::ServerBuilder::experimental_type;
  return builder.experimental().AddExternalConnectionAcceptor(
      Experimental::ExternalConnectionType::FROM_FD, credentials);
}

void take(grpc::experimental::ExternalConnectionAcceptor& acceptor, int listener, int connection) {
  grpc::experimental::ExternalConnectionAcceptor::NewConnectionParameters parameters;
  parameters.listener_fd = listener;
  parameters.fd = connection;
  acceptor.HandleNewConnection(&parameters);
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

void set_limits(grpc::ServerBuilder& builder, int most_received_bytes) {
  builder.SetMaxReceiveMessageSize(most_received_bytes);
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
}

}  // namespace

struct GrpcListener::Implementation {
  // Of plain and of TLS connections. gRPC's own listeners end for good where descriptors run out.
  Acceptor plain;
  Acceptor tls;
  std::unique_ptr<grpc::Server> server;
  std::optional<AcceptLoop> listeners;
};

GrpcListener::GrpcListener(ListenOptions options, const std::vector<grpc::Service*>& services,
                           AcceptLoop::Report report)
    : implementation_(std::make_unique<Implementation>()) {
  std::vector<Endpoint> endpoints;
  for (const std::string& address : options.addresses) {
    check_listen_address(address);
    endpoints.push_back({address, spoken_at(options, address), {}});
  }
  enable_plugins();
  raise_descriptor_limit();
  grpc::ServerBuilder builder;
  set_limits(builder, options.most_received_bytes);
  if (options.most_threads > 0)
    builder.SetResourceQuota(grpc::ResourceQuota().SetMaxThreads(options.most_threads));
  implementation_->plain = add_acceptor(builder, grpc::InsecureServerCredentials());
  if (options.tls) implementation_->tls = add_acceptor(builder, credentials_of(*options.tls));
  for (Endpoint& endpoint : endpoints) {
    auto& acceptor =
        endpoint.spoken == Spoken::tls ? *implementation_->tls : *implementation_->plain;
    endpoint.take = [&acceptor](int listener, int connection) {
      take(acceptor, listener, connection);
    };
  }
  for (Endpoint& other : options.others) endpoints.push_back(std::move(other));
  implementation_->listeners.emplace(
      std::move(endpoints), options.limits.value_or(connection_limits()), std::move(report));
  addresses_ = implementation_->listeners->addresses();
  addresses_.resize(options.addresses.size());
  for (grpc::Service* service : services) builder.RegisterService(service);
  implementation_->server = builder.BuildAndStart();
  if (!implementation_->server)
    throw InputError("the server cannot start; with --certs: are certificate and key a pair?");
  implementation_->listeners->start();
}

void GrpcListener::stop_listening() {
  implementation_->listeners.reset();
}

GrpcListener::~GrpcListener() {
  stop_listening();
  if (implementation_->server) {
    implementation_->server->Shutdown(std::chrono::system_clock::now() + std::chrono::seconds(1));
    implementation_->server->Wait();
  }
}

}  // namespace seam::scheduler
