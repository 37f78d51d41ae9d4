// A page for whoever sits at this machine, and the rules that its requests must keep
// (docs/reference/workbench_api.md, "Safety"): the address is loopback, Host names it, and no page
// of another origin asks. A server with a secret answers /api only to who has the cookie for it.
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

  struct Settings {
    std::string folder;                 // Of the page, below share/seam.
    const char* folder_from = nullptr;  // An environment variable that names another one.
    std::string policy;                 // Content-Security-Policy; empty: none.
    bool secret = false;                // Whether /api asks for the cookie.
    size_t most_body = 0;
    int threads = GatedServer::kUsualThreads;
  };
  explicit PageServer(const Settings& settings);

  // What is thrown becomes the answer: UsageError 400, Refusal its status, others 500.
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
  const std::string token_, cookie_;  // Of a server with a secret.
  int port_ = 0;
  GatedServer server_;
};

void answer_json(httplib::Response& response, const nlohmann::json& json, int status = 200);

}  // namespace seam::tools
