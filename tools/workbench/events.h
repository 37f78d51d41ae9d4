// What the page gets without asking: server-sent events, numbered, the last of them kept so that
// a page that was away for a moment goes on where it was.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <deque>
#include <functional>
#include <mutex>
#include <nlohmann/json.hpp>
#include <string>

namespace httplib {
struct Request;
struct Response;
}  // namespace httplib

namespace seam::tools {

class Events {
 public:
  void publish(const std::string& name, const nlohmann::json& data);
  // Answers with the stream of what comes after the last event that the page had; a page that had
  // none, or missed too many, first gets `whole`. Throws Refusal where too many are open.
  void answer(const httplib::Request& request, httplib::Response& response,
              const std::function<nlohmann::json()>& whole);

  static constexpr int kMostStreams = 6;

 private:
  struct Event {
    uint64_t number = 0;
    std::string text;
  };
  std::string text_after(uint64_t& last);

  std::mutex mutex_;
  std::condition_variable published_;
  std::deque<Event> kept_;
  uint64_t count_ = 0;
  int streams_ = 0;
};

}  // namespace seam::tools
