// What the camera of a model would show: a chessboard between two posts, from a head that turns.
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <vector>

#include "effects/model.h"

namespace seam::tools {

struct SeeSettings {
  int width_px = 0, height_px = 0;  // Of the camera.
  double head_rate_radps = 0;       // To the left.
  // For a slider that moves: fewer rays, and of large images fewer pixels.
  bool coarse = false;
};

struct SeenFrame {
  int width_px = 0, height_px = 0;
  std::vector<uint8_t> rgb;  // Row-major, 8 bits.
};

// Throws InputError where the model gives no image of this size.
SeenFrame see(const effects::Model& model, const SeeSettings& settings);

// Of the model's parameters those that are given, as {EFFECT: {PARAMETER: {value}}}.
void take_values(effects::Model& model, const nlohmann::json& effects);

// Sets parameters, as {EFFECT: {PARAMETER: VALUE}}; an effect that is absent is added. Throws
// UsageError for an unknown name and a value that is out of bounds.
void change_parameters(effects::Model& model, const nlohmann::json& changes);

// Effects that show in images, those of the model first: [{name, in_model, help, parameters:
// [{name, value, low, high, help}]}], where a slider may go from low to high.
nlohmann::json sliders_json(const effects::Model& model);

}  // namespace seam::tools
