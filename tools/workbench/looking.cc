#include "tools/workbench/looking.h"

#include "sim_core/base/error.h"
#include "sim_core/system/thread.h"
#include "tools/pages/refusal.h"

namespace seam::tools {
namespace {

// Of a command's lines those that are events.
Child::Line events_to(std::function<void(const nlohmann::json&)> said) {
  return [said = std::move(said)](std::string_view line) {
    const auto event = nlohmann::json::parse(line, nullptr, /*allow_exceptions=*/false);
    if (event.is_object()) said(event);
  };
}

}  // namespace

Looking::Looking(Said said, Ended ended) : said_(std::move(said)), ended_(std::move(ended)) {
  thread_ = start_thread([this] { work(); });
}

Looking::~Looking() {
  {
    const std::lock_guard lock(mutex_);
    ending_ = true;
  }
  child_.stop();
  changed_.notify_all();
}

void Looking::want(LookJob job) {
  {
    const std::lock_guard lock(mutex_);
    const auto same = [&](const std::optional<LookJob>& other) {
      return other && other->opened == job.opened && other->version == job.version;
    };
    if (same(running_) || same(wanted_)) return;
    wanted_ = std::move(job);
    if (running_) child_.stop();
  }
  changed_.notify_all();
}

void Looking::cancel() {
  const std::lock_guard lock(mutex_);
  wanted_.reset();
  cancelled_ = true;
  child_.stop();
}

bool Looking::runs(uint64_t opened, const std::string& version) const {
  const std::lock_guard lock(mutex_);
  return running_ && !over_ && running_->opened == opened && running_->version == version;
}

void Looking::run_alone(const std::vector<std::string>& command,
                        const std::filesystem::path& folder,
                        const std::function<void(const nlohmann::json&)>& said) {
  {
    std::unique_lock lock(mutex_);
    if (alone_) throw Refusal(409, "another change is being computed: wait for it, or cancel it");
    alone_ = true;
    wanted_.reset();
    if (running_) child_.stop();
    changed_.wait(lock, [&] { return !running_; });
    child_.allow();
  }
  Child::Ended ended;
  std::string failed;
  try {
    ended = child_.run(command, folder, events_to(said));
  } catch (const std::exception& error) {
    failed = error.what();
  }
  {
    const std::lock_guard lock(mutex_);
    alone_ = false;
  }
  changed_.notify_all();
  if (!failed.empty()) throw InputError(failed);
  if (ended.stopped) throw Refusal(409, "cancelled; nothing was changed");
  if (ended.code != 0) throw Refusal(400, ended.trouble());
}

void Looking::work() {
  while (true) {
    LookJob job;
    {
      std::unique_lock lock(mutex_);
      changed_.wait(lock, [&] { return ending_ || (wanted_ && !alone_); });
      if (ending_) return;
      job = *std::move(wanted_);
      wanted_.reset();
      running_ = job;
      cancelled_ = over_ = false;
      child_.allow();
    }
    run(job);
    {
      const std::lock_guard lock(mutex_);
      running_.reset();
    }
    changed_.notify_all();
  }
}

void Looking::run(const LookJob& job) {
  std::string trouble;
  bool stopped = false;
  for (const auto& command : job.commands) {
    try {
      const Child::Ended ended =
          child_.run(command, job.folder, events_to([&](const auto& event) { said_(job, event); }));
      stopped = ended.stopped;
      if (!stopped && ended.code != 0) trouble = ended.trouble();
    } catch (const std::exception& error) {
      trouble = error.what();
    }
    if (stopped || !trouble.empty()) break;
  }
  bool cancelled = false;
  {
    const std::lock_guard lock(mutex_);
    cancelled = cancelled_;
    over_ = true;  // The last event, too, says that the look has ended.
  }
  ended_(job, trouble, stopped && cancelled);
}

}  // namespace seam::tools
