// The renderers' streams: a session turns wire messages into calls of the RemoteRenderer.
#include <fmt/format.h>
#include <grpcpp/grpcpp.h>

#include <mutex>

#include "proto/client_channel.h"
#include "scheduler/server/services.h"
#include "scheduler/server/stream.h"
#include "scheduler/wire/wire.h"
#include "seam/v1/render.grpc.pb.h"
#include "sim_core/base/error.h"

namespace seam::scheduler {

namespace {

grpc::StatusCode code_of(RemoteRenderer::Refused why) {
  switch (why) {
    case RemoteRenderer::Refused::wrong_token:
      return grpc::StatusCode::UNAUTHENTICATED;
    case RemoteRenderer::Refused::bad_field:
      return grpc::StatusCode::INVALID_ARGUMENT;
    default:
      return grpc::StatusCode::FAILED_PRECONDITION;
  }
}

class RenderSession final : public Stream<v1::RendererMessage, v1::RenderOrder>,
                            public RendererConnection {
 public:
  RenderSession(RemoteRenderer* renderer, TokenTries& tries, std::string peer)
      : renderer_(renderer), tries_(tries), peer_(std::move(peer)) {}

  // ---- RendererConnection ----
  bool send(uint64_t number, int robot, const FrameJob& job) override {
    v1::RenderOrder order;
    job_to_wire(renderer_->setup(), number, robot, job, *order.mutable_job());
    if (order.ByteSizeLong() > kMaxServerMessageBytes) return false;
    write(std::move(order));
    return true;
  }
  void say_goodbye(const std::string& reason) override {
    v1::RenderOrder order;
    order.mutable_goodbye()->set_reason(reason);
    write(std::move(order));
    end(grpc::Status::OK);
  }
  void drop(const std::string& reason) override { end({grpc::StatusCode::ABORTED, reason}); }

 private:
  // ---- Stream ----
  void take(const v1::RendererMessage& message) override;
  void leave() override { lose("the connection ended"); }
  bool greeted() override {
    const std::lock_guard lock(mutex_);
    return connection_ != 0;
  }

  void take_hello(const v1::RendererMessage& message);
  void lose(const std::string& reason);

  RemoteRenderer* renderer_;  // None: the server renders.
  TokenTries& tries_;
  std::string peer_;
  std::mutex mutex_;
  uint64_t connection_ = 0;  // Once the hello was accepted.
  bool left_ = false;
};

void RenderSession::lose(const std::string& reason) {
  uint64_t connection;
  {
    const std::lock_guard lock(mutex_);
    connection = std::exchange(left_, true) ? 0 : connection_;
  }
  if (connection != 0) renderer_->detach(connection, reason);
}

void RenderSession::take_hello(const v1::RendererMessage& message) {
  if (!message.has_hello())
    return end(
        {grpc::StatusCode::FAILED_PRECONDITION, "the first message must be a RendererHello"});
  if (renderer_ == nullptr)
    return end({grpc::StatusCode::FAILED_PRECONDITION,
                "this run renders in the server: start it with --renderers N"});
  if (const double wait_s = tries_.wait_s(peer_, "renderer"); wait_s > 0)
    return end({grpc::StatusCode::UNAVAILABLE, wait_text(wait_s)});
  const v1::RendererHello& hello = message.hello();
  const auto attached =
      renderer_->attach({.token = hello.token(),
                         .version = hello.version(),
                         .name = hello.name(),
                         .robots = {hello.robots().begin(), hello.robots().end()},
                         .frames_at_once = hello.frames_at_once()},
                        std::static_pointer_cast<RenderSession>(shared_from_this()));
  if (const auto* refusal = std::get_if<RemoteRenderer::Refusal>(&attached)) {
    if (refusal->why == RemoteRenderer::Refused::wrong_token) tries_.note_wrong(peer_, "renderer");
    return end({code_of(refusal->why), refusal->message});
  }
  const uint64_t connection = std::get<uint64_t>(attached);
  bool left;
  {
    const std::lock_guard lock(mutex_);
    connection_ = connection;
    left = left_;
  }
  if (left)
    return renderer_->detach(connection, "the connection ended");  // It broke off meanwhile.
  v1::RenderOrder reply;
  setup_to_wire(renderer_->setup(), *reply.mutable_setup());
  write(std::move(reply));
  renderer_->activate(connection);
}

void RenderSession::take(const v1::RendererMessage& message) {
  if (!greeted()) return take_hello(message);
  std::optional<std::string> error;
  if (message.has_rows()) {
    const v1::RenderedRows& rows = message.rows();
    error = renderer_->take_rows(connection_, rows.number(), rows.first_row(), rows.rgb(),
                                 rows.fingerprint());
  } else if (message.has_failure()) {
    error = "it failed: " + message.failure().message().substr(0, 500);
  } else {
    error = "kind: found no rows and no failure";
  }
  if (!error) return;
  lose(*error);
  end({grpc::StatusCode::INVALID_ARGUMENT, *error});
}

class RenderService final : public v1::Rendering::CallbackService {
 public:
  RenderService(RemoteRenderer* renderer, TokenTries& tries) : renderer_(renderer), tries_(tries) {}

  grpc::ServerBidiReactor<v1::RendererMessage, v1::RenderOrder>* Render(
      grpc::CallbackServerContext* context) override {
    const auto session =
        std::make_shared<RenderSession>(renderer_, tries_, peer_of(context->peer()));
    session->start();
    return session.get();
  }

 private:
  RemoteRenderer* renderer_;
  TokenTries& tries_;
};

}  // namespace

std::unique_ptr<grpc::Service> make_render_service(RemoteRenderer* renderer, TokenTries& tries) {
  return std::make_unique<RenderService>(renderer, tries);
}

}  // namespace seam::scheduler
