// Who comes without a certificate of the run's own authority does not reach any service, whatever
// tokens it knows. The certificates are those that `seam certs` makes.
#include <grpcpp/grpcpp.h>
#include <gtest/gtest.h>
#include <stdlib.h>

#include <filesystem>

#include "scheduler/clients/client_hub.h"
#include "scheduler/server/server.h"
#include "scheduler/server/silent_connections.h"
#include "seam/v1/simulation.grpc.pb.h"
#include "sim_core/base/files.h"
#include "sim_core/world/world.h"
#include "tools/command.h"

namespace seam::tools {
namespace {

namespace fs = std::filesystem;

class Tls : public ::testing::Test {
 protected:
  scheduler::testing::UsualDescriptorLimit limit_;
  Tls() {
    std::string pattern = (fs::temp_directory_path() / "seam-tls-XXXXXX").string();
    EXPECT_NE(mkdtemp(pattern.data()), nullptr);
    folder_ = pattern;
    for (const char* name : {"ours", "theirs"}) make_certificates(folder_ / name);
    server_.emplace(scheduler::ServerOptions{{"127.0.0.1:0"}, server_texts("ours"), "boss"},
                    scenario_, world_, hub_, control_);
  }
  ~Tls() override {
    control_.close();
    server_.reset();
    fs::remove_all(folder_);
  }

  static void make_certificates(const fs::path& folder) {
    app::parse_and_run("", "seam", "", {"certs", folder.string()},
                       [](app::Command app) { add_certs(app); });
  }
  scheduler::TlsTexts server_texts(const std::string& set) const {
    return {read_file(folder_ / set / "ca.pem"), read_file(folder_ / set / "server.pem"),
            read_file(folder_ / set / "server.key")};
  }
  std::shared_ptr<grpc::ChannelCredentials> credentials(const std::string& authority,
                                                        const std::string& key,
                                                        const std::string& certificate) const {
    const auto text = [&](const std::string& name) {
      return name.empty() ? std::string() : read_file(folder_ / name);
    };
    return grpc::SslCredentials({text(authority), text(key), text(certificate)});
  }
  // The supervisor's question with the right token, and a robot's hello with its.
  grpc::StatusCode ask(const std::shared_ptr<grpc::ChannelCredentials>& credentials) const {
    const auto channel = grpc::CreateChannel(server_->addresses()[0], credentials);
    grpc::ClientContext context;
    context.set_deadline(std::chrono::system_clock::now() + std::chrono::seconds(10));
    v1::SupervisorRequest request;
    request.set_token("wrong");
    v1::Status reply;
    return v1::Supervisor::NewStub(channel)->GetStatus(&context, request, &reply).error_code();
  }
  grpc::StatusCode drive(const std::shared_ptr<grpc::ChannelCredentials>& credentials) const {
    const auto channel = grpc::CreateChannel(server_->addresses()[0], credentials);
    grpc::ClientContext context;
    context.set_deadline(std::chrono::system_clock::now() + std::chrono::seconds(10));
    const auto stub = v1::Simulation::NewStub(channel);
    const auto stream = stub->Drive(&context);
    v1::ClientMessage hello;
    hello.mutable_hello()->set_robot("red1");
    hello.mutable_hello()->set_token("secret");
    stream->Write(hello);
    v1::ServerMessage message;
    if (stream->Read(&message)) {
      context.TryCancel();
      stream->Finish();
      return grpc::StatusCode::OK;
    }
    return stream->Finish().error_code();
  }

  fs::path folder_;
  Scenario scenario_ = Scenario::from_file(SEAM_SOURCE_DIR "/scenarios/head_swing.yaml");
  World world_{scenario_};
  scheduler::RunControl control_;
  scheduler::ClientHub hub_{{{"red1", "secret"}}, control_};
  std::optional<scheduler::Server> server_;
};

// More than the descriptors that a program usually has: the server still listens, and hangs up.
TEST_F(Tls, SilentConnectionsDoNotEndTheListener) {
  if (!limit_.can_be_raised_to(4096)) GTEST_SKIP() << "the system allows no more descriptors";
  const scheduler::testing::SilentConnections silent(server_->addresses()[0], 1100);
  ASSERT_EQ(silent.count(), 1100u);
  EXPECT_EQ(ask(credentials("ours/ca.pem", "ours/client.key", "ours/client.pem")),
            grpc::StatusCode::UNAUTHENTICATED);
  EXPECT_TRUE(silent.hung_up_within(20));
}

TEST_F(Tls, OnlyClientsWithACertificateOfTheSameAuthorityReachTheServices) {
  const auto good = credentials("ours/ca.pem", "ours/client.key", "ours/client.pem");
  EXPECT_EQ(ask(good), grpc::StatusCode::UNAUTHENTICATED);  // It is heard: the token is wrong.
  EXPECT_EQ(drive(good), grpc::StatusCode::OK);
  const std::pair<const char*, std::shared_ptr<grpc::ChannelCredentials>> bad[] = {
      {"without TLS", grpc::InsecureChannelCredentials()},
      {"without a certificate", credentials("ours/ca.pem", "", "")},
      {"with another authority's certificate",
       credentials("ours/ca.pem", "theirs/client.key", "theirs/client.pem")},
      {"trusting another authority",
       credentials("theirs/ca.pem", "ours/client.key", "ours/client.pem")},
  };
  for (const auto& [how, who] : bad) {
    EXPECT_EQ(ask(who), grpc::StatusCode::UNAVAILABLE) << how;
    EXPECT_EQ(drive(who), grpc::StatusCode::UNAVAILABLE) << how;
  }
}

}  // namespace
}  // namespace seam::tools
