// `seam view F`: the viewer's page over one or two logs, on this machine alone
// (docs/reference/viewer_api.md).
#include <httplib.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>

#include "app/logs/log_difference.h"
#include "app/logs/log_search.h"
#include "sim_core/base/error.h"
#include "sim_core/input/shown_text.h"
#include "sim_core/system/own_files.h"
#include "tools/command.h"
#include "tools/viewer/gated_server.h"
#include "tools/viewer/loopback_host.h"
#include "tools/viewer/view_data.h"

namespace seam::tools {
namespace {

namespace fs = std::filesystem;

struct Settings {
  std::vector<std::string> files;
  int port = 0;
  std::optional<double> at_s;  // What the printed address shows; as robot.
  std::string robot;
};

fs::path page_folder() {
  if (const char* given = std::getenv("SEAM_VIEWER_DIR")) return given;
  const fs::path found = find_shared("viewer");
  return found.empty() ? program_file().parent_path() / "share/seam/viewer" : found;
}

void refuse(httplib::Response& response, int status, const std::string& sentence) {
  response.status = status;
  // A path in the sentence may hold bytes that are no UTF-8.
  response.set_content(nlohmann::json{{"error", sentence}}.dump(
                           -1, ' ', false, nlohmann::json::error_handler_t::replace),
                       "application/json");
}

// The address's query for what is to be shown first.
std::string moment(const Settings& settings) {
  if (!settings.at_s && settings.robot.empty()) return "";
  return app::view_query(SimTime::from_s(settings.at_s.value_or(0)), settings.robot);
}

class Viewer {
 public:
  explicit Viewer(const Settings& settings) {
    const char* ids[] = {"a", "b"};
    for (size_t i = 0; i < settings.files.size(); ++i) {
      logs_.push_back(std::make_unique<ViewData>(settings.files[i], ids[i]));
    }
    const std::vector<std::string>& robots = logs_[0]->log().header().robots;
    if (!settings.robot.empty() && std::ranges::find(robots, settings.robot) == robots.end())
      throw UsageError("--robot: there is no '" + shown(settings.robot) + "'" +
                       suggestion_for(settings.robot, robots));
    server_.set_pre_routing_handler(
        [](const httplib::Request& request, httplib::Response& response) {
          if (names_loopback(request.get_header_value("Host")))
            return httplib::Server::HandlerResponse::Unhandled;
          refuse(response, 403, "only requests from this machine are answered");
          return httplib::Server::HandlerResponse::Handled;
        });
    server_.set_error_handler([](const httplib::Request&, httplib::Response& response) {
      if (response.body.empty()) refuse(response, response.status, "there is nothing here");
    });
    add_pages();
    add_answers();
  }

  void serve(const Settings& settings) {
    const int port = settings.port;
    const int bound = port == 0 ? server_.bind_to_any_port("127.0.0.1")
                                : (server_.bind_to_port("127.0.0.1", port) ? port : -1);
    if (bound < 0) throw InputError(fmt::format("--port {}: cannot be had", port));
    server_.lengthen_queue();
    std::printf("http://127.0.0.1:%d/%s\nCtrl-C ends it.\n", bound, moment(settings).c_str());
    std::fflush(stdout);
    server_.listen_after_bind();
  }

 private:
  using Answer = std::string (ViewData::*)(const Query&);

  void add_pages() {
    const fs::path folder = page_folder();
    if (!fs::exists(folder / "index.html") || !server_.set_mount_point("/", folder.string())) {
      std::fprintf(stderr, "%s: no page there; scripts/build.sh builds it. /api works.\n",
                   folder.c_str());
    }
  }

  void add_answers() {
    get("info", [this](const Query&, httplib::Response& response) {
      nlohmann::ordered_json info = {{"format", "seam-view/1"},
                                     {"logs", nlohmann::ordered_json::array()}};
      for (const auto& log : logs_)
        info["logs"].push_back(nlohmann::ordered_json::parse(log->info()));
      response.set_content(info.dump(), "application/json");
    });
    const std::pair<const char*, Answer> answers[] = {{"truth", &ViewData::truth},
                                                      {"state", &ViewData::state},
                                                      {"events", &ViewData::events},
                                                      {"steps", &ViewData::steps},
                                                      {"find", &ViewData::find},
                                                      {"lanes", &ViewData::lanes},
                                                      {"decisions", &ViewData::decisions},
                                                      {"debug", &ViewData::debug},
                                                      {"series", &ViewData::series},
                                                      {"frames", &ViewData::frames},
                                                      {"frame_rows", &ViewData::frame_rows}};
    for (const auto& [name, answer] : answers) {
      get(name, [this, answer = answer](const Query& query, httplib::Response& response) {
        response.set_content((log(query).*answer)(query), "application/json");
      });
    }
    get("frame", [this](const Query& query, httplib::Response& response) {
      ViewPicture picture = log(query).frame(query);
      for (const auto& [name, value] : picture.headers) response.set_header(name, value);
      response.set_content(std::move(picture.png), "image/png");
    });
    get("diff", [this](const Query&, httplib::Response& response) {
      if (logs_.size() < 2) throw NotFound("there is only one log");
      std::call_once(compared_, [this] {
        difference_ = app::to_view_json(app::difference_of(logs_[0]->log(), logs_[1]->log()));
      });
      response.set_content(difference_, "application/json");
    });
  }

  ViewData& log(const Query& query) {
    const std::string id = text_of(query, "log", "a");
    if (id == "a") return *logs_[0];
    if (id == "b" && logs_.size() > 1) return *logs_[1];
    throw NotFound("log: expected a" + std::string(logs_.size() > 1 ? " or b" : ""));
  }

  void get(const std::string& name, std::function<void(const Query&, httplib::Response&)> answer) {
    server_.Get("/api/" + name,
                [answer](const httplib::Request& request, httplib::Response& response) {
                  Query query;
                  for (const auto& [key, value] : request.params) query.emplace(key, value);
                  try {
                    answer(query, response);
                  } catch (const UsageError& error) {
                    refuse(response, 400, error.what());
                  } catch (const NotFound& error) {
                    refuse(response, 404, error.what());
                  } catch (const std::exception& error) {
                    refuse(response, 500, error.what());
                  }
                });
  }

  std::vector<std::unique_ptr<ViewData>> logs_;
  GatedServer server_;
  std::once_flag compared_;
  std::string difference_;
};

}  // namespace

void add_view(app::Command app) {
  app::Command command =
      app.add_subcommand("view", "A web page that shows a log, or two side by side");
  auto settings = std::make_shared<Settings>();
  command.add_option("F", settings->files, "A log, or two to compare").required().count(1, 2);
  command.add_option("--port", settings->port, "Port on 127.0.0.1; 0: a free one").range(0, 65535);
  command
      .add_option("--at", settings->at_s,
                  "The printed address shows this simulated second, as\n"
                  "`seam replay find` names it")
      .range(0.0, 9e9);
  command.add_option("--robot", settings->robot, "The printed address shows this robot");
  command.footer(
      "Example: seam view match.mcap\nExample: seam view match.mcap --at 12.5 --robot red1");
  command.callback([settings] { Viewer(*settings).serve(*settings); });
}

}  // namespace seam::tools
