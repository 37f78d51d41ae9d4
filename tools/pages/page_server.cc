#include "tools/pages/page_server.h"

#include <sys/random.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>

#include "sim_core/base/error.h"
#include "sim_core/system/own_files.h"
#include "tools/pages/loopback_host.h"

namespace seam::tools {
namespace {

namespace fs = std::filesystem;

constexpr const char* kPolicy =
    "default-src 'none'; script-src 'self'; style-src 'self' 'unsafe-inline'; img-src 'self' data: "
    "blob:; font-src 'self'; connect-src 'self'; base-uri 'none'; form-action 'none'; "
    "frame-ancestors 'none'";

// 256 bits of the system's randomness, as hexadecimal digits.
std::string secret_text() {
  unsigned char bytes[32];
  if (::getrandom(bytes, sizeof bytes, 0) != static_cast<ssize_t>(sizeof bytes))
    throw InputError("the system gives no random numbers for the page's token");
  std::string text;
  for (const unsigned char byte : bytes) text += fmt::format("{:02x}", byte);
  return text;
}

// Takes as long whatever differs, so that the time shows nothing of the secret.
bool same_secret(std::string_view a, std::string_view b) {
  if (a.size() != b.size() || a.empty()) return false;
  unsigned char differing = 0;
  for (size_t i = 0; i < a.size(); ++i) differing |= static_cast<unsigned char>(a[i] ^ b[i]);
  return differing == 0;
}

fs::path page_folder(const PageServer::Settings& settings) {
  const char* given = settings.folder_from ? std::getenv(settings.folder_from) : nullptr;
  if (given) return given;
  const fs::path found = find_shared(settings.folder);
  return found.empty() ? program_file().parent_path() / "share/seam" / settings.folder : found;
}

void refuse(httplib::Response& response, int status, const std::string& sentence,
            nlohmann::json more = nlohmann::json::object()) {
  more["error"] = sentence;
  answer_json(response, more, status);
}

httplib::Server::Handler answered(PageServer::Answer answer) {
  return
      [answer = std::move(answer)](const httplib::Request& request, httplib::Response& response) {
        try {
          answer(request, response);
        } catch (const Refusal& refusal) {
          refuse(response, refusal.status(), refusal.what(), refusal.more());
        } catch (const UsageError& error) {
          refuse(response, 400, error.what());
        } catch (const InputError& error) {
          refuse(response, 400, error.what());
        } catch (const std::exception& error) {
          refuse(response, 500, error.what());
        }
      };
}

}  // namespace

void answer_json(httplib::Response& response, const nlohmann::json& json, int status) {
  response.status = status;
  // Names of files may hold bytes that are no UTF-8.
  response.set_content(json.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace),
                       "application/json");
}

PageServer::PageServer(const Settings& settings)
    : settings_(settings),
      token_(secret_text()),
      cookie_(secret_text()),
      server_(settings.threads, [this](std::string_view head) {
        return has_cookie(head) ? settings_.most_body
                                : std::min(settings_.most_body, kMostBodyToEnter);
      }) {
  server_.set_payload_max_length(settings_.most_body);
  server_.set_default_headers({{"X-Content-Type-Options", "nosniff"},
                               {"Referrer-Policy", "no-referrer"},
                               {"Cross-Origin-Resource-Policy", "same-origin"},
                               {"Cross-Origin-Opener-Policy", "same-origin"},
                               {"Content-Security-Policy", kPolicy}});
  server_.set_pre_routing_handler(
      [this](const httplib::Request& request, httplib::Response& response) {
        const std::string trouble = trouble_with(request);
        const bool open = !request.path.starts_with("/api/") || request.path == "/api/enter";
        if (!trouble.empty()) {
          refuse(response, 403, trouble);
        } else if (!open && !has_cookie("\r\nCookie: " + request.get_header_value("Cookie"))) {
          refuse(response, 401,
                 "this page was opened without its token: open the address that the "
                 "command printed");
        } else {
          return httplib::Server::HandlerResponse::Unhandled;
        }
        return httplib::Server::HandlerResponse::Handled;
      });
  server_.set_error_handler([](const httplib::Request&, httplib::Response& response) {
    if (!response.body.empty()) return;
    refuse(response, response.status,
           response.status == 413 ? "the request is larger than this server takes"
                                  : "there is nothing here");
  });
  post("/api/enter", [this](const auto& request, auto& response) { enter(request, response); });
  const fs::path folder = page_folder(settings_);
  if (!fs::exists(folder / "index.html") || !server_.set_mount_point("/", folder.string()))
    std::fprintf(stderr, "%s: no page there; scripts/build.sh builds it. /api works.\n",
                 folder.c_str());
}

std::string PageServer::trouble_with(const httplib::Request& request) const {
  const std::string host = request.get_header_value("Host");
  if (!names_loopback(host)) return "only requests from this machine are answered";
  if (request.has_header("Origin") && request.get_header_value("Origin") != "http://" + host)
    return "only the page of this server may ask";
  // Pages of other servers on this machine: browsers send them the cookie, too.
  const std::string site = request.get_header_value("Sec-Fetch-Site");
  const bool navigates = request.get_header_value("Sec-Fetch-Mode") == "navigate";
  if (!site.empty() && site != "same-origin" && site != "none" &&
      (!navigates || request.path.starts_with("/api/")))
    return "only the page of this server may ask";
  return "";
}

bool PageServer::has_cookie(std::string_view head) const {
  const std::string name = fmt::format("seam-{}=", port_);
  for (size_t at = head.find(name); at != std::string_view::npos; at = head.find(name, at + 1)) {
    if (same_secret(head.substr(at + name.size(), cookie_.size()), cookie_)) return true;
  }
  return false;
}

void PageServer::enter(const httplib::Request& request, httplib::Response& response) const {
  const auto given = nlohmann::json::parse(request.body, nullptr, /*allow_exceptions=*/false);
  if (!given.is_object() || !given.contains("token") || !given["token"].is_string() ||
      !same_secret(given["token"].get<std::string>(), token_))
    throw Refusal(401, "this is not the token of this server: open the address that it printed");
  response.set_header("Set-Cookie",
                      fmt::format("seam-{}={}; Path=/; HttpOnly; SameSite=Strict", port_, cookie_));
  answer_json(response, nlohmann::json::object());
}

void PageServer::get(const std::string& path, Answer answer) {
  server_.Get(path, answered(std::move(answer)));
}

void PageServer::post(const std::string& path, Answer answer) {
  server_.Post(path, answered(std::move(answer)));
}

void PageServer::put(const std::string& path, Answer answer) {
  server_.Put(path, answered(std::move(answer)));
}

void PageServer::serve(int port, const std::string& then) {
  port_ = port == 0 ? server_.bind_to_any_port("127.0.0.1")
                    : (server_.bind_to_port("127.0.0.1", port) ? port : -1);
  if (port_ < 0) throw InputError(fmt::format("--port {}: cannot be had", port));
  server_.lengthen_queue();
  std::printf("http://127.0.0.1:%d/%s#token=%s\nCtrl-C ends it.\n", port_, then.c_str(),
              token_.c_str());
  std::fflush(stdout);
  server_.listen_after_bind();
}

}  // namespace seam::tools
