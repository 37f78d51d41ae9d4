#include "tools/workbench/events.h"

#include <charconv>
#include <chrono>

#include "tools/pages/page_server.h"

namespace seam::tools {
namespace {

constexpr size_t kMostKept = 256;
constexpr auto kBeat = std::chrono::seconds(5);  // So often something is sent, whatever happens.

std::string event_text(uint64_t number, const std::string& name, const nlohmann::json& data) {
  return "id: " + std::to_string(number) + "\nevent: " + name +
         "\ndata: " + data.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace) + "\n\n";
}

// The number of the last event that the page had; 0: none.
uint64_t last_of(const httplib::Request& request) {
  const std::string text = request.has_header("Last-Event-ID")
                               ? request.get_header_value("Last-Event-ID")
                               : request.get_param_value("last");
  uint64_t number = 0;
  std::from_chars(text.data(), text.data() + text.size(), number);
  return number;
}

}  // namespace

void Events::publish(const std::string& name, const nlohmann::json& data) {
  {
    const std::lock_guard lock(mutex_);
    ++count_;
    kept_.push_back({count_, event_text(count_, name, data)});
    if (kept_.size() > kMostKept) kept_.pop_front();
  }
  published_.notify_all();
}

// Waits for events behind the last; a comment keeps the connection where none comes.
std::string Events::text_after(uint64_t& last) {
  std::unique_lock lock(mutex_);
  published_.wait_for(lock, kBeat, [&] { return count_ > last; });
  std::string text;
  for (const Event& event : kept_) {
    if (event.number > last) text += event.text;
  }
  last = count_;
  return text.empty() ? ":\n\n" : text;
}

void Events::answer(const httplib::Request& request, httplib::Response& response,
                    const std::function<nlohmann::json()>& whole) {
  uint64_t last = last_of(request);
  bool missed = false;
  {
    const std::lock_guard lock(mutex_);
    if (streams_ >= kMostStreams)
      throw Refusal(503, "the page is open too often: close one of its tabs");
    ++streams_;
    missed = last == 0 || last > count_ || (!kept_.empty() && last + 1 < kept_.front().number);
    if (missed) last = count_;
  }
  const std::string first = missed ? event_text(last, "state", whole()) : ":\n\n";
  response.set_header("Cache-Control", "no-store");
  response.set_chunked_content_provider(
      "text/event-stream",
      [this, last, first, begun = false](size_t, httplib::DataSink& sink) mutable {
        const std::string text = begun ? text_after(last) : first;
        begun = true;
        return sink.write(text.data(), text.size());
      },
      [this](bool) {
        const std::lock_guard lock(mutex_);
        --streams_;
      });
}

}  // namespace seam::tools
