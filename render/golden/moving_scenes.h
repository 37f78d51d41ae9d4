// Scenes in motion on which renderers are compared.
#pragma once

#include <string>
#include <vector>

#include "render/test_scenes.h"

namespace seam::render::testing {

struct Case {
  const char* name;
  double kappa;
  double exposure_s;
  MovingScene scene;
};

// A ball, beacons, a wall, a goal post, lines painted on carpet, and a robot of capsules and boxes.
inline std::vector<Primitive> room(double ball_x, double ball_y, double walk_s) {
  std::vector<Primitive> all = {ground({0, 0, 0}, 4.2, 2.7, {0.05, 0.35, 0.08}),
                                ground({1.2, 0, 0}, 0.025, 2.6, {0.8, 0.8, 0.8}),
                                ground({1.0, 0.3, 0}, 1.5, 0.025, {0.8, 0.8, 0.8}),
                                {.shape = Shape::rectangle,
                                 .X_WO = {Mat3(0, -1, 0, 0, 0, 1, -1, 0, 0), {2.1, 0, 0.15}},
                                 .size = {2.7, 0.3, 0},
                                 .rgb = {0.75, 0.75, 0.7}},
                                sphere({ball_x, ball_y, 0.042}, 0.042, {0.9, 0.3, 0.02}),
                                upright_cylinder({1.2, 0.6, 0}, 0.05, 0.4, {0.9, 0.4, 0.5}),
                                upright_cylinder({1.4, -0.5, 0}, 0.05, 0.4, {0.9, 0.85, 0.1}),
                                box({1.7, 0.15, 0.15}, {0.1, 0.6, 0.3}, 0.2, {0.2, 0.6, 0.9})};
  // A robot that walks to the left, its legs swinging.
  const double y = -0.25 + 0.25 * walk_s;
  const double swing = 0.5 * std::sin(12 * walk_s);
  all.push_back(box({0.9, y, 0.14}, {0.15, 0.26, 0.09}, 0.3, {0.3, 0.3, 0.32}));
  all.push_back(sphere({0.9, y + 0.17, 0.22}, 0.05, {0.7, 0.05, 0.05}));
  for (const double side : {-1.0, 1.0}) {
    for (const double front : {-1.0, 1.0}) {
      const Vec3 hip(0.9 + 0.06 * side, y + 0.1 * front, 0.12);
      const Vec3 knee = hip + Vec3(0, 0.06 * std::sin(swing * side * front), -0.06);
      all.push_back(capsule(hip, knee, 0.018, {0.6, 0.05, 0.05}));
      all.push_back(capsule(knee, {knee.x, knee.y - 0.02, 0.018}, 0.016, {0.35, 0.35, 0.35}));
    }
  }
  return all;
}

inline Pose head(double pan_rad, double tilt_up_rad) {
  return head_camera(0.22, pan_rad, tilt_up_rad, 0.0666);
}

inline std::vector<Case> cases() {
  std::vector<Case> all;
  const auto still = [](double) { return room(0.8, 0.1, 0); };
  all.push_back({"swinging head",
                 0,
                 0.005,
                 {[](double t) { return head(5.236 * (t - 0.02), -0.2); }, still}});
  all.push_back({"fast tilt",
                 0,
                 0.005,
                 {[](double t) { return head(0.05, -0.2 + 2.1 * (t - 0.02)); }, still}});
  all.push_back({"rolling ball",
                 0,
                 0.005,
                 {[](double) { return head(0, -0.2); },
                  [](double t) { return room(0.5, -0.1 + 2 * t, 0); }}});
  all.push_back({"second robot walking",
                 0,
                 0.005,
                 {[](double) { return head(-0.1, -0.15); },
                  [](double t) { return room(0.8, 0.4, t + 0.3); }}});
  all.push_back({"strong distortion",
                 -0.35,
                 0.005,
                 {[](double t) { return head(1.5 * (t - 0.02), -0.2); }, still}});
  all.push_back({"exposure of 1/50 s",
                 0,
                 0.02,
                 {[](double t) { return head(3.0 * (t - 0.02), -0.2); }, still}});
  Case lambert{
      "Lambert shading", 0, 0.005, {[](double t) { return head(2.0 * (t - 0.02), -0.2); }, still}};
  lambert.scene.lighting = {.lambert = true,
                            .direction_W = Vec3(0.3, 0.2, 1) / std::sqrt(1.13),
                            .ambient = 0.4,
                            .diffuse = 0.6};
  all.push_back(lambert);
  return all;
}

inline effects::Model model_for(const Case& c, double sigma_px) {
  std::string text =
      "  pinhole: {fx_px: 161.9, fy_px: 162.5, cx_px: 88.5, cy_px: 71.5}\n  rolling_shutter: "
      "{line_delay_s: 2.78e-4}\n";
  text += "  exposure: {exposure_s: " + std::to_string(c.exposure_s) + "}\n";
  if (c.kappa != 0) text += "  radial_distortion: {kappa: " + std::to_string(c.kappa) + "}\n";
  if (sigma_px > 0) text += "  lens_blur: {sigma_px: " + std::to_string(sigma_px) + "}\n";
  return model_of(text);
}

}  // namespace seam::render::testing
