// TCP over loopback.
#ifndef SEAM_OPEN_R_TCP_ENDPOINT_MSG_H
#define SEAM_OPEN_R_TCP_ENDPOINT_MSG_H

#include <IPAddress.h>
#include <antEnvMsg.h>

enum TCPEndpointError {
  TCP_SUCCESS = 0,
  TCP_FAIL = 1,
  TCP_CONNECTION_CLOSED = 2,
  TCP_CONNECTION_RESET = 3,
  TCP_CONNECTION_TIMEOUT = 4,
  TCP_CONNECTION_BUSY = 5,
  TCP_ADDRESSINUSE = 6,
  TCP_ADDRESSERROR = 7,
  TCP_PORT_UNREACHABLE = 8,
  TCP_HOST_UNREACHABLE = 10,
  TCP_NETWORK_UNREACHABLE = 11,
  TCP_BUFFER_INVALID = 16,
  TCP_OPERATION_INVALID = 17
};

struct TCPEndpointBaseMsg : antEnvMsg {
  TCPEndpointError error;
  TCPEndpointBaseMsg(antRequest r, const antModuleRef& e) : antEnvMsg(r, e), error(TCP_FAIL) {}
};

// Answered when somebody has connected.
struct TCPEndpointListenMsg : TCPEndpointBaseMsg {
  IPAddress lAddress;
  Port lPort;
  IPAddress fAddress;
  Port fPort;
  TCPEndpointListenMsg(const antModuleRef& e, IPAddress la = 0, Port lp = 0, IPAddress fa = 0,
                       Port fp = 0)
      : TCPEndpointBaseMsg(antRequest_TcpListen, e),
        lAddress(la),
        lPort(lp),
        fAddress(fa),
        fPort(fp) {}
};

struct TCPEndpointConnectMsg : TCPEndpointBaseMsg {
  IPAddress lAddress;
  Port lPort;
  IPAddress fAddress;
  Port fPort;
  TCPEndpointConnectMsg(const antModuleRef& e, IPAddress la, Port lp, IPAddress fa, Port fp)
      : TCPEndpointBaseMsg(antRequest_TcpConnect, e),
        lAddress(la),
        lPort(lp),
        fAddress(fa),
        fPort(fp) {}
};

struct TCPEndpointSendMsg : TCPEndpointBaseMsg {
  byte* buffer;
  int size;
  TCPEndpointSendMsg(const antModuleRef& e, byte* b, int n)
      : TCPEndpointBaseMsg(antRequest_TcpSend, e), buffer(b), size(n) {}
};

// Answered with at least sizeMin bytes; sizeMin is then how many there are.
struct TCPEndpointReceiveMsg : TCPEndpointBaseMsg {
  byte* buffer;
  int sizeMin;
  int sizeMax;
  TCPEndpointReceiveMsg(const antModuleRef& e, byte* b, int least, int most)
      : TCPEndpointBaseMsg(antRequest_TcpReceive, e), buffer(b), sizeMin(least), sizeMax(most) {}
};

struct TCPEndpointCloseMsg : TCPEndpointBaseMsg {
  bool abort;
  explicit TCPEndpointCloseMsg(const antModuleRef& e, bool = false, int = 0, bool a = false)
      : TCPEndpointBaseMsg(antRequest_TcpClose, e), abort(a) {}
};

#endif
