#include "proto/client_channel.h"

#include <fstream>
#include <iterator>
#include <stdexcept>

namespace seam {
namespace {

std::string file_text(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) throw std::runtime_error("cannot read " + path);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

}  // namespace

std::shared_ptr<grpc::Channel> open_channel(const std::string& address,
                                            const std::string& certificates) {
  grpc::ChannelArguments arguments;
  arguments.SetMaxReceiveMessageSize(kMaxServerMessageBytes);
  arguments.SetInt(GRPC_ARG_HTTP2_BDP_PROBE,
                   0);  // Lockstep on a near machine: no probing of the line.
  arguments.SetInt(GRPC_ARG_KEEPALIVE_TIME_MS, 10'000);
  arguments.SetInt(GRPC_ARG_KEEPALIVE_TIMEOUT_MS, 5'000);
  arguments.SetInt(GRPC_ARG_HTTP2_MAX_PINGS_WITHOUT_DATA, 0);
  arguments.SetInt(GRPC_ARG_MAX_RECONNECT_BACKOFF_MS, 500);
  arguments.SetInt(GRPC_ARG_INITIAL_RECONNECT_BACKOFF_MS, 50);
  arguments.SetInt(GRPC_ARG_USE_LOCAL_SUBCHANNEL_POOL, 1);
  std::shared_ptr<grpc::ChannelCredentials> credentials = grpc::InsecureChannelCredentials();
  if (!certificates.empty()) {
    credentials = grpc::SslCredentials({.pem_root_certs = file_text(certificates + "/ca.pem"),
                                        .pem_private_key = file_text(certificates + "/client.key"),
                                        .pem_cert_chain = file_text(certificates + "/client.pem")});
  }
  return grpc::CreateCustomChannel(address, credentials, arguments);
}

bool passes(grpc::StatusCode code) {
  return code == grpc::StatusCode::UNAVAILABLE || code == grpc::StatusCode::CANCELLED ||
         code == grpc::StatusCode::DEADLINE_EXCEEDED || code == grpc::StatusCode::INTERNAL;
}

}  // namespace seam
