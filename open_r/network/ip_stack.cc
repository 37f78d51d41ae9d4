#include "open_r/network/ip_stack.h"

#include <EndpointTypes.h>
#include <arpa/inet.h>
#include <fcntl.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <utility>

namespace seam::open_r {
namespace {

IpStack* newest = nullptr;

constexpr int kQueued = 8;
// A port that is taken, or that only root may have: another this far above.
constexpr int kOtherPorts = 20000, kTries = 50;

sockaddr_in loopback(int port) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<uint16_t>(port));
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  return address;
}

int new_socket(int kind) {
  return ::socket(AF_INET, kind | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
}

bool bound(int socket, int port) {
  const sockaddr_in address = loopback(port);
  return ::bind(socket, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0;
}

// The port of this machine that stands for one of the robot's; -1 where none is free.
int bind_near(int socket, Port port) {
  if (bound(socket, port)) return port;
  for (int i = 0; i < kTries; ++i)
    if (bound(socket, (port + kOtherPorts + i) % 65536)) return (port + kOtherPorts + i) % 65536;
  return -1;
}

bool reachable(const IPAddress& address) {
  return address == IP_ADDR_ANY || address.InLoop();
}

bool again() {
  return errno == EAGAIN || errno == EWOULDBLOCK || errno == EINTR;
}

}  // namespace

IpStack& IpStack::current() {
  if (newest == nullptr) throw Fault("a call of the network outside of an object");
  return *newest;
}

IpStack::IpStack(System& system) : system_(system), before_(std::exchange(newest, this)) {}

IpStack::~IpStack() {
  for (const Endpoint& endpoint : endpoints_)
    if (endpoint.socket >= 0) ::close(endpoint.socket);
  for (const auto& [port, socket] : listeners_) ::close(socket);
  newest = before_;
}

IpStack::Endpoint* IpStack::endpoint_of(const antEnvMsg& message) {
  const int number = message.endpoint.Number();
  if (number < 0 || static_cast<size_t>(number) >= endpoints_.size()) return nullptr;
  return &endpoints_[static_cast<size_t>(number)];
}

antError IpStack::call(antEnvMsg& message) {
  switch (message.request) {
    case antRequest_CreateEndpoint: {
      auto& create = static_cast<antEnvCreateEndpointMsg&>(message);
      const bool known = create.protocol == EndpointType_TCP || create.protocol == EndpointType_UDP;
      create.error = known ? ANT_SUCCESS : ANT_ENDPOINT_NOFACTORY;
      if (!known) return ANT_SUCCESS;
      create.moduleRef = antModuleRef(static_cast<int>(endpoints_.size()));
      endpoints_.push_back({.protocol = create.protocol, .owner = system_.running()});
      return ANT_SUCCESS;
    }
    case antRequest_CreateBuffer: {
      auto& create = static_cast<antEnvCreateSharedBufferMsg&>(message);
      buffers_.push_back(std::make_unique<byte[]>(create.size));
      create.buffer.Set(buffers_.back().get(), create.size);
      create.error = ANT_SUCCESS;
      return ANT_SUCCESS;
    }
    case antRequest_DestroyBuffer: {
      auto& destroy = static_cast<antEnvDestroySharedBufferMsg&>(message);
      buffers_.remove_if([&](const auto& b) { return b.get() == destroy.buffer.GetAddress(); });
      destroy.error = ANT_SUCCESS;
      return ANT_SUCCESS;
    }
    default: {
      // A call of what may take its time is tried once.
      Waiting once{{&message, [](antEnvMsg*) {}}, {}};
      return attempt(once) ? ANT_SUCCESS : ANT_FAIL;
    }
  }
}

antError IpStack::send(const antEnvMsg& message, const OServiceEntry& entry, size_t size) {
  // Messages are plain: a copy has all of the one that is sent.
  void* copy = std::malloc(size);
  std::memcpy(copy, &message, size);
  waiting_.push_back({std::shared_ptr<antEnvMsg>(static_cast<antEnvMsg*>(copy), std::free), entry});
  return ANT_SUCCESS;
}

void IpStack::poll() {
  // An answer may lead to new messages: those are looked at in the next turn.
  std::list<Waiting> now = std::exchange(waiting_, {});
  for (auto at = now.begin(); at != now.end();) {
    if (!attempt(*at)) {
      ++at;
      continue;
    }
    system_.post(at->entry, at->message);
    at = now.erase(at);
  }
  waiting_.splice(waiting_.begin(), now);
}

bool IpStack::attempt(Waiting& waiting) {
  antEnvMsg& message = *waiting.message;
  Endpoint* endpoint = endpoint_of(message);
  auto& tcp = static_cast<TCPEndpointBaseMsg&>(message);
  if (endpoint == nullptr) {
    tcp.error = TCP_OPERATION_INVALID;
    return true;
  }
  switch (message.request) {
    case antRequest_TcpListen:
      return listen(static_cast<TCPEndpointListenMsg&>(message), *endpoint);
    case antRequest_TcpConnect:
      return connect(static_cast<TCPEndpointConnectMsg&>(message), *endpoint);
    case antRequest_TcpSend:
      return send_bytes(waiting, static_cast<TCPEndpointSendMsg&>(message), *endpoint);
    case antRequest_TcpReceive:
      return receive_bytes(waiting, static_cast<TCPEndpointReceiveMsg&>(message), *endpoint);
    case antRequest_TcpClose:
      close(*endpoint, message.endpoint.Number());
      tcp.error = TCP_SUCCESS;
      return true;
    default: {
      const UDPEndpointError error = do_udp(message, *endpoint);
      static_cast<UDPEndpointBaseMsg&>(message).error = error;
      return error != UDP_CONNECTION_BUSY;
    }
  }
}

// ---- TCP ----

int IpStack::listener(Port port, OID owner) {
  const auto known = listeners_.find(port);
  if (known != listeners_.end()) return known->second;
  const int socket = new_socket(SOCK_STREAM);
  const int yes = 1;
  ::setsockopt(socket, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
  const int taken = bind_near(socket, port);
  if (taken < 0 || ::listen(socket, kQueued) != 0) {
    ::close(socket);
    return -1;
  }
  std::printf("%s listens on 127.0.0.1:%d\n", system_.name(owner).c_str(), taken);
  return listeners_[port] = socket;
}

bool IpStack::listen(TCPEndpointListenMsg& message, Endpoint& endpoint) {
  const int socket = listener(message.lPort, endpoint.owner);
  message.error = TCP_ADDRESSINUSE;
  if (socket < 0) return true;
  const int accepted = ::accept4(socket, nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC);
  if (accepted < 0) return false;
  endpoint.socket = accepted;
  message.error = TCP_SUCCESS;
  message.fAddress = IPAddress(127, 0, 0, 1);
  return true;
}

bool IpStack::connect(TCPEndpointConnectMsg& message, Endpoint& endpoint) {
  message.error = TCP_HOST_UNREACHABLE;
  if (!reachable(message.fAddress)) return true;
  if (!endpoint.connecting) endpoint.socket = new_socket(SOCK_STREAM);
  endpoint.connecting = true;
  const sockaddr_in address = loopback(message.fPort);
  const int code =
      ::connect(endpoint.socket, reinterpret_cast<const sockaddr*>(&address), sizeof address);
  if (code != 0 && (errno == EINPROGRESS || errno == EALREADY)) return false;
  endpoint.connecting = false;
  message.error = code == 0 || errno == EISCONN ? TCP_SUCCESS : TCP_PORT_UNREACHABLE;
  return true;
}

bool IpStack::send_bytes(Waiting& waiting, TCPEndpointSendMsg& message, Endpoint& endpoint) {
  message.error = TCP_CONNECTION_CLOSED;
  if (endpoint.socket < 0) return true;
  while (waiting.done < message.size) {
    const ssize_t size = ::send(endpoint.socket, message.buffer + waiting.done,
                                static_cast<size_t>(message.size - waiting.done), MSG_NOSIGNAL);
    if (size < 0 && again()) return false;
    if (size < 0) return true;
    waiting.done += static_cast<int>(size);
  }
  message.error = TCP_SUCCESS;
  return true;
}

bool IpStack::receive_bytes(Waiting& waiting, TCPEndpointReceiveMsg& message, Endpoint& endpoint) {
  message.error = TCP_CONNECTION_CLOSED;
  if (endpoint.socket < 0) return true;
  const int least = std::max(1, message.sizeMin);
  while (waiting.done < message.sizeMax) {
    const ssize_t size = ::recv(endpoint.socket, message.buffer + waiting.done,
                                static_cast<size_t>(message.sizeMax - waiting.done), 0);
    if (size < 0 && again()) break;
    if (size <= 0) return true;
    waiting.done += static_cast<int>(size);
  }
  if (waiting.done < least) return false;
  message.sizeMin = waiting.done;
  message.error = TCP_SUCCESS;
  return true;
}

void IpStack::close(Endpoint& endpoint, int number) {
  if (endpoint.socket >= 0) ::close(endpoint.socket);
  endpoint.socket = -1;
  endpoint.connecting = false;
  // What still waits for it is answered: the connection is closed.
  for (auto at = waiting_.begin(); at != waiting_.end();) {
    if (at->message->endpoint.Number() != number) {
      ++at;
      continue;
    }
    static_cast<TCPEndpointBaseMsg&>(*at->message).error = TCP_CONNECTION_CLOSED;
    system_.post(at->entry, at->message);
    at = waiting_.erase(at);
  }
}

// ---- UDP ----

UDPEndpointError IpStack::do_udp(antEnvMsg& message, Endpoint& endpoint) {
  if (endpoint.socket < 0 && message.request != antRequest_UdpClose)
    endpoint.socket = new_socket(SOCK_DGRAM);
  switch (message.request) {
    case antRequest_UdpBind: {
      const int port = bind_near(endpoint.socket, static_cast<UDPEndpointBindMsg&>(message).port);
      if (port < 0) return UDP_ADDRESSINUSE;
      std::printf("%s takes datagrams on 127.0.0.1:%d\n", system_.name(endpoint.owner).c_str(),
                  port);
      return UDP_SUCCESS;
    }
    case antRequest_UdpConnect: {
      const auto& to = static_cast<UDPEndpointConnectMsg&>(message);
      if (!reachable(to.address)) return UDP_HOST_UNREACHABLE;
      const sockaddr_in address = loopback(to.port);
      return ::connect(endpoint.socket, reinterpret_cast<const sockaddr*>(&address),
                       sizeof address) == 0
                 ? UDP_SUCCESS
                 : UDP_FAIL;
    }
    case antRequest_UdpSend: {
      const auto& out = static_cast<UDPEndpointSendMsg&>(message);
      if (!reachable(out.address)) return UDP_HOST_UNREACHABLE;
      const sockaddr_in address = loopback(out.port);
      const sockaddr* to = out.port == 0 ? nullptr : reinterpret_cast<const sockaddr*>(&address);
      return ::sendto(endpoint.socket, out.buffer, static_cast<size_t>(out.size), 0, to,
                      to == nullptr ? 0 : sizeof address) == out.size
                 ? UDP_SUCCESS
                 : UDP_FAIL;
    }
    case antRequest_UdpReceive: {
      auto& in = static_cast<UDPEndpointReceiveMsg&>(message);
      sockaddr_in from{};
      socklen_t size = sizeof from;
      const ssize_t got = ::recvfrom(endpoint.socket, in.buffer, static_cast<size_t>(in.size), 0,
                                     reinterpret_cast<sockaddr*>(&from), &size);
      if (got < 0) return again() ? UDP_CONNECTION_BUSY : UDP_FAIL;
      in.size = static_cast<int>(got);
      in.address = IPAddress(ntohl(from.sin_addr.s_addr));
      in.port = ntohs(from.sin_port);
      return UDP_SUCCESS;
    }
    default:
      close(endpoint, message.endpoint.Number());
      return UDP_SUCCESS;
  }
}

}  // namespace seam::open_r

// ---- What programs call ----

antError antEnvMsg::Call(antStackRef, int) {
  return seam::open_r::IpStack::current().call(*this);
}

antError antEnvMsg::Send(antStackRef, const OID& sender, int selector, int size) {
  return seam::open_r::IpStack::current().send(
      *this, OServiceEntry(sender, static_cast<Selector>(selector)), static_cast<size_t>(size));
}

IPAddress::IPAddress(const char* text) : address(0) {
  in_addr parsed{};
  if (inet_aton(text, &parsed) != 0) address = ntohl(parsed.s_addr);
}

char* IPAddress::GetAsString(char* text) const {
  std::snprintf(text, 16, "%u.%u.%u.%u", address >> 24, address >> 16 & 255, address >> 8 & 255,
                address & 255);
  return text;
}
