// Messages to the network: `Call` is answered at once, `Send` later, by a message to an entry.
#ifndef SEAM_OPEN_R_ANT_ENV_MSG_H
#define SEAM_OPEN_R_ANT_ENV_MSG_H

#include <MCOOP.h>
#include <antTypes.h>

#define ANTENVMSG void*

// The network of the robot, by the name "IPStack".
class antStackRef {
 public:
  antStackRef() : name_("") {}
  antStackRef(const char* name) : name_(name) {}
  bool IsValid() const { return *name_ != 0; }

 private:
  const char* name_;
};

// An end point, as the network numbers them.
class antModuleRef {
 public:
  antModuleRef() : number_(-1) {}
  explicit antModuleRef(int number) : number_(number) {}
  int Number() const { return number_; }
  bool operator==(const antModuleRef& m) const { return number_ == m.number_; }

 private:
  int number_;
};

class antSharedBuffer {
 public:
  antSharedBuffer() : base_(0), size_(0) {}
  antError Map() { return base_ == 0 ? ANT_INVALIDPTR : ANT_SUCCESS; }
  antError UnMap() { return ANT_SUCCESS; }
  void* GetAddress() { return base_; }
  uint32 GetSize() { return size_; }
  void Set(void* base, uint32 size) {
    base_ = base;
    size_ = size;
  }

 private:
  void* base_;
  uint32 size_;
};

// What a message asks for.
enum antRequest {
  antRequest_CreateEndpoint,
  antRequest_CreateBuffer,
  antRequest_DestroyBuffer,
  antRequest_TcpListen,
  antRequest_TcpConnect,
  antRequest_TcpSend,
  antRequest_TcpReceive,
  antRequest_TcpClose,
  antRequest_UdpBind,
  antRequest_UdpConnect,
  antRequest_UdpSend,
  antRequest_UdpReceive,
  antRequest_UdpClose
};

struct antEnvMsg {
  antRequest request;
  antModuleRef endpoint;
  void* continuation;  // The sender's, given back with the answer.

  explicit antEnvMsg(antRequest r, const antModuleRef& e = antModuleRef())
      : request(r), endpoint(e), continuation(0) {}

  antError Call(antStackRef stack, int size);
  // The answer is a copy of this message, which goes to an entry of the sender.
  antError Send(antStackRef stack, const OID& sender, int selector, int size);
  static antEnvMsg* Receive(ANTENVMSG message) { return static_cast<antEnvMsg*>(message); }
};

struct antEnvCreateEndpointMsg : antEnvMsg {
  antError error;
  int32 protocol;
  int32 poolSize;
  antModuleRef moduleRef;
  explicit antEnvCreateEndpointMsg(int32 p, int32 pool = 0)
      : antEnvMsg(antRequest_CreateEndpoint), error(ANT_FAIL), protocol(p), poolSize(pool) {}
};

struct antEnvCreateSharedBufferMsg : antEnvMsg {
  antError error;
  uint32 size;
  antSharedBuffer buffer;
  explicit antEnvCreateSharedBufferMsg(uint32 bytes)
      : antEnvMsg(antRequest_CreateBuffer), error(ANT_FAIL), size(bytes) {}
};

struct antEnvDestroySharedBufferMsg : antEnvMsg {
  antError error;
  antSharedBuffer buffer;
  explicit antEnvDestroySharedBufferMsg(const antSharedBuffer& b)
      : antEnvMsg(antRequest_DestroyBuffer), error(ANT_FAIL), buffer(b) {}
};

#endif
