// Frames rendered by other processes, as the loop's FrameRenderer: hands jobs to connected
// renderers and takes their pixels. Free of gRPC; a connection is known by interface.
//
// A job is all that a frame depends on, so which renderer makes it, and whether the server makes it
// itself because a renderer failed, changes no bit. What a renderer gives is checked: its size, its
// fingerprint, and for one frame in `check_every` each pixel against the server's own.
#pragma once

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "scheduler/loop/frame_renderer.h"
#include "scheduler/wire/render_wire.h"

namespace seam::scheduler {

// What happens to a frame that no renderer can make.
enum class RendererPolicy : uint8_t {
  fallback,  // The server makes it: slower, the same bits.
  abort,     // The run ends with an error.
};

struct RemoteRendererOptions {
  std::string token;          // The operator's render token.
  double limit_s = 10;        // Wall time for one frame; a slower renderer is dropped.
  int outstanding = 16;       // Frames given out at once, over all renderers.
  uint64_t check_every = 50;  // Of each connection: its frames 0, N, 2N, ... are compared.
  RendererPolicy policy = RendererPolicy::fallback;
};

// One renderer's stream. Called from any thread and never while a lock is held; must not block.
class RendererConnection {
 public:
  virtual ~RendererConnection() = default;
  // False where the job cannot travel (its message would be too long).
  virtual bool send(uint64_t number, int robot, const FrameJob& job) = 0;
  virtual void say_goodbye(const std::string& reason) = 0;
  virtual void drop(const std::string& reason) = 0;
};

struct RendererGreeting {
  std::string token;
  std::string version;
  std::string name;
  std::vector<std::string> robots;  // Empty: all.
  uint32_t frames_at_once = 1;
};

class RemoteRenderer final : public FrameRenderer {
 public:
  // Puts into a frame what follows from its size, rows and rgb: fingerprint, YCrCb, colours.
  using Develop = std::function<void(int robot, Frame& frame)>;
  // Reports a renderer that was lost or frames that the server makes itself; from any thread.
  using TellFault = std::function<void(int robot, const std::string& what)>;

  RemoteRenderer(FrameRenderer& local, RenderSetup setup, RemoteRendererOptions options,
                 Develop develop, TellFault tell_fault);

  // ---- FrameRenderer ----

  int workers() const override { return std::max(local_.workers(), options_.outstanding); }
  RowSchedule schedule(int robot, uint64_t frame_index, SimTime stamp) override {
    return local_.schedule(robot, frame_index, stamp);
  }
  Pose mount(int robot) const override { return local_.mount(robot); }
  // Throws InputError when a renderer gave other pixels than the server, and by policy `abort`.
  Frame render(int robot, const FrameJob& job, int worker) override;

  // ---- From connections ----

  enum class Refused : uint8_t { wrong_token, other_version, bad_field, ended };
  struct Refusal {
    Refused why;
    std::string message;
  };
  // The number of the connection, by which it is known from then on. Nothing is sent to it before
  // `activate`.
  std::variant<uint64_t, Refusal> attach(const RendererGreeting& greeting,
                                         std::shared_ptr<RendererConnection> connection);
  void activate(uint64_t connection);
  // What a job's owner has sent; the text of an error ends the stream (and the renderer is lost).
  std::optional<std::string> take_rows(uint64_t connection, uint64_t number, uint32_t first_row,
                                       std::string_view rgb, uint64_t fingerprint);
  // The stream ended or its renderer cannot go on: others make its frames.
  void detach(uint64_t connection, const std::string& reason);

  // ---- For the run ----

  const RenderSetup& setup() const { return setup_; }
  // Waits until so many renderers are here; false after the limit or when `give_up` says so.
  bool wait_for(size_t renderers, double limit_s, const std::function<bool()>& give_up) const;
  size_t renderers() const;
  // Of the frames so far: made by renderers.
  uint64_t rendered_remotely() const;
  // The run is over: says goodbye; frames still asked for are not made (InputError).
  void finish(const std::string& reason);

 private:
  struct Connected {
    std::shared_ptr<RendererConnection> connection;
    std::string name;
    std::vector<bool> serves;  // For each robot.
    bool active = false;
    size_t capacity = 1;
    size_t in_flight = 0;
    uint64_t frames = 0;
  };
  enum class State : uint8_t { waiting, done, lost };
  struct Ticket {
    uint64_t connection = 0;
    int robot = 0;
    const FrameJob* job = nullptr;
    State state = State::waiting;
    std::vector<uint8_t> rgb;
    uint64_t fingerprint = 0;  // As the renderer says.
  };
  using Lock = std::unique_lock<std::mutex>;

  std::optional<uint64_t> choose(int robot) const;
  bool served(int robot) const;
  std::optional<Frame> try_once(uint64_t connection, int robot, const FrameJob& job, Lock& lock);
  bool wait_for_rows(Ticket& ticket, const std::string& name, Lock& lock);
  Frame render_here(int robot, const FrameJob& job, Lock& lock);
  void compare(const Frame& given, int robot, const FrameJob& job, const std::string& name,
               Lock& lock);
  std::shared_ptr<RendererConnection> remove(uint64_t connection, const std::string& reason);
  size_t frame_bytes(int robot) const;

  FrameRenderer& local_;
  RenderSetup setup_;
  RemoteRendererOptions options_;
  Develop develop_;
  TellFault tell_fault_;

  mutable std::mutex mutex_;
  mutable std::condition_variable changed_;
  std::map<uint64_t, Connected> connected_;
  std::map<uint64_t, Ticket*> tickets_;  // By job number; each lives in its `try_once`.
  std::vector<int> idle_local_workers_;
  std::vector<std::string> last_reason_;  // For each robot: why its last renderer was lost.
  std::vector<bool> falling_back_;
  uint64_t next_connection_ = 1;
  uint64_t next_number_ = 1;
  uint64_t rendered_remotely_ = 0;
  bool ended_ = false;
};

}  // namespace seam::scheduler
