#include "tools/experiments/ball_pictures.h"

#include <algorithm>
#include <optional>

#include "app/session/scenario_frames.h"
#include "render/pictures/pictures.h"
#include "sim_core/base/error.h"

namespace seam::tools {
namespace {

constexpr uint8_t kOrange = 1;  // The first colour of the detection table.
constexpr double kTakenAt_s = 2;
constexpr int kFrameTimes = 2,
              kColourTimes = 4;  // The colour layer has half the frame's rows and columns.

struct Box {
  int u_min, u_max, v_min, v_max;
};

// Of the orange pixels of the colour layer: nothing else on the field is orange.
std::optional<Box> orange_box(const Frame& frame) {
  std::optional<Box> box;
  for (int v = 0; v < frame.colours_height_px; ++v) {
    for (int u = 0; u < frame.colours_width_px; ++u) {
      if ((frame.colours[static_cast<size_t>(v) * frame.colours_width_px + u] & kOrange) == 0)
        continue;
      if (!box) box = Box{u, u, v, v};
      box = Box{std::min(box->u_min, u), std::max(box->u_max, u), box->v_min,
                std::max(box->v_max, v)};
    }
  }
  return box;
}

// A line one pixel wide just outside the box, whose sides are given in the picture's own pixels.
void frame_in_white(Image& image, const Box& box) {
  const auto dot = [&](int u, int v) {
    if (u < 0 || v < 0 || u >= image.width_px || v >= image.height_px) return;
    for (int channel = 0; channel < 3; ++channel) image.at(u, v, channel) = 255;
  };
  for (int u = box.u_min - 1; u <= box.u_max + 1; ++u) dot(u, box.v_min - 1), dot(u, box.v_max + 1);
  for (int v = box.v_min - 1; v <= box.v_max + 1; ++v) dot(box.u_min - 1, v), dot(box.u_max + 1, v);
}

// The box of the colour layer in a picture where each of its pixels is `times` as large, the first
// one at `left`, `top`.
Box scaled(const Box& box, int times, int left, int top) {
  return {left + times * box.u_min, left + times * (box.u_max + 1) - 1, top + times * box.v_min,
          top + times * (box.v_max + 1) - 1};
}

}  // namespace

void draw_ball_pictures(const std::vector<std::vector<BallPicture>>& by_camera,
                        const std::filesystem::path& file) {
  std::vector<render::Panel> panels;
  size_t columns = 1;
  for (const auto& pictures : by_camera) {
    columns = pictures.size();
    std::vector<render::Panel> detections;
    for (const BallPicture& picture : pictures) {
      app::visit_first_frame(
          picture.scenario.string(), {}, picture.robot, SimTime::from_s(kTakenAt_s),
          [&](const scheduler::FinishedFrame& finished, const render::Renderer&) {
            const Frame& frame = *finished.frame;
            Image seen = render::enlarged(render::picture_of_frame(frame), kFrameTimes);
            Image colours = render::enlarged(
                render::picture_of_detections(frame.colours, frame.colours_width_px,
                                              frame.colours_height_px),
                kColourTimes);
            if (const auto box = orange_box(frame)) {
              const int left = (seen.width_px - colours.width_px) / 2,
                        top = (seen.height_px - colours.height_px) / 2;
              frame_in_white(seen, scaled(*box, kColourTimes, left, top));
              frame_in_white(colours, scaled(*box, kColourTimes, 0, 0));
            }
            panels.push_back({picture.caption, std::move(seen)});
            detections.push_back({"colours detected", std::move(colours)});
          });
    }
    panels.insert(panels.end(), detections.begin(), detections.end());
  }
  write_png(file, render::contact_sheet(panels, static_cast<int>(columns)));
}

}  // namespace seam::tools
