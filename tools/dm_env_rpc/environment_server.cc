#include "tools/dm_env_rpc/environment_server.h"

#include <fmt/format.h>
#include <grpcpp/grpcpp.h>
#include <grpcpp/impl/codegen/proto_utils.h>
#include <grpcpp/support/method_handler.h>
#include <grpcpp/support/sync_stream.h>

#include <atomic>
#include <condition_variable>
#include <cstdio>
#include <mutex>

#include "app/session/behaviours.h"
#include "scheduler/server/grpc_listener.h"
#include "sim_core/system/resources.h"
#include "tools/dm_env_rpc/agent.h"

namespace seam::tools::dm {

namespace {

// Fewer than HTTP/2 takes on one connection, beyond which a client would wait without a word.
constexpr int kMostStreams = 48;
constexpr int kMostThreads = kMostStreams + 16;
constexpr int kMostReceivedBytes = 1 << 20;  // A step of all actions takes some kilobytes.

// By bytes: what is no message is answered by an error, as any other bad request.
class EnvironmentService final : public grpc::Service {
 public:
  explicit EnvironmentService(Worlds& worlds) : worlds_(worlds) {
    using Handler = grpc::internal::BidiStreamingHandler<EnvironmentService, grpc::ByteBuffer,
                                                         grpc::ByteBuffer>;
    AddMethod(new grpc::internal::RpcServiceMethod(
        "/dm_env_rpc.v1.Environment/Process", grpc::internal::RpcMethod::BIDI_STREAMING,
        new Handler([](EnvironmentService* service, grpc::ServerContext* context,
                       Stream* stream) { return service->process(*context, *stream); },
                    this)));
  }

 private:
  using Stream = grpc::ServerReaderWriter<grpc::ByteBuffer, grpc::ByteBuffer>;

  grpc::Status process(grpc::ServerContext& context, Stream& stream) {
    const Counted counted(streams_);
    if (streams_ > kMostStreams)
      return {grpc::StatusCode::RESOURCE_EXHAUSTED,
              fmt::format("{} streams are open, as many as there may be", kMostStreams)};
    Agent agent(worlds_, tries_, scheduler::peer_of(context.peer()),
                [&context] { return context.IsCancelled(); });
    grpc::ByteBuffer received;
    while (stream.Read(&received)) {
      rpc::EnvironmentRequest request;
      rpc::EnvironmentResponse response;
      if (grpc::SerializationTraits<rpc::EnvironmentRequest>::Deserialize(&received, &request)
              .ok()) {
        response = agent.answer(request);
      } else {
        response.mutable_error()->set_code(grpc::StatusCode::INVALID_ARGUMENT);
        response.mutable_error()->set_message("found bytes that are no EnvironmentRequest");
      }
      grpc::ByteBuffer sent;
      bool own_buffer = false;
      const grpc::Status written = grpc::SerializationTraits<rpc::EnvironmentResponse>::Serialize(
          response, &sent, &own_buffer);
      if (!written.ok()) return written;
      if (!stream.Write(sent)) break;
    }
    return grpc::Status::OK;
  }

  struct Counted {
    explicit Counted(std::atomic<int>& number) : counter(number) { ++counter; }
    ~Counted() { --counter; }
    std::atomic<int>& counter;
  };

  Worlds& worlds_;
  scheduler::TokenTries tries_;
  std::atomic<int> streams_ = 0;
};

}  // namespace

void serve_environment(WorldKind kind, const ServeOptions& options) {
  require_resources(kMostThreads, 4 * kMostStreams);
  const app::BlockedSignals blocked;
  Worlds worlds(std::move(kind));
  EnvironmentService service(worlds);
  std::mutex mutex;
  std::condition_variable changed;
  bool stopped = false;
  const auto stop = [&] {
    const std::lock_guard lock(mutex);
    stopped = true;
    changed.notify_all();
  };
  {
    scheduler::GrpcListener listener(
        {.addresses = options.addresses,
         .tls = options.tls,
         .most_received_bytes = kMostReceivedBytes,
         .most_threads = kMostThreads},
        {&service}, [](const std::string& what) { std::fprintf(stderr, "%s\n", what.c_str()); });
    for (const std::string& address : listener.addresses())
      std::printf("listening on %s\n", address.c_str());
    std::fflush(stdout);
    const app::SignalWatch signals(stop, [&] {
      if (options.until_eof && app::input_has_ended()) stop();
    });
    std::unique_lock lock(mutex);
    changed.wait(lock, [&] { return stopped; });
    lock.unlock();
    worlds.close();
  }
}

}  // namespace seam::tools::dm
