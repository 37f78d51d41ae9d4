// What stands in a folder of episodes; docs/reference/episodes.md is the page of it.
#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "app/episodes/episode.h"
#include "app/episodes/npz_writer.h"
#include "sim_core/base/error.h"
#include "sim_core/base/output.h"

namespace seam::app {

namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kState = "observation.state";
constexpr const char* kAction = "action";
constexpr const char* kImages = "observation.images.camera";

std::vector<std::string> names_of(const std::vector<EpisodeField>& fields) {
  std::vector<std::string> names;
  for (const EpisodeField& field : fields) names.push_back(field.name);
  return names;
}

Json feature(const char* type, Json shape, Json names, const char* unit, const char* meaning) {
  Json json = {{"dtype", type}, {"shape", std::move(shape)}, {"names", std::move(names)}};
  if (*unit != '\0') json["unit"] = unit;
  json["meaning"] = meaning;
  return json;
}

Json feature_of(const std::vector<EpisodeField>& fields, const char* meaning) {
  Json json = feature("float64", {fields.size()}, names_of(fields), "", meaning);
  json["units"] = Json::array();
  for (const EpisodeField& field : fields) json["units"].push_back(field.unit);
  return json;
}

Json features_of(const EpisodeKind& kind) {
  Json json;
  json[kState] = feature_of(kind.state, "what the robot sensed at its turn");
  json[kAction] =
      feature_of(kind.action, "what it ordered then; targets and walk as they hold from then on");
  if (kind.height_px > 0) {
    json[kImages] =
        feature("uint8", {kind.height_px, kind.width_px, 3}, {"height", "width", "channel"}, "",
                "the newest frame that the robot had been sent, RGB; 0 before the first");
    json[std::string(kImages) + ".index"] =
        feature("int64", {1}, nullptr, "",
                "that frame's number by the camera's clock; -1 before the first");
  }
  json["timestamp"] = feature("float64", {1}, nullptr, "s", "simulated time of the turn");
  json["time_ns"] = feature("int64", {1}, nullptr, "ns", "the same, exact");
  json["frame_index"] = feature("int64", {1}, nullptr, "", "row of the episode, from 0");
  json["episode_index"] = feature("int64", {1}, nullptr, "", "episode, from 0");
  json["index"] = feature("int64", {1}, nullptr, "", "row of the data set, from 0");
  json["next.done"] = feature("uint8", {1}, nullptr, "", "1 in the last row of an episode");
  return json;
}

std::string file_of(size_t episode) {
  return fmt::format("episode_{:06}.npz", episode);
}

}  // namespace

EpisodeFolder::EpisodeFolder(const std::filesystem::path& folder) : folder_(folder) {
  make_output_folder(folder);
}

void EpisodeFolder::add(const Episode& episode, const std::string& log) {
  if (logs_.empty()) kind_ = episode.kind;
  if (episode.kind != kind_)
    throw InputError(
        fmt::format("{}: its robot has other joints, camera or turns than that of {}, "
                    "expected episodes of one kind of robot",
                    log, logs_.front()));
  const size_t rows = episode.time_ns.size();
  NpzWriter file(folder_ / file_of(logs_.size()));
  file.add(kState, {rows, kind_.state.size()}, std::span<const double>(episode.state));
  file.add(kAction, {rows, kind_.action.size()}, std::span<const double>(episode.action));
  file.add(std::string(kState) + ".names", names_of(kind_.state));
  file.add(std::string(kAction) + ".names", names_of(kind_.action));
  std::vector<double> seconds;
  std::vector<int64_t> frame, number, index;
  std::vector<uint8_t> done(rows, 0);
  done.back() = 1;
  for (size_t row = 0; row < rows; ++row) {
    seconds.push_back(static_cast<double>(episode.time_ns[row]) / 1e9);
    frame.push_back(static_cast<int64_t>(row));
    number.push_back(static_cast<int64_t>(logs_.size()));
    index.push_back(static_cast<int64_t>(rows_ + row));
  }
  file.add("timestamp", {rows}, std::span<const double>(seconds));
  const auto integers = [&](const char* name, const std::vector<int64_t>& values) {
    file.add(name, {rows}, std::span<const int64_t>(values));
  };
  integers("time_ns", episode.time_ns);
  integers("frame_index", frame);
  integers("episode_index", number);
  integers("index", index);
  file.add("next.done", {rows}, std::span<const uint8_t>(done));
  if (kind_.height_px > 0) {
    integers("observation.images.camera.index", episode.frame_index);
    file.add(kImages, {rows, kind_.height_px, kind_.width_px, 3},
             std::span<const uint8_t>(episode.rgb));
  }
  file.finish();
  logs_.push_back(log);
  seeds_.push_back(episode.seed);
  lengths_.push_back(static_cast<int64_t>(rows));
  rows_ += rows;
}

void EpisodeFolder::finish() {
  Json episodes = Json::array();
  for (size_t i = 0; i < logs_.size(); ++i)
    episodes.push_back({{"episode_index", i},
                        {"file", file_of(i)},
                        {"length", lengths_[i]},
                        {"seed", seeds_[i]},
                        {"log", logs_[i]}});
  const Json schema = {{"format", "seam-episodes/1"},
                       {"robot", kind_.robot},
                       {"robot_type", kind_.robot_type},
                       {"fps", kind_.turns_per_s},
                       {"total_episodes", logs_.size()},
                       {"total_frames", rows_},
                       {"data_path", "episode_{episode_index:06d}.npz"},
                       {"features", features_of(kind_)},
                       {"episodes", std::move(episodes)}};
  write_file_atomically(
      folder_ / "schema.json",
      schema.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n");
}

}  // namespace seam::app
