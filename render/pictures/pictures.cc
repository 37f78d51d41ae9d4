#include "render/pictures/pictures.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "render/pictures/tiny_font.h"
#include "sim_core/base/maths.h"

namespace seam::render {
namespace {

using Bytes = std::array<uint8_t, 3>;

Image blank(int width, int height, uint16_t value) {
  Image image{.width_px = width, .height_px = height, .channels = 3};
  image.samples.assign(static_cast<size_t>(width) * height * 3, value);
  return image;
}

template <typename ColourOf>
Image painted(int width, int height, const ColourOf& colour_of) {
  Image image = blank(width, height, 0);
  for (size_t i = 0; i < image.samples.size() / 3; ++i) {
    const Bytes rgb = colour_of(i);
    for (int c = 0; c < 3; ++c) image.samples[3 * i + c] = rgb[c];
  }
  return image;
}

Bytes label_colour(uint8_t label) {
  // In the order of seam::Label.
  static constexpr std::array<Bytes, 16> kColours = {{{40, 40, 50},
                                                      {20, 110, 30},
                                                      {255, 255, 255},
                                                      {200, 200, 190},
                                                      {255, 120, 0},
                                                      {240, 220, 0},
                                                      {0, 170, 255},
                                                      {255, 110, 190},
                                                      {255, 240, 90},
                                                      {110, 210, 255},
                                                      {0, 200, 100},
                                                      {235, 235, 235},
                                                      {220, 0, 0},
                                                      {30, 30, 200},
                                                      {120, 120, 130},
                                                      {160, 90, 200}}};
  return kColours[std::min<size_t>(label, kColours.size() - 1)];
}

void paste(const Image& from, int left, int top, Image& to) {
  for (int v = 0; v < from.height_px; ++v) {
    for (int u = 0; u < from.width_px; ++u) {
      for (int c = 0; c < 3; ++c)
        to.at(left + u, top + v, c) = from.at(u, v, from.channels == 3 ? c : 0);
    }
  }
}

void write_text(const std::string& text, int left, int top, int width, Image& image) {
  int u = left;
  for (const char letter : text) {
    if (u + 5 > left + width) return;
    const int glyph = letter >= 0x20 && letter <= 0x7e ? letter - 0x20 : '?' - 0x20;
    for (int column = 0; column < 5; ++column) {
      for (int row = 0; row < 8; ++row) {
        if (!((kTinyFont[glyph][column] >> row) & 1)) continue;
        for (int c = 0; c < 3; ++c) image.at(u + column, top + row, c) = 20;
      }
    }
    u += 6;
  }
}

}  // namespace

Image picture_of(const LinearImage& image) {
  return painted(image.width_px, image.height_px, [&](size_t i) {
    Bytes rgb;
    for (int c = 0; c < 3; ++c) {
      rgb[c] = static_cast<uint8_t>(
          std::clamp(std::floor(image.planes[c][i] * 255.0 + 0.5), 0.0, 255.0));
    }
    return rgb;
  });
}

Image picture_of_frame(const Frame& frame) {
  return painted(frame.width_px, frame.height_px, [&](size_t i) {
    return Bytes{frame.rgb[3 * i], frame.rgb[3 * i + 1], frame.rgb[3 * i + 2]};
  });
}

Image picture_of_labels(const GroundTruth& truth) {
  return painted(truth.width_px, truth.height_px,
                 [&](size_t i) { return label_colour(truth.label[i]); });
}

Image picture_of_depth(const GroundTruth& truth) {
  return painted(truth.width_px, truth.height_px, [&](size_t i) {
    const float depth = truth.depth_m[i];
    const auto grey = static_cast<uint8_t>(
        std::isfinite(depth) ? std::clamp(255.0 / (1 + depth), 0.0, 255.0) : 0);
    return Bytes{grey, grey, grey};
  });
}

Image picture_of_flow(const GroundTruth& truth, double full_px) {
  return painted(truth.width_px, truth.height_px, [&](size_t i) {
    const double u = truth.flow_u_px[i], v = truth.flow_v_px[i];
    const double length = std::min(1.0, std::sqrt(u * u + v * v) / full_px);
    const double angle = maths::atan2(v, u);
    Bytes rgb;
    for (int c = 0; c < 3; ++c) {
      const double hue = 0.5 + 0.5 * maths::cos(angle - c * 2 * maths::kPi / 3);
      rgb[c] = static_cast<uint8_t>(255 * length * hue);
    }
    return rgb;
  });
}

Image picture_of_detections(const std::vector<uint8_t>& bits, int width_px, int height_px) {
  static constexpr std::array<Bytes, 8> kChannels = {{{255, 120, 0},
                                                      {240, 220, 0},
                                                      {0, 170, 255},
                                                      {255, 110, 190},
                                                      {0, 200, 100},
                                                      {20, 110, 30},
                                                      {220, 0, 0},
                                                      {40, 40, 220}}};
  return painted(width_px, height_px, [&](size_t i) {
    for (int channel = 0; channel < 8; ++channel) {
      if ((bits[i] >> channel) & 1) return kChannels[channel];
    }
    return Bytes{0, 0, 0};
  });
}

Image enlarged(const Image& image, int times) {
  Image large = blank(image.width_px * times, image.height_px * times, 0);
  for (int v = 0; v < large.height_px; ++v) {
    for (int u = 0; u < large.width_px; ++u) {
      for (int c = 0; c < 3; ++c)
        large.at(u, v, c) = image.at(u / times, v / times, image.channels == 3 ? c : 0);
    }
  }
  return large;
}

Image contact_sheet(const std::vector<Panel>& panels, int columns) {
  constexpr int kGap = 6, kCaption = 12;
  int width = 1, height = 1;
  for (const Panel& panel : panels) {
    width = std::max(width, panel.image.width_px);
    height = std::max(height, panel.image.height_px);
  }
  columns = std::clamp(columns, 1, std::max(1, static_cast<int>(panels.size())));
  const int rows = (static_cast<int>(panels.size()) + columns - 1) / columns;
  Image sheet =
      blank(columns * (width + kGap) + kGap, rows * (height + kCaption + kGap) + kGap, 245);
  for (size_t i = 0; i < panels.size(); ++i) {
    const int left = kGap + static_cast<int>(i % columns) * (width + kGap);
    const int top = kGap + static_cast<int>(i / columns) * (height + kCaption + kGap);
    paste(panels[i].image, left, top, sheet);
    write_text(panels[i].caption, left, top + height + 2, width, sheet);
  }
  return sheet;
}

}  // namespace seam::render
