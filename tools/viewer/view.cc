// `seam view F`: the viewer's page over one or two logs, on this machine alone
// (docs/reference/viewer_api.md).
#include <httplib.h>

#include <algorithm>
#include <functional>
#include <nlohmann/json.hpp>

#include "app/logs/log_difference.h"
#include "app/logs/log_search.h"
#include "sim_core/base/error.h"
#include "sim_core/input/shown_text.h"
#include "tools/command.h"
#include "tools/pages/page_server.h"
#include "tools/viewer/view_data.h"

namespace seam::tools {
namespace {

struct Settings {
  std::vector<std::string> files;
  int port = 0;
  std::optional<double> at_s;  // What the printed address shows; as robot.
  std::string robot;
};

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
    add_answers();
  }

  void serve(const Settings& settings) { server_.serve(settings.port, moment(settings)); }

 private:
  using Answer = std::string (ViewData::*)(const Query&);

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
    server_.get("/api/" + name,
                [answer](const httplib::Request& request, httplib::Response& response) {
                  Query query;
                  for (const auto& [key, value] : request.params) query.emplace(key, value);
                  try {
                    answer(query, response);
                  } catch (const NotFound& error) {
                    throw Refusal(404, error.what());
                  }
                });
  }

  std::vector<std::unique_ptr<ViewData>> logs_;
  PageServer server_{{.folder = "viewer", .folder_from = "SEAM_VIEWER_DIR"}};
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
