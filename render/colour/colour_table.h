// The colour detection table of OPEN-R's imager: for each of 8 channels and each of 32 segments of
// Y (Y / 8), the ranges of Cr and Cb that belong to the channel's colour.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "sim_core/base/config.h"
#include "sim_core/scene/scene.h"

namespace seam::render {

inline constexpr int kColourChannels = 8;
inline constexpr int kLumaSegments = 32;

// The colours that the founding paper detects, in the order of the bits.
inline constexpr std::array<const char*, kColourChannels> kColourNames = {
    "orange", "yellow", "skyblue", "pink", "green_beacon", "green_carpet", "red", "dark_blue"};

// Inclusive; nothing belongs where a min is above its max.
struct ColourRange {
  uint8_t cr_min = 255, cr_max = 0, cb_min = 255, cb_max = 0;
  bool operator==(const ColourRange&) const = default;
};

class ColourTable {
 public:
  using Segments = std::array<ColourRange, kLumaSegments>;

  // A file of format seam-colour-table/1; throws InputError with file, line and key.
  static ColourTable from_file(const std::filesystem::path& path);
  static ColourTable from_config(const ConfigNode& root);
  std::string to_yaml() const;

  const Segments& channel(int index) const { return channels_[index]; }
  Segments& channel(int index) { return channels_[index]; }

 private:
  std::array<Segments, kColourChannels> channels_{};
};

// Makes a table from frames whose every pixel has a known label.
class ColourTableMaker {
 public:
  // Pixels whose neighbours have another label are left out: they mix colours.
  void add(std::span<const uint8_t> ycrcb, std::span<const uint8_t> labels, int width_px,
           int height_px);
  // Ranges hold all but `outliers` of a channel's pixels on each side, widened by `margin`;
  // segments without pixels take the range of the nearest that has them, up to three away.
  ColourTable table(double outliers = 0.005, int margin = 2) const;

 private:
  // Of each channel and segment: how many pixels had each Cr, each Cb.
  std::vector<std::array<uint32_t, 512>> counts_ =
      std::vector<std::array<uint32_t, 512>>(kColourChannels * kLumaSegments);
};

// The channel of a label's colour, -1 for none.
int colour_channel(Label label);

}  // namespace seam::render
