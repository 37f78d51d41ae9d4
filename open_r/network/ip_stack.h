// The robot's network: TCP and UDP over loopback, without waiting. What has come is looked at once
// a turn, so that a program hears of it between two messages.
#pragma once

#include <TCPEndpointMsg.h>
#include <UDPEndpointMsg.h>

#include <list>
#include <map>
#include <memory>
#include <vector>

#include "open_r/library/system.h"

namespace seam::open_r {

class IpStack {
 public:
  // That which messages mean, the newest one of this process.
  static IpStack& current();

  explicit IpStack(System& system);
  ~IpStack();
  IpStack(const IpStack&) = delete;
  IpStack& operator=(const IpStack&) = delete;

  antError call(antEnvMsg& message);
  antError send(const antEnvMsg& message, const OServiceEntry& entry, size_t size);
  // Answers what can be answered now.
  void poll();

 private:
  struct Endpoint {
    int protocol = 0;
    OID owner;  // The object that made it.
    int socket = -1;
    bool connecting = false;
  };
  struct Waiting {
    std::shared_ptr<antEnvMsg> message;
    OServiceEntry entry;
    int done = 0;  // Bytes sent or received.
  };
  Endpoint* endpoint_of(const antEnvMsg& message);
  // Whether the message is answered.
  bool attempt(Waiting& waiting);
  bool listen(TCPEndpointListenMsg& message, Endpoint& endpoint);
  bool connect(TCPEndpointConnectMsg& message, Endpoint& endpoint);
  bool send_bytes(Waiting& waiting, TCPEndpointSendMsg& message, Endpoint& endpoint);
  bool receive_bytes(Waiting& waiting, TCPEndpointReceiveMsg& message, Endpoint& endpoint);
  void close(Endpoint& endpoint, int number);
  UDPEndpointError do_udp(antEnvMsg& message, Endpoint& endpoint);
  int listener(Port port, OID owner);

  System& system_;
  std::vector<Endpoint> endpoints_;
  std::map<Port, int> listeners_;
  std::list<Waiting> waiting_;
  std::list<std::unique_ptr<byte[]>> buffers_;
  IpStack* before_;
};

}  // namespace seam::open_r
