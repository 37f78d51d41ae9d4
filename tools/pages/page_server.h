// A page for whoever sits at this machine, and the rules that its requests must keep
// (docs/reference/workbench_api.md, "Safety"): the address is loopback, Host names it, no page of
// another origin asks, and /api answers only to who has the cookie. The page runs no script but its
// own files.
#pragma once

#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>

#include "tools/pages/gated_server.h"
#include "tools/pages/refusal.h"

namespace seam::tools {

class PageServer {
 public:
  using Answer = std::function<void(const httplib::Request&, httplib::Response&)>;

  // Of a request without the cookie: the token alone.
  static constexpr size_t kMostBodyToEnter = 4096;

  struct Settings {
    std::string folder;                 // Of the page, below share/seam.
    const char* folder_from = nullptr;  // An environment variable that names another one.
    size_t most_body = kMostBodyToEnter;
    int threads = GatedServer::kUsualThreads;
  };
  explicit PageServer(const Settings& settings);

  // What is thrown becomes the answer: UsageError and InputError 400, Refusal its status, others
  // 500.
  void get(const std::string& path, Answer answer);
  void post(const std::string& path, Answer answer);
  void put(const std::string& path, Answer answer);

  // Prints the address, `then` behind it, and serves until the process ends. Throws InputError
  // where the port (0: any) cannot be had.
  void serve(int port, const std::string& then);

 private:
  std::string trouble_with(const httplib::Request& request) const;
  bool has_cookie(std::string_view head) const;
  void enter(const httplib::Request& request, httplib::Response& response) const;

  const Settings settings_;
  const std::string token_, cookie_;
  int port_ = 0;
  GatedServer server_;
};

void answer_json(httplib::Response& response, const nlohmann::json& json, int status = 200);

}  // namespace seam::tools
