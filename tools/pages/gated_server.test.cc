#include "tools/pages/gated_server.h"

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <unistd.h>

namespace seam::tools {
namespace {

class GatedServerOnAPort : public testing::Test {
 protected:
  GatedServerOnAPort() {
    server_.Get("/who", [](const httplib::Request&, httplib::Response& response) {
      response.set_content(std::string(300'000, 'x') + "end", "text/plain");
    });
    port_ = server_.bind_to_any_port("127.0.0.1");
    server_.lengthen_queue();
    thread_ = std::jthread([this] { server_.listen_after_bind(); });
    while (!server_.is_running()) usleep(1000);
  }
  ~GatedServerOnAPort() override {
    server_.stop();
    for (const int socket : sockets_) close(socket);
  }
  int connect_with(const std::string& bytes) {
    const int socket = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(static_cast<uint16_t>(port_));
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    EXPECT_EQ(connect(socket, reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
    EXPECT_EQ(send(socket, bytes.data(), bytes.size(), MSG_NOSIGNAL),
              static_cast<ssize_t>(bytes.size()));
    sockets_.push_back(socket);
    return socket;
  }
  static std::string answer_at(int socket) {
    const timeval limit{3, 0};
    setsockopt(socket, SOL_SOCKET, SO_RCVTIMEO, &limit, sizeof limit);
    std::string all;
    char bytes[4096];
    for (ssize_t size = 0; (size = recv(socket, bytes, sizeof bytes, 0)) > 0;)
      all.append(bytes, static_cast<size_t>(size));
    return all;
  }

  GatedServer server_;
  int port_ = 0;
  std::vector<int> sockets_;
  std::jthread thread_;
};

TEST_F(GatedServerOnAPort, AnswersWhileManyHalfRequestsWait) {
  for (int i = 0; i < 400; ++i) connect_with("GET / HTTP/1.1\r\nX: ");
  for (int i = 0; i < 3; ++i) {
    const std::string answer = answer_at(connect_with("GET /who HTTP/1.1\r\nHost: x\r\n\r\n"));
    EXPECT_TRUE(answer.starts_with("HTTP/1.1 200")) << answer.substr(0, 100);
    EXPECT_TRUE(answer.ends_with("end"));
  }
}

TEST_F(GatedServerOnAPort, TakesARequestInPiecesAndNoBodies) {
  const int slow = connect_with("GET /who HT");
  usleep(50'000);
  EXPECT_EQ(send(slow, "TP/1.1\r\n\r\n", 10, 0), 10);
  EXPECT_TRUE(answer_at(slow).ends_with("end"));
  // A body that is announced and does not come is not waited for.
  const std::string posted =
      answer_at(connect_with("POST /who HTTP/1.1\r\nContent-Length: 1000\r\n\r\n"));
  EXPECT_FALSE(posted.starts_with("HTTP/1.1 200")) << posted.substr(0, 100);
  EXPECT_EQ(answer_at(connect_with("GET /" + std::string(20'000, 'a'))), "");
}

}  // namespace
}  // namespace seam::tools
