#include <gtest/gtest.h>

#include "render/colour/colour_space.h"
#include "render/colour/colour_table.h"
#include "sim_core/base/error.h"

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
  EXPECT_EQ(table.bits_of(100, 155, 105), 0b1001);
  EXPECT_EQ(table.bits_of(100, 170, 105), 0b0001);
  EXPECT_EQ(table.bits_of(110, 155, 105), 0);  // The next segment of Y.
  EXPECT_EQ(table.bits_of(100, 139, 105), 0);
}

TEST(ColourTable, OutputIsHalfTheFrameInBothDirections) {
  const ColourTable table;
  for (const int width : {176, 178}) {
    const Detections out = table.detect(std::vector<uint8_t>(size_t(width) * 144 * 3), width, 144);
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
  const ColourTable table = maker.table();
  EXPECT_EQ(table.bits_of(121, 203, 60), 1u << 0);
  EXPECT_EQ(table.bits_of(60, 100, 110), 1u << 5);
  EXPECT_EQ(table.bits_of(121, 128, 128), 0);
}

}  // namespace
}  // namespace seam::render
