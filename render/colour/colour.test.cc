#include <gtest/gtest.h>

#include <cmath>

#include "render/colour/colour_detector.h"
#include "render/colour/colour_space.h"
#include "sim_core/base/error.h"
#include "sim_core/base/random.h"

namespace seam::render {
namespace {

TEST(ColourSpace, RobotsFormulaInvertsOurs) {
  for (int r = 0; r < 256; r += 5) {
    for (int g = 0; g < 256; g += 5) {
      for (int b = 0; b < 256; b += 5) {
        const uint8_t rgb[3] = {uint8_t(r), uint8_t(g), uint8_t(b)};
        uint8_t ycrcb[3], back[3];
        rgb_to_ycrcb(rgb, ycrcb);
        ycrcb_to_rgb(ycrcb, back);
        const int cr = r - ycrcb[0], cb = b - ycrcb[0];
        if (std::abs(cr) > 127 || std::abs(cb) > 127) continue;  // Clipped to a byte.
        EXPECT_EQ(back[0], r);
        EXPECT_EQ(back[2], b);
        EXPECT_NEAR(back[1], g, 1);  // Y is rounded.
      }
    }
  }
  const uint8_t grey[3] = {77, 77, 77};
  uint8_t ycrcb[3];
  rgb_to_ycrcb(grey, ycrcb);
  EXPECT_EQ(ycrcb[0], 77);
  EXPECT_EQ(ycrcb[1], 128);
  EXPECT_EQ(ycrcb[2], 128);
}

TEST(ColourTable, APixelMayCarrySeveralBits) {
  ColourTable table;
  table.channel(0)[100 / 8] = {140, 200, 50, 120};
  table.channel(3)[100 / 8] = {150, 160, 100, 110};
  const ColourDetector colours(table);
  EXPECT_EQ(colours.bits_of(100, 155, 105), 0b1001);
  EXPECT_EQ(colours.bits_of(100, 170, 105), 0b0001);
  EXPECT_EQ(colours.bits_of(110, 155, 105), 0);  // The next segment of Y.
  EXPECT_EQ(colours.bits_of(100, 139, 105), 0);
}

// Every colour against the ranges themselves, and detections against means of their four pixels.
TEST(ColourTable, DetectionsAreThoseOfTheRanges) {
  ColourTable table;
  for (int channel = 0; channel < kColourChannels; ++channel) {
    for (int luma = 0; luma < kLumaSegments; ++luma) {
      const auto draw = [&](uint64_t k) {
        const auto stream = static_cast<uint64_t>(channel * kLumaSegments + luma);
        return static_cast<uint8_t>(256 * uniform({.seed = 5, .stream = stream}, k));
      };
      table.channel(channel)[luma] = {draw(0), draw(1), draw(2), draw(3)};  // Empty ones, too.
    }
  }
  const auto expected = [&](int y, int cr, int cb) {
    int bits = 0;
    for (int channel = 0; channel < kColourChannels; ++channel) {
      const ColourRange& range = table.channel(channel)[y / 8];
      const bool in =
          cr >= range.cr_min && cr <= range.cr_max && cb >= range.cb_min && cb <= range.cb_max;
      bits += in ? 1 << channel : 0;
    }
    return bits;
  };
  const ColourDetector colours(table);
  int wrong = 0;
  for (int y = 3; y < 256; y += 8) {
    for (int cr = 0; cr < 256; ++cr) {
      for (int cb = 0; cb < 256; ++cb)
        wrong += colours.bits_of(uint8_t(y), uint8_t(cr), uint8_t(cb)) != expected(y, cr, cb);
    }
  }
  EXPECT_EQ(wrong, 0);
  constexpr int kWidth = 178, kHeight = 145;
  std::vector<uint8_t> ycrcb;
  for (uint64_t i = 0; i < 3 * kWidth * kHeight; ++i)
    ycrcb.push_back(static_cast<uint8_t>(256 * uniform({.seed = 6, .stream = 1}, i)));
  const Detections out = colours.detect(ycrcb, kWidth, kHeight);
  for (int v = 0; v < 72; ++v) {
    for (int u = 0; u < 88; ++u) {
      int mean[3];
      for (int c = 0; c < 3; ++c) {
        double sum = 0;
        for (const int dv : {0, 1})
          for (const int du : {0, 1})
            sum += ycrcb[3 * ((2 * v + dv) * kWidth + 1 + 2 * u + du) + c];
        mean[c] = static_cast<int>(std::floor(sum / 4 + 0.5));
      }
      ASSERT_EQ(out.bits[v * 88 + u], expected(mean[0], mean[1], mean[2])) << u << " " << v;
    }
  }
}

TEST(ColourTable, OutputIsHalfTheFrameInBothDirections) {
  const ColourDetector colours{ColourTable()};
  for (const int width : {176, 178}) {
    const Detections out =
        colours.detect(std::vector<uint8_t>(size_t(width) * 144 * 3), width, 144);
    EXPECT_EQ(out.width_px, 88);
    EXPECT_EQ(out.height_px, 72);
    EXPECT_EQ(out.bits.size(), 88u * 72);
  }
}

TEST(ColourTable, WrittenTableReadsBack) {
  ColourTable table;
  table.channel(2)[7] = {1, 2, 3, 4};
  table.channel(7)[31] = {0, 255, 128, 129};
  const ColourTable back =
      ColourTable::from_config(ConfigNode::from_text(table.to_yaml(), "table"));
  for (int channel = 0; channel < kColourChannels; ++channel)
    EXPECT_EQ(back.channel(channel), table.channel(channel));
  EXPECT_THROW(ColourTable::from_config(ConfigNode::from_text(
                   "format: seam-colour-table/1\nchannels: {orage: []}\n", "t")),
               InputError);
}

TEST(ColourTable, MakerLearnsTheColoursOfLabels) {
  ColourTableMaker maker;
  std::vector<uint8_t> ycrcb, labels;
  for (int i = 0; i < 64 * 64; ++i) {
    const bool ball = i % 64 < 32;
    labels.push_back(uint8_t(ball ? Label::ball : Label::carpet));
    ycrcb.push_back(uint8_t(ball ? 120 + i % 5 : 60));
    ycrcb.push_back(uint8_t(ball ? 200 + i % 7 : 100));
    ycrcb.push_back(uint8_t(ball ? 60 : 110));
  }
  maker.add(ycrcb, labels, 64, 64);
  const ColourDetector colours(maker.table());
  EXPECT_EQ(colours.bits_of(121, 203, 60), 1u << 0);
  EXPECT_EQ(colours.bits_of(60, 100, 110), 1u << 5);
  EXPECT_EQ(colours.bits_of(121, 128, 128), 0);
}

}  // namespace
}  // namespace seam::render
