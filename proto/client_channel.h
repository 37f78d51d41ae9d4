// How a client, be it a behaviour or a renderer, reaches a SEAM server.
#pragma once

#include <grpcpp/grpcpp.h>

#include <memory>
#include <string>

namespace seam {

// The longest message that a client takes: some frames of a large camera at once.
inline constexpr int kMaxServerMessageBytes = 64 << 20;

// `address`: "unix:/path" or "host:port". `certificates`: a folder with ca.pem, client.pem and
// client.key (as `seam certs` makes it) for TLS; empty: plain, which a server accepts on a Unix
// socket or loopback only. Each channel is a connection of its own: who reconnects must not inherit
// another's broken one. Throws std::runtime_error for a file that cannot be read.
std::shared_ptr<grpc::Channel> open_channel(const std::string& address,
                                            const std::string& certificates);

// Worth another try: the server is not up yet, or the connection broke.
bool passes(grpc::StatusCode code);

}  // namespace seam
