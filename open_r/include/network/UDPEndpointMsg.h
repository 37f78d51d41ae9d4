// UDP over loopback.
#ifndef SEAM_OPEN_R_UDP_ENDPOINT_MSG_H
#define SEAM_OPEN_R_UDP_ENDPOINT_MSG_H

#include <IPAddress.h>
#include <antEnvMsg.h>

enum UDPEndpointError {
  UDP_SUCCESS = 0,
  UDP_FAIL = 1,
  UDP_CONNECTION_CLOSED = 2,
  UDP_CONNECTION_BUSY = 3,
  UDP_ADDRESSINUSE = 4,
  UDP_ADDRESSERROR = 5,
  UDP_PORT_UNREACHABLE = 6,
  UDP_HOST_UNREACHABLE = 8,
  UDP_BUFFER_INVALID = 13,
  UDP_OPERATION_INVALID = 14
};

struct UDPEndpointBaseMsg : antEnvMsg {
  UDPEndpointError error;
  UDPEndpointBaseMsg(antRequest r, const antModuleRef& e) : antEnvMsg(r, e), error(UDP_FAIL) {}
};

struct UDPEndpointBindMsg : UDPEndpointBaseMsg {
  IPAddress address;
  Port port;
  UDPEndpointBindMsg(const antModuleRef& e, IPAddress a, Port p)
      : UDPEndpointBaseMsg(antRequest_UdpBind, e), address(a), port(p) {}
};

struct UDPEndpointConnectMsg : UDPEndpointBaseMsg {
  IPAddress address;
  Port port;
  UDPEndpointConnectMsg(const antModuleRef& e, IPAddress a, Port p)
      : UDPEndpointBaseMsg(antRequest_UdpConnect, e), address(a), port(p) {}
};

struct UDPEndpointSendMsg : UDPEndpointBaseMsg {
  IPAddress address;
  Port port;
  byte* buffer;
  int size;
  UDPEndpointSendMsg(const antModuleRef& e, byte* b, int n)
      : UDPEndpointBaseMsg(antRequest_UdpSend, e), port(0), buffer(b), size(n) {}
  UDPEndpointSendMsg(const antModuleRef& e, IPAddress a, Port p, byte* b, int n)
      : UDPEndpointBaseMsg(antRequest_UdpSend, e), address(a), port(p), buffer(b), size(n) {}
};

// Answered with one datagram, its size and its sender.
struct UDPEndpointReceiveMsg : UDPEndpointBaseMsg {
  IPAddress address;
  Port port;
  byte* buffer;
  int size;
  UDPEndpointReceiveMsg(const antModuleRef& e, byte* b, int n)
      : UDPEndpointBaseMsg(antRequest_UdpReceive, e), port(0), buffer(b), size(n) {}
};

struct UDPEndpointCloseMsg : UDPEndpointBaseMsg {
  explicit UDPEndpointCloseMsg(const antModuleRef& e)
      : UDPEndpointBaseMsg(antRequest_UdpClose, e) {}
};

#endif
