#include "measurement/report/lens_map.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <functional>
#include <nlohmann/json.hpp>
#include <optional>

#include "effects/cameras.h"
#include "effects/questions.h"
#include "effects/stages/geometry.h"
#include "measurement/report/finite_or_null.h"

namespace seam::measurement {
namespace {

using effects::ImagePoint;
using effects::Projection;
using Two = Eigen::Matrix<double, 2, 1>;

constexpr int kCellsAlong = 24;

struct Place {
  double u = 0, v = 0;
  std::optional<Vec3> ray;
};

LensMap empty_map(const std::string& camera, int width_px, int height_px) {
  LensMap map{
      .camera = camera, .columns = kCellsAlong, .width_px = width_px, .height_px = height_px};
  map.rows = std::max(
      1, static_cast<int>(std::lround(kCellsAlong * height_px / static_cast<double>(width_px))));
  return map;
}

std::vector<Place> places_of(const LensMap& map, const Projection& lens) {
  std::vector<Place> places;
  for (int r = 0; r < map.rows; ++r) {
    for (int c = 0; c < map.columns; ++c) {
      Place place{(c + 0.5) * map.width_px / map.columns - 0.5,
                  (r + 0.5) * map.height_px / map.rows - 0.5, std::nullopt};
      place.ray = lens.unproject(place.u, place.v);
      places.push_back(place);
    }
  }
  return places;
}

// By place: how a small turn of the camera about its axes moves the image. Empty where there is
// none.
using Turns = std::vector<std::optional<Eigen::Matrix<double, 2, 3>>>;
Turns turns_of(const std::vector<Place>& places, const Projection& lens) {
  Turns turns;
  for (const Place& place : places) {
    turns.emplace_back();
    if (!place.ray) continue;
    const ImagePoint here = lens.project(*place.ray);
    Eigen::Matrix<double, 2, 3> by_turn;
    bool seen = here.visible;
    for (int axis = 0; axis < 3 && seen; ++axis) {
      constexpr double kTurn_rad = 1e-6;
      Vec3 about(0.0);
      about[axis] = 1;
      const ImagePoint there = lens.project(rotation_about(about, kTurn_rad) * *place.ray);
      seen = there.visible;
      by_turn.col(axis) = Two(there.u - here.u, there.v - here.v) / kTurn_rad;
    }
    if (seen) turns.back() = by_turn;
  }
  return turns;
}

// Takes the turn out that makes the sum of squares smallest; returns it.
Eigen::Vector3d take_turn_out(const Turns& turns, std::vector<std::optional<Two>>& moved) {
  Eigen::Matrix3d normal = 1e-12 * Eigen::Matrix3d::Identity();
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  for (size_t i = 0; i < moved.size(); ++i) {
    if (!moved[i] || !turns[i]) continue;
    normal += turns[i]->transpose() * *turns[i];
    right += turns[i]->transpose() * *moved[i];
  }
  // Three unknowns: by Cramer's rule.
  const double det = normal.col(0).dot(normal.col(1).cross(normal.col(2)));
  Eigen::Vector3d turn(right.dot(normal.col(1).cross(normal.col(2))),
                       normal.col(0).dot(right.cross(normal.col(2))),
                       normal.col(0).dot(normal.col(1).cross(right)));
  turn = det != 0 ? Eigen::Vector3d(turn / det) : Eigen::Vector3d::Zero();
  for (size_t i = 0; i < moved.size(); ++i) {
    if (moved[i] && turns[i]) *moved[i] -= *turns[i] * turn;
  }
  return turn;
}

std::vector<std::optional<Two>> shifts(const std::vector<Place>& places, const Projection& other,
                                       const Mat3& turned) {
  std::vector<std::optional<Two>> moved;
  for (const Place& place : places) {
    moved.emplace_back();
    if (!place.ray) continue;
    const ImagePoint there = other.project(turned * *place.ray);
    if (there.visible) moved.back() = Two(there.u - place.u, there.v - place.v);
  }
  return moved;
}

size_t largest_cell(const LensMap& map) {
  size_t best = 0;
  double most = -1;
  for (size_t i = 0; i < map.size_px.size(); ++i) {
    if (map.size_px[i] > most) most = map.size_px[i], best = i;
  }
  return best;
}

LensMap error_map(const Assessment& assessment, const std::string& camera, int width_px,
                  int height_px) {
  LensMap map = empty_map(camera, width_px, height_px);
  const Projection lens(effects::model_of(assessment.model, camera), width_px, height_px);
  const std::vector<Place> places = places_of(map, lens);
  const Turns turns = turns_of(places, lens);
  const auto& unknowns = assessment.unknowns;
  std::vector<std::vector<std::optional<Two>>> slopes;
  for (const Unknown& unknown : unknowns) {
    const effects::ModelEffect& effect = *assessment.model.find(unknown.effect);
    const effects::Parameter& parameter = effect.definition->parameters[unknown.parameter];
    const double value = effect.parameters[unknown.parameter].value;
    const double step = 1e-5 * std::max(parameter.scale, std::abs(value));
    Model there = assessment.model;
    there.set_value(unknown.effect, unknown.parameter, value + step);
    const Projection other(effects::model_of(there, camera), width_px, height_px);
    auto moved = shifts(places, other, Mat3(1.0));
    for (auto& shift : moved) {
      if (shift) *shift /= step;
    }
    take_turn_out(turns, moved);
    slopes.push_back(std::move(moved));
  }
  const auto n = static_cast<Eigen::Index>(unknowns.size());
  const bool known = assessment.fit.covariance.size() == unknowns.size() * unknowns.size();
  for (size_t i = 0; i < places.size(); ++i) {
    Eigen::MatrixXd by(2, n);
    bool seen = places[i].ray.has_value() && known;
    for (Eigen::Index k = 0; k < n && seen; ++k) {
      const auto& shift = slopes[static_cast<size_t>(k)][i];
      seen = shift.has_value();
      if (seen) by.col(k) = *shift;
    }
    if (!seen) {
      map.size_px.push_back(NAN);
      continue;
    }
    const Eigen::Map<const Eigen::MatrixXd> covariance(assessment.fit.covariance.data(), n, n);
    map.size_px.push_back(std::sqrt(std::max(0.0, (by * covariance * by.transpose()).trace())));
  }
  return map;
}

LensMap difference_map(const Model& a, const Model& b, const std::string& camera, int width_px,
                       int height_px) {
  LensMap map = empty_map(camera, width_px, height_px);
  const Projection first(effects::model_of(a, camera), width_px, height_px);
  const Projection second(effects::model_of(b, camera), width_px, height_px);
  const std::vector<Place> places = places_of(map, first);
  const Turns turns = turns_of(places, second);
  Mat3 turned(1.0);
  for (int round = 0; round < 6; ++round) {
    auto moved = shifts(places, second, turned);
    const Eigen::Vector3d turn = take_turn_out(turns, moved);
    const double angle = turn.norm();
    if (angle < 1e-12) break;
    turned = rotation_about(Vec3(turn[0], turn[1], turn[2]) / angle, -angle) * turned;
  }
  for (const auto& shift : shifts(places, second, turned)) {
    map.du_px.push_back(shift ? (*shift)[0] : NAN);
    map.dv_px.push_back(shift ? (*shift)[1] : NAN);
    map.size_px.push_back(shift ? shift->norm() : NAN);
  }
  return map;
}

nlohmann::json map_json(const LensMap& map, const std::string& stage, const std::string& title) {
  nlohmann::json values = nlohmann::json::array();
  for (const double size : map.size_px) values.push_back(finite_or_null<nlohmann::json>(size));
  nlohmann::json json = {{"stage", stage},
                         {"title", title},
                         {"unit", "px"},
                         {"columns", map.columns},
                         {"rows", map.rows},
                         {"width_px", map.width_px},
                         {"height_px", map.height_px},
                         {"values", std::move(values)}};
  if (!map.camera.empty()) json["camera"] = map.camera;
  return json;
}

nlohmann::ordered_json difference_json(const LensMap& map) {
  const auto list = [](const std::vector<double>& values) {
    nlohmann::ordered_json all = nlohmann::ordered_json::array();
    for (const double value : values) all.push_back(finite_or_null<nlohmann::ordered_json>(value));
    return all;
  };
  nlohmann::ordered_json json;
  if (!map.camera.empty()) json["camera"] = map.camera;
  json["columns"] = map.columns, json["rows"] = map.rows;
  json["width_px"] = map.width_px, json["height_px"] = map.height_px;
  json["median_px"] = finite_or_null<nlohmann::ordered_json>(map.median_px());
  json["largest_px"] = finite_or_null<nlohmann::ordered_json>(map.largest_px());
  json["du_px"] = list(map.du_px), json["dv_px"] = list(map.dv_px);
  return json;
}

std::string difference_text(const LensMap& map, const std::string& a, const std::string& b) {
  const auto seen = std::count_if(map.size_px.begin(), map.size_px.end(),
                                  [](double size) { return std::isfinite(size); });
  const std::string whose = map.camera.empty() ? "" : fmt::format("camera {}: ", map.camera);
  if (map.largest_px() < kLeastShift_px)
    return fmt::format("{}{} and {} agree: no place differs by {:g} px\n", whose, a, b,
                       kLeastShift_px);
  std::string text = fmt::format(
      "{}{} and {}: half of the image differs by more than {:.3g} px, at most by {:.3g} px at "
      "column "
      "{:.0f}, row {:.0f} (the turn of the camera that brings them nearest is taken out)\n",
      whose, a, b, map.median_px(), map.largest_px(), map.largest_u_px(), map.largest_v_px());
  if (static_cast<size_t>(seen) < map.size_px.size())
    text += fmt::format(
        "{}{:.0f} % of the image has no ray in one of them\n", whose,
        100.0 * (1 - static_cast<double>(seen) / static_cast<double>(map.size_px.size())));
  // What the middle column and row of cells show, for a look in the terminal.
  text += "difference in px over the image, every fourth cell:\n";
  for (int r = 0; r < map.rows; r += 4) {
    for (int c = 0; c < map.columns; c += 4) {
      const double size = map.size_px[static_cast<size_t>(r) * map.columns + c];
      text += std::isfinite(size) ? fmt::format("{:9.3g}", size) : fmt::format("{:>9}", "-");
    }
    text += "\n";
  }
  return text;
}

}  // namespace

double LensMap::median_px() const {
  std::vector<double> known;
  std::copy_if(size_px.begin(), size_px.end(), std::back_inserter(known),
               [](double x) { return std::isfinite(x); });
  if (known.empty()) return NAN;
  std::nth_element(known.begin(), known.begin() + known.size() / 2, known.end());
  return known[known.size() / 2];
}

double LensMap::largest_px() const {
  return size_px.empty() ? NAN : size_px[largest_cell(*this)];
}

double LensMap::largest_u_px() const {
  return (static_cast<double>(largest_cell(*this) % columns) + 0.5) * width_px / columns - 0.5;
}

double LensMap::largest_v_px() const {
  return (static_cast<double>(largest_cell(*this) / columns) + 0.5) * height_px / rows - 0.5;
}

std::vector<LensMap> error_maps(const Assessment& assessment, int width_px, int height_px) {
  std::vector<LensMap> maps;
  for (const std::string& camera : effects::cameras_with_lenses(assessment.model))
    maps.push_back(error_map(assessment, camera, width_px, height_px));
  return maps;
}

std::vector<LensMap> difference_maps(const Model& a, const Model& b, int width_px, int height_px) {
  std::vector<std::string> cameras = effects::cameras_with_lenses(a);
  const std::vector<std::string> of_b = effects::cameras_with_lenses(b);
  if (cameras != of_b) {
    // What one of them says of all cameras is held against each that the other names.
    for (const std::string& camera : of_b) {
      if (std::find(cameras.begin(), cameras.end(), camera) == cameras.end())
        cameras.push_back(camera);
    }
    const auto of_all = [](const Model& model) {
      return effects::has_base(effects::model_of(model, ""), effects::Base::projection);
    };
    if (!of_all(a) || !of_all(b)) std::erase(cameras, "");
  }
  std::vector<LensMap> maps;
  for (const std::string& camera : cameras)
    maps.push_back(difference_map(a, b, camera, width_px, height_px));
  return maps;
}

nlohmann::json maps_json(const std::vector<LensMap>& maps, const std::string& stage,
                         const std::string& title) {
  if (maps.size() == 1) return map_json(maps.front(), stage, title);
  nlohmann::json all = nlohmann::json::array();
  for (const LensMap& map : maps) all.push_back(map_json(map, stage, title));
  return all;
}

std::string models_json(const std::vector<LensMap>& maps, const std::string& a,
                        const std::string& b) {
  nlohmann::ordered_json json = {{"format", "seam-models/1"}, {"models", {a, b}}};
  for (size_t i = 0; i < maps.size(); ++i) {
    if (i == 0)
      json.update(difference_json(maps[i]));
    else
      json["other_cameras"].push_back(difference_json(maps[i]));
  }
  return json.dump(1) + "\n";
}

std::string models_text(const std::vector<LensMap>& maps, const std::string& a,
                        const std::string& b) {
  std::string text;
  for (const LensMap& map : maps) text += difference_text(map, a, b);
  return text;
}

}  // namespace seam::measurement
