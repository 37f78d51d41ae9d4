// A client's bidirectional stream as gRPC's callbacks drive it: one read and one write at a time,
// messages that wait to be written, and the end, which comes after the last of them. What the
// messages mean is the derived session's business. Services' own files alone include this.
#pragma once

#include <fmt/format.h>
#include <grpcpp/alarm.h>
#include <grpcpp/grpcpp.h>

#include <chrono>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <utility>

namespace seam::scheduler {

template <class In, class Out>
class Stream : public grpc::ServerBidiReactor<In, Out>,
               public std::enable_shared_from_this<Stream<In, Out>> {
 public:
  // The stream keeps itself alive until gRPC is done with it.
  void start() {
    self_ = this->shared_from_this();
    hello_alarm_.Set(std::chrono::system_clock::now() + std::chrono::seconds(kHelloSeconds),
                     [weak = this->weak_from_this()](bool expired) {
                       const auto stream = weak.lock();
                       if (expired && stream && !stream->greeted())
                         stream->end({grpc::StatusCode::DEADLINE_EXCEEDED,
                                      fmt::format("no hello within {} s", kHelloSeconds)});
                     });
    this->StartRead(&incoming_);
  }

 protected:
  // A message has come.
  virtual void take(const In& message) = 0;
  // The client is gone; may be called more than once.
  virtual void leave() = 0;
  virtual bool greeted() = 0;

  void write(Out message) {
    const std::lock_guard lock(stream_mutex_);
    if (status_) return;
    unwritten_.push_back(std::move(message));
    if (unwritten_.size() == 1) this->StartWrite(&unwritten_.front());
  }
  void end(const grpc::Status& status) {
    const std::lock_guard lock(stream_mutex_);
    if (status_) return;
    status_ = status;
    if (unwritten_.empty() && !std::exchange(finished_, true)) this->Finish(*status_);
  }

 private:
  static constexpr int kHelloSeconds = 10;
  // Messages that wait to be written; a client that sends but never reads is not read from further.
  static constexpr size_t kMaxUnwritten = 16;

  void OnReadDone(bool ok) override {
    if (!ok) {
      leave();
      end(grpc::Status::OK);
      return;
    }
    take(incoming_);
    {
      const std::lock_guard lock(stream_mutex_);
      if (unwritten_.size() >= kMaxUnwritten) {
        reading_held_ = true;
        return;
      }
    }
    this->StartRead(&incoming_);
  }
  void OnWriteDone(bool ok) override {
    bool resume_reading = false;
    {
      const std::lock_guard lock(stream_mutex_);
      unwritten_.pop_front();
      if (!ok) unwritten_.clear();
      if (!unwritten_.empty()) {
        this->StartWrite(&unwritten_.front());
      } else if (status_) {
        if (!std::exchange(finished_, true)) this->Finish(*status_);
      }
      if (unwritten_.size() < kMaxUnwritten) resume_reading = std::exchange(reading_held_, false);
    }
    if (resume_reading) this->StartRead(&incoming_);
  }
  void OnCancel() override { leave(); }
  void OnDone() override {
    leave();
    hello_alarm_.Cancel();
    self_.reset();
  }

  std::shared_ptr<Stream> self_;
  grpc::Alarm hello_alarm_;
  In incoming_;  // Of the one read under way.

  std::mutex stream_mutex_;
  std::deque<Out> unwritten_;  // The first is being written.
  bool reading_held_ = false;
  std::optional<grpc::Status> status_;  // Given to Finish when all is written.
  bool finished_ = false;
};

}  // namespace seam::scheduler
