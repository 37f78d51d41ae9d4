// End points over loopback, answered between the frames.
#include "open_r/network/ip_stack.h"

#include <EndpointTypes.h>
#include <TCPEndpointMsg.h>
#include <UDPEndpointMsg.h>
#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cstdio>

namespace seam::open_r {
namespace {

constexpr Selector kAnswer = 9;
const antStackRef kStack("IPStack");

class Network : public ::testing::Test {
 protected:
  Network() {
    object = system.begin_object("Object");
    antEnvCreateEndpointMsg create(EndpointType_TCP);
    create.Call(kStack, sizeof create);
    endpoint = create.moduleRef;
    system.end_object(object, [this](Selector, void* message) {
      errors.push_back(static_cast<TCPEndpointBaseMsg*>(antEnvMsg::Receive(message))->error);
    });
  }
  // Turns until the object is answered.
  void poll() {
    for (int i = 0; i < 1000 && errors.empty(); ++i) {
      stack.poll();
      system.deliver();
      if (errors.empty()) usleep(1000);
    }
  }

  System system;
  IpStack stack{system};
  OID object;
  antModuleRef endpoint;
  std::vector<int> errors;
};

// Between frames no object runs: who listens is known from who made the end point.
TEST_F(Network, AConnectionAndItsBytesAreAnswered) {
  TCPEndpointListenMsg listen(endpoint, IP_ADDR_ANY, 10020);
  listen.Send(kStack, object, kAnswer, sizeof listen);
  testing::internal::CaptureStdout();
  stack.poll();
  const std::string said = testing::internal::GetCapturedStdout();
  int port = 0;
  ASSERT_EQ(std::sscanf(said.c_str(), "Object listens on 127.0.0.1:%d", &port), 1) << said;
  EXPECT_TRUE(errors.empty());

  const int client = ::socket(AF_INET, SOCK_STREAM, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<uint16_t>(port));
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  ASSERT_EQ(::connect(client, reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
  poll();
  ASSERT_EQ(errors, std::vector<int>{TCP_SUCCESS});

  errors.clear();
  byte bytes[4] = {};
  TCPEndpointReceiveMsg receive(endpoint, bytes, 2, 4);
  receive.Send(kStack, object, kAnswer, sizeof receive);
  ASSERT_EQ(::send(client, "hi", 2, 0), 2);
  poll();
  EXPECT_EQ(errors, std::vector<int>{TCP_SUCCESS});
  EXPECT_EQ(bytes[1], 'i');
  ::close(client);
}

// An end point for datagrams, and a client that sends to it from outside.
class Datagrams : public Network {
 protected:
  void SetUp() override {
    antEnvCreateEndpointMsg create(EndpointType_UDP);
    owner = system.begin_object("Radio");
    create.Call(kStack, sizeof create);
    ASSERT_EQ(create.error, ANT_SUCCESS);
    radio = create.moduleRef;
    system.end_object(owner, [this](Selector, void* message) {
      errors.push_back(static_cast<UDPEndpointBaseMsg*>(antEnvMsg::Receive(message))->error);
    });
    UDPEndpointBindMsg bind(radio, IP_ADDR_ANY, 10030);
    testing::internal::CaptureStdout();
    bind.Call(kStack, sizeof bind);
    const std::string said = testing::internal::GetCapturedStdout();
    ASSERT_EQ(bind.error, UDP_SUCCESS);
    int port = 0;
    ASSERT_EQ(std::sscanf(said.c_str(), "Radio takes datagrams on 127.0.0.1:%d", &port), 1) << said;
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(static_cast<uint16_t>(port));
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    ASSERT_EQ(::connect(client, reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
  }
  ~Datagrams() override { ::close(client); }

  void receive(byte* bytes, int size) {
    errors.clear();
    UDPEndpointReceiveMsg message(radio, bytes, size);
    message.Send(kStack, owner, kAnswer, sizeof message);
    stack.poll();
    system.deliver();
  }

  OID owner;
  antModuleRef radio;
  const int client = ::socket(AF_INET, SOCK_DGRAM, 0);
};

TEST_F(Datagrams, AreTakenOneByOne) {
  byte bytes[8] = {}, more[8] = {};
  receive(bytes, sizeof bytes);
  EXPECT_TRUE(errors.empty());  // Nothing is there yet: it waits.
  ASSERT_EQ(::send(client, "hi", 2, 0), 2);
  poll();
  ASSERT_EQ(errors, std::vector<int>{UDP_SUCCESS});
  EXPECT_EQ(bytes[1], 'i');
  // What does not fit is lost, and the next one is the next one.
  ASSERT_EQ(::send(client, "0123456789", 10, 0), 10);
  ASSERT_EQ(::send(client, "next", 4, 0), 4);
  receive(bytes, sizeof bytes);
  poll();
  receive(more, sizeof more);
  poll();
  EXPECT_EQ(errors, std::vector<int>{UDP_SUCCESS});
  EXPECT_EQ(std::string(bytes, bytes + 8), "01234567");
  EXPECT_EQ(std::string(more, more + 4), "next");
}

TEST_F(Datagrams, AreSentWithinThisMachine) {
  sockaddr_in own{};
  socklen_t size = sizeof own;
  ASSERT_EQ(::getsockname(client, reinterpret_cast<sockaddr*>(&own), &size), 0);
  byte answer[] = {'y', 'e', 's'};
  UDPEndpointSendMsg send(radio, IPAddress("127.0.0.1"), ntohs(own.sin_port), answer, 3);
  send.Call(kStack, sizeof send);
  EXPECT_EQ(send.error, UDP_SUCCESS);
  char got[8] = {};
  EXPECT_EQ(::recv(client, got, sizeof got, 0), 3);
  EXPECT_STREQ(got, "yes");
  UDPEndpointSendMsg away(radio, IPAddress("192.0.2.1"), 9, answer, 3);
  away.Call(kStack, sizeof away);
  EXPECT_EQ(away.error, UDP_HOST_UNREACHABLE);
}

TEST_F(Datagrams, WhatWaitsIsAnsweredWhenTheEndPointIsClosed) {
  byte bytes[8] = {};
  receive(bytes, sizeof bytes);
  EXPECT_TRUE(errors.empty());
  UDPEndpointCloseMsg close(radio);
  close.Call(kStack, sizeof close);
  system.deliver();
  EXPECT_EQ(errors, std::vector<int>{UDP_CONNECTION_CLOSED});
}

TEST_F(Network, OtherKindsAndOtherMachinesAreRefused) {
  antEnvCreateEndpointMsg create(EndpointType_DNS);
  create.Call(kStack, sizeof create);
  EXPECT_EQ(create.error, ANT_ENDPOINT_NOFACTORY);
  TCPEndpointConnectMsg connect(endpoint, IP_ADDR_ANY, 0, IPAddress("192.0.2.1"), 80);
  connect.Send(kStack, object, kAnswer, sizeof connect);
  poll();
  EXPECT_EQ(errors, std::vector<int>{TCP_HOST_UNREACHABLE});
}

}  // namespace
}  // namespace seam::open_r
