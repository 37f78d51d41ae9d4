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
