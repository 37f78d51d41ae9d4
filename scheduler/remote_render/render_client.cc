#include "scheduler/remote_render/render_client.h"

#include <grpcpp/grpcpp.h>

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <deque>
#include <mutex>
#include <optional>
#include <thread>

#include "proto/client_channel.h"
#include "scheduler/wire/wire.h"
#include "seam/v1/render.grpc.pb.h"
#include "sim_core/base/error.h"
#include "sim_core/system/thread.h"

namespace seam::scheduler {

namespace {

using ClientStream = grpc::ClientReaderWriter<v1::RendererMessage, v1::RenderOrder>;

// The threads that render the jobs of one stream; ends with it, dropping what has not begun.
class Workers {
 public:
  Workers(const RenderSetup& setup, FrameRenderer& renderer, ClientStream& stream)
      : setup_(setup), renderer_(renderer), stream_(stream) {
    try {
      for (int worker = 0; worker < renderer.workers(); ++worker)
        threads_.push_back(start_thread([this, worker] { work(worker); }));
    } catch (const InputError&) {
      end();
      throw;
    }
  }
  ~Workers() { end(); }
  void take(v1::RenderJob job) {
    {
      const std::lock_guard lock(mutex_);
      jobs_.push_back(std::move(job));
    }
    changed_.notify_one();
  }

 private:
  void work(int worker) {
    while (true) {
      std::unique_lock lock(mutex_);
      changed_.wait(lock, [&] { return ending_ || !jobs_.empty(); });
      if (ending_) return;
      const v1::RenderJob wire = std::move(jobs_.front());
      jobs_.pop_front();
      lock.unlock();
      try {
        const FrameJob job = job_from_wire(setup_, wire);
        send(wire.number(), renderer_.render(static_cast<int>(wire.robot()), job, worker));
      } catch (const std::exception& error) {
        v1::RendererMessage message;
        message.mutable_failure()->set_number(wire.number());
        message.mutable_failure()->set_message(error.what());
        const std::lock_guard writing(write_mutex_);
        stream_.Write(message);
      }
    }
  }

  void send(uint64_t number, const Frame& frame) {
    const size_t row_bytes = static_cast<size_t>(3) * frame.width_px;
    const size_t rows_at_once = std::max<size_t>(1, WireLimits::kMaxRowsBytes / row_bytes);
    const auto height = static_cast<size_t>(frame.height_px);
    for (size_t row = 0; row < height; row += rows_at_once) {
      const size_t rows = std::min(rows_at_once, height - row);
      v1::RendererMessage message;
      v1::RenderedRows& out = *message.mutable_rows();
      out.set_number(number);
      out.set_first_row(static_cast<uint32_t>(row));
      out.set_rgb(frame.rgb.data() + row * row_bytes, rows * row_bytes);
      if (row + rows == height) out.set_fingerprint(frame.fingerprint);
      const std::lock_guard writing(write_mutex_);
      if (!stream_.Write(message)) return;  // The reading thread learns why.
    }
  }

  void end() {
    {
      const std::lock_guard lock(mutex_);
      ending_ = true;
    }
    changed_.notify_all();
    threads_.clear();  // Joins them.
  }

  const RenderSetup& setup_;
  FrameRenderer& renderer_;
  ClientStream& stream_;
  std::mutex mutex_;
  std::mutex write_mutex_;
  std::condition_variable changed_;
  std::deque<v1::RenderJob> jobs_;
  bool ending_ = false;
  std::vector<std::jthread> threads_;
};

class Client {
 public:
  Client(const RenderClientOptions& options, const MakeRenderer& make)
      : options_(options),
        make_(make),
        stub_(v1::Rendering::NewStub(open_channel(options.address, options.certificates))) {}

  std::string run() {
    auto last_connected = std::chrono::steady_clock::now();
    while (true) {
      welcomed_ = false;
      const grpc::Status status = serve();
      if (goodbye_) return *goodbye_;
      const auto now = std::chrono::steady_clock::now();
      if (welcomed_) last_connected = now;
      const std::chrono::duration<double> without = now - last_connected;
      if (!passes(status.error_code()) || without.count() > options_.give_up_s)
        throw InputError(fmt::format("{}: {}", options_.address, status.error_message()));
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
    }
  }

 private:
  grpc::Status serve() {
    grpc::ClientContext context;
    const auto stream = stub_->Render(&context);
    v1::RendererMessage first;
    v1::RendererHello& hello = *first.mutable_hello();
    hello.set_token(options_.token);
    hello.set_version(options_.version);
    hello.set_name(options_.name);
    for (const std::string& robot : options_.robots) hello.add_robots(robot);
    hello.set_frames_at_once(static_cast<uint32_t>(2 * options_.threads));  // One waits for each.
    v1::RenderOrder order;
    if (!stream->Write(first) || !stream->Read(&order) || !order.has_setup())
      return stream->Finish();
    welcomed_ = true;
    const RenderSetup setup = setup_from_wire(order.setup());
    std::unique_ptr<FrameRenderer> renderer;
    try {
      renderer = make_(setup);
    } catch (const std::exception& error) {
      v1::RendererMessage message;
      message.mutable_failure()->set_message(error.what());
      stream->WriteLast(message, {});
      stream->Finish();
      throw;
    }
    {
      Workers workers(setup, *renderer, *stream);
      while (!goodbye_ && stream->Read(&order)) {
        if (order.has_job()) workers.take(std::move(*order.mutable_job()));
        if (order.has_goodbye()) goodbye_ = order.goodbye().reason();
      }
    }
    if (goodbye_) stream->WritesDone();
    return stream->Finish();
  }

  const RenderClientOptions& options_;
  const MakeRenderer& make_;
  std::unique_ptr<v1::Rendering::Stub> stub_;
  bool welcomed_ = false;
  std::optional<std::string> goodbye_;
};

}  // namespace

std::string render_for_server(const RenderClientOptions& options, const MakeRenderer& make) {
  return Client(options, make).run();
}

}  // namespace seam::scheduler
