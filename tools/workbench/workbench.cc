// `seam workbench`: a page on this machine to work on a model with (docs/workbench.md).
#include <charconv>
#include <mutex>
#include <optional>

#include "measurement/sets/set.h"
#include "sim_core/base/error.h"
#include "sim_core/base/files.h"
#include "sim_core/base/output.h"
#include "sim_core/input/json_input.h"
#include "tools/command.h"
#include "tools/workbench/desk.h"
#include "tools/workbench/exporting.h"
#include "tools/workbench/formula.h"
#include "tools/workbench/intake.h"
#include "tools/workbench/look/look.h"
#include "tools/workbench/places.h"
#include "tools/workbench/see/see.h"
#include "tools/workbench/session/session_archive.h"

namespace seam::tools {
namespace {

namespace fs = std::filesystem;
using httplib::Request;
using httplib::Response;
using nlohmann::json;

constexpr size_t kMostBody = size_t{512} << 20;  // Of files that are dropped on the page.
constexpr int kThreads = 16;                     // Streams of events keep one each.

struct Settings {
  std::vector<std::string> named;
  int port = 0;
  std::string session, look;
  AnalysisFlags flags;  // Of a look.
};

// The fields of a request's body.
class Body {
 public:
  explicit Body(const Request& request) {
    fields_ = request.body.empty() ? json::object()
                                   : json_from_text(request.body, "the request", "an object");
    if (!fields_.is_object()) throw UsageError("the request: expected an object");
  }
  template <class T>
  T get(const char* name) const {
    try {
      return fields_.at(name).get<T>();
    } catch (const json::exception&) {
      throw UsageError(fmt::format("{}: found none or another kind of value", name));
    }
  }
  uint64_t revision() const {
    if (!get<json>("revision").is_number_unsigned())
      throw UsageError("revision: expected the state's own");
    return get<uint64_t>("revision");
  }
  std::string text(const char* name) const { return get<std::string>(name); }
  Desk::Ranges ranges() const {
    for (const json& range : get<json>("ranges")) {
      if (!range.is_array() || range.size() != 2 || !range[0].is_number_integer() ||
          !range[1].is_number_integer())
        throw UsageError("ranges: expected pairs of rows, the first and the last of each");
    }
    return get<Desk::Ranges>("ranges");
  }

 private:
  json fields_;
};

std::string effect_in(const Request& request) {
  const std::string effect = request.get_param_value("effect");
  if (effect.empty() || effect.find_first_of("/\\") != std::string::npos)
    throw UsageError("effect: expected the name of one");
  return effect;
}

class Workbench {
 public:
  explicit Workbench(const Settings& settings)
      : places_(settings.named, settings.session), intake_(places_.beside()) {
    if (!settings.named.empty()) open(places_.to_open(settings.named.front()));
    offer();
    add_reading();
    add_exports();
    add_changes();
    add_openings();
    add_seeing();
    add_formulas();
  }

  void serve(int port) { server_.serve(port, ""); }

 private:
  void open(const fs::path& data) {
    desk_.open(data, places_.session_of(data));
    places_.remember(data, desk_.state()["set"]);
    offer();
  }

  void offer() { desk_.offer(places_.recent(), intake_.samples(), places_.named()); }

  // Makes the set where it is not there, then opens it.
  void open(const Making& making, const std::string& what) {
    if (!making.command.empty()) desk_.prepare(what, making.command, making.folder);
    making.finish();
    open(fs::canonical(making.set));
  }

  // A change answers with the state that it made.
  void change(const std::string& name, std::function<void(const Body&)> action) {
    server_.post("/api/" + name, [this, action](const Request& request, Response& response) {
      action(Body(request));
      answer_json(response, desk_.state());
    });
  }

  void get_file(const std::string& name, const std::string& type,
                std::function<std::vector<std::string>(const Request&)> files) {
    server_.get("/api/" + name, [this, type, files](const Request& request, Response& response) {
      const fs::path path = desk_.computed(request.get_param_value("version"), files(request));
      if (path.empty()) return answer_json(response, json::object(), 202);
      response.set_header("Cache-Control", "no-store");
      response.set_content(read_file(path), type);
    });
  }

  void add_reading() {
    server_.get("/api/state", [this](const Request&, Response& response) {
      answer_json(response, desk_.state());
    });
    server_.get("/api/events", [this](const Request& request, Response& response) {
      desk_.events().answer(request, response, [this] { return desk_.state(); });
    });
    server_.get("/api/search", [this](const Request& request, Response& response) {
      answer_json(response, desk_.search(request.get_param_value("version")));
    });
    server_.get("/api/script", [this](const Request&, Response& response) {
      response.set_content(desk_.script(), "text/x-shellscript; charset=utf-8");
    });
    server_.get("/api/line", [this](const Request& request, Response& response) {
      const std::string text = request.get_param_value("row");
      int64_t row = -1;
      std::from_chars(text.data(), text.data() + text.size(), row);
      answer_json(response, desk_.line(row));
    });
    server_.get("/api/picture", [this](const Request& request, Response& response) {
      const std::string frame = request.get_param_value("frame");
      const fs::path file = intake_.picture_of(desk_.set_folder(), frame);
      const bool is_png = file.extension() == ".png";
      if (!is_png && file.extension() != ".jpg" && file.extension() != ".jpeg")
        throw Refusal(404, "there is no picture of this frame");
      response.set_content(read_file(file), is_png ? "image/png" : "image/jpeg");
    });
    using Files = std::vector<std::string>;
    get_file("rows", "application/octet-stream",
             [](const Request&) -> Files { return {"rows.bin"}; });
    get_file("preview", "application/octet-stream", [](const Request& request) -> Files {
      const std::string effect = effect_in(request);
      return {"fit-" + effect + ".bin", "step-" + effect + ".bin"};
    });
    get_file("frames", "application/octet-stream", [](const Request& request) -> Files {
      if (request.get_param_value("what") == "measured") return {"frames.bin"};
      if (!request.has_param("effect")) return {"predicted.bin"};
      return {"predicted-" + effect_in(request) + ".bin"};
    });
    get_file("runs", "application/octet-stream", [](const Request& request) -> Files {
      if (!request.has_param("effect")) return {"runs.bin"};
      return {"runs-" + effect_in(request) + ".bin"};
    });
  }

  void export_file(const Request& request, Response& response) {
    const std::string what = request.get_param_value("what");
    const json state = desk_.state();
    std::string version = request.get_param_value("version");
    if (version.empty()) version = state.value("current", "");
    std::string content, type = "application/octet-stream";
    std::string name = name_in_files(fs::path(desk_.set_folder()).filename());
    if (what == "script") {
      content = desk_.script(), name += ".sh";
    } else if (what == "model") {
      content = as_shown(version).to_yaml(), name += "-" + version + ".yaml";
    } else if (what == "session") {
      content = session_archive(state.value("session", ""), desk_.script());
      name += "-session.zip", type = "application/zip";
    } else if (what == "report") {
      const fs::path file = desk_.computed(version, {"report.html"});
      if (file.empty()) return answer_json(response, json::object(), 202);
      content = read_file(file), name += "-" + version + ".html";
    } else {
      throw UsageError("what: expected report, model, script or session");
    }
    response.set_header("Content-Disposition", "attachment; filename=\"" + name + "\"");
    response.set_content(content, type.c_str());
  }

  void add_exports() {
    server_.get("/api/export", [this](const Request& request, Response& response) {
      export_file(request, response);
    });
    server_.get("/api/formats", [this](const Request&, Response& response) {
      answer_json(response, {{"formats", export_formats_json(set_kind())}});
    });
    server_.post("/api/export", [this](const Request& request, Response& response) {
      const Body body(request);
      const std::string version = body.text("version");
      const fs::path session = desk_.state().value("session", "");
      const std::lock_guard one_at_a_time(exporting_);
      answer_json(response, exported_json({.model = as_shown(version),
                                           .version = version,
                                           .set = desk_.set_folder(),
                                           .scratch = session / "cache" / version,
                                           .format = body.text("format"),
                                           .drop = body.get<bool>("drop")}));
    });
  }

  void add_changes() {
    change("add", [this](const Body& body) { desk_.add(body.revision(), body.text("effect")); });
    change("fit", [this](const Body& body) { desk_.refit(body.revision()); });
    change("undo", [this](const Body& body) { desk_.undo(body.revision()); });
    change("redo", [this](const Body& body) { desk_.redo(body.revision()); });
    change("goto",
           [this](const Body& body) { desk_.go_to(body.revision(), body.text("version")); });
    change("note", [this](const Body& body) {
      desk_.note(body.revision(), body.text("version"), body.text("note"));
    });
    change("leave-out", [this](const Body& body) {
      desk_.leave_out(body.revision(), body.ranges(), body.text("reason"));
    });
    change("take-back",
           [this](const Body& body) { desk_.take_back(body.revision(), body.ranges()); });
    change("cancel", [this](const Body&) { desk_.cancel(); });
    server_.put("/api/selection", [this](const Request& request, Response& response) {
      desk_.select(Body(request).ranges());
      answer_json(response, json::object());
    });
  }

  void add_openings() {
    change("open", [this](const Body& body) {
      const std::string path = body.text("path");
      if (const auto sample = intake_.of_sample(path)) return open(*sample, "making the sample");
      open(places_.to_open(path));
    });
    server_.get("/api/imports", [](const Request&, Response& response) {
      answer_json(response, {{"kinds", imports_json()}, {"most_bytes", kMostBody}});
    });
    server_.post("/api/upload", [this](const Request& request, Response& response) {
      const json taken = intake_.take_in(request.files);
      if (!taken.contains("set")) return answer_json(response, {{"import", taken}});
      open(taken["set"].get<std::string>());
      answer_json(response, desk_.state());
    });
    change("import", [this](const Body& body) {
      const auto options = body.get<std::map<std::string, std::string>>("options");
      open(intake_.of_dropped(body.text("dropped"), body.text("kind"), options), "importing");
    });
  }

  // Where the fitted values of a version stand: empty while it is being compared, nothing where
  // that ended without.
  std::optional<fs::path> fitted_values(const std::string& version) {
    try {
      return desk_.computed(version, {"model.json"});
    } catch (const Refusal&) {
      return std::nullopt;
    }
  }

  // A version as its rows are judged: what is free has its fitted values, once these are known.
  effects::Model as_fitted(const std::string& version) {
    auto model = effects::Model::from_file(desk_.model(version));
    const auto file = fitted_values(version);
    if (file && !file->empty()) take_values(model, json_of(*file));
    return model;
  }

  // The same to take away, which waits for the values.
  effects::Model as_shown(const std::string& version) {
    const auto file = fitted_values(version);
    if (file && file->empty())
      throw Refusal(409,
                    "version " + version + " is being compared; export it once its error is shown");
    return as_fitted(version);
  }

  void add_seeing() {
    server_.get("/api/see", [this](const Request& request, Response& response) {
      answer_json(response,
                  {{"effects", sliders_json(as_fitted(request.get_param_value("version")))}});
    });
    server_.post("/api/see", [this](const Request& request, Response& response) {
      const Body body(request);
      auto model = as_fitted(body.text("version"));
      change_parameters(model, body.get<json>("changes"));
      const auto set = measurement::MeasurementSet::open(desk_.set_folder());
      const std::lock_guard one_at_a_time(seeing_);  // Each takes all cores, and memory.
      const SeenFrame frame = see(model, {.width_px = set.camera.width_px,
                                          .height_px = set.camera.height_px,
                                          .head_rate_radps = body.get<double>("head_rate_radps"),
                                          .coarse = body.get<bool>("coarse")});
      std::string bytes =
          head_bytes({{"width_px", frame.width_px}, {"height_px", frame.height_px}});
      bytes.append(frame.rgb.begin(), frame.rgb.end());
      response.set_content(std::move(bytes), "application/octet-stream");
    });
  }

  std::string set_kind() {
    const json set = desk_.state()["set"];
    return set.is_object() ? set.value("kind", "") : "";
  }

  void add_formulas() {
    server_.get("/api/formula", [this](const Request&, Response& response) {
      answer_json(response, formula_stages_json(set_kind()));
    });
    server_.post("/api/formula/check", [](const Request& request, Response& response) {
      const Body body(request);
      answer_json(response,
                  formula_checked(body.text("stage"), body.text("name"), body.text("text")));
    });
    change("formula/fit", [this](const Body& body) {
      desk_.add_formula(body.revision(), body.text("stage"), body.text("name"), body.text("text"));
    });
    server_.post("/api/suggest", [this](const Request&, Response& response) {
      const json found = desk_.search(desk_.state().value("current", ""));
      json proposals = json::array();
      if (found.contains("suggestion")) {
        json proposal = found["suggestion"];
        proposal["name"] = proposal["effect"];
        proposals.push_back(std::move(proposal));
      }
      answer_json(response, {{"proposals", std::move(proposals)},
                             {"searched", found.contains("verdict") || found.contains("trouble")}});
    });
    server_.post("/api/plan", [this](const Request& request, Response& response) {
      // --model M --data D, then what is left out, which a plan does not ask.
      const std::vector<std::string> words = desk_.of_current();
      std::vector<std::string> command = {"plan", words.at(0), words.at(1), "--protocol",
                                          words.at(3)};
      const auto effects = Body(request).get<std::vector<std::string>>("effects");
      for (const std::string& effect : effects) {
        if (!is_effect_name(effect)) throw UsageError("effects: expected names of effects");
        command.push_back("--effects");
        command.push_back(effect);
      }
      command.push_back("--json");
      answer_json(response, desk_.ask(std::move(command), "plan.json"));
    });
  }

  const Places places_;
  const Intake intake_;
  Desk desk_;
  std::mutex seeing_, exporting_;
  PageServer server_{{.folder = "workbench",
                      .folder_from = "SEAM_WORKBENCH_DIR",
                      .most_body = kMostBody,
                      .threads = kThreads}};
};

void run(Settings& settings) {
  if (settings.look.empty()) {
    if (!settings.flags.model.empty() || !settings.flags.leave_out.empty())
      throw UsageError("workbench: --model and --leave-out go with --look alone");
    return Workbench(settings).serve(settings.port);
  }
  if (settings.named.size() != 1 || settings.flags.model.empty())
    throw UsageError("workbench: --look expects one set and its --model");
  settings.flags.data = settings.named.front();
  make_output_folder(settings.look);
  look_into(settings.flags, settings.look);
}

}  // namespace

void add_workbench(app::Command app) {
  app::Command command = app.add_subcommand(
      "workbench", "A web page to work on a model with: see the misfit, try effects, add them");
  auto settings = std::make_shared<Settings>();
  command.add_option("SET", settings->named, "Measurement sets: their folders");
  command.add_option("--port", settings->port, "Port on 127.0.0.1; 0: a free one").range(0, 65535);
  command.add_option("--session", settings->session,
                     "The folder where the work is kept (default: SET.session in this folder)");
  command.add_option("--look", settings->look,
                     "No page: writes what the page shows of --model into this folder");
  command.add_option("--model", settings->flags.model, "Of --look: the model");
  command.add_option("--leave-out", settings->flags.leave_out,
                     "Of --look: rows that take no part (row, reason)");
  command.footer("Example: seam workbench sets/points-a --session work");
  command.callback([settings] { run(*settings); });
}

}  // namespace seam::tools
