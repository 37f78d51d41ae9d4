#include "render/colour/colour_table.h"

#include <fmt/format.h>

#include <algorithm>

#include "sim_core/base/error.h"

namespace seam::render {
namespace {

uint8_t read_byte(const ConfigNode& node) {
  return static_cast<uint8_t>(node.integer(0, 255));
}

// The least and greatest of 256 values that leave `outliers` of the count outside on each side.
std::pair<int, int> trimmed_range(const uint32_t* counts, double outliers) {
  uint64_t total = 0;
  for (int i = 0; i < 256; ++i) total += counts[i];
  const auto spare = static_cast<uint64_t>(outliers * static_cast<double>(total));
  int low = 0, high = 255;
  for (uint64_t sum = counts[0]; low < 255 && sum <= spare;) sum += counts[++low];
  for (uint64_t sum = counts[255]; high > 0 && sum <= spare;) sum += counts[--high];
  return {low, high};
}

}  // namespace

int colour_channel(Label label) {
  switch (label) {
    case Label::ball:
      return 0;
    case Label::goal_yellow:
    case Label::beacon_yellow:
      return 1;
    case Label::goal_skyblue:
    case Label::beacon_skyblue:
      return 2;
    case Label::beacon_pink:
      return 3;
    case Label::beacon_green:
      return 4;
    case Label::carpet:
      return 5;
    case Label::robot_red:
      return 6;
    case Label::robot_blue:
      return 7;
    default:
      return -1;
  }
}

ColourTable ColourTable::from_file(const std::filesystem::path& path) {
  return from_config(ConfigNode::from_file(path));
}

ColourTable ColourTable::from_config(const ConfigNode& root) {
  root.at("format").choice({"seam-colour-table/1"});
  ColourTable table;
  const ConfigNode channels = root.at("channels");
  for (const std::string& name : channels.keys()) {
    const auto found = std::find(kColourNames.begin(), kColourNames.end(), name);
    if (found == kColourNames.end()) {
      channels.at(name).fail(
          fmt::format("unknown channel '{}'{}", name,
                      suggestion_for(name, {kColourNames.begin(), kColourNames.end()})));
    }
    Segments& segments = table.channels_[found - kColourNames.begin()];
    for (const ConfigNode& line : channels.at(name).items()) {
      const std::vector<ConfigNode> numbers = line.items();
      if (numbers.size() != 5) line.fail("expected [segment, cr_min, cr_max, cb_min, cb_max]");
      const int64_t segment = numbers[0].integer(0, kLumaSegments - 1);
      segments[segment] = {read_byte(numbers[1]), read_byte(numbers[2]), read_byte(numbers[3]),
                           read_byte(numbers[4])};
    }
  }
  root.finish();
  return table;
}

std::string ColourTable::to_yaml() const {
  std::string out =
      "# Colour detection table: for each channel, [segment of Y (Y / 8), cr_min, cr_max, cb_min, "
      "cb_max].\n"
      "format: seam-colour-table/1\nchannels:\n";
  for (int channel = 0; channel < kColourChannels; ++channel) {
    out += fmt::format("  {}:", kColourNames[channel]);
    std::string lines;
    for (int segment = 0; segment < kLumaSegments; ++segment) {
      const ColourRange& range = channels_[channel][segment];
      if (range.cr_min > range.cr_max) continue;
      lines += fmt::format("    - [{}, {}, {}, {}, {}]\n", segment, range.cr_min, range.cr_max,
                           range.cb_min, range.cb_max);
    }
    out += lines.empty() ? " []\n" : "\n" + lines;
  }
  return out;
}

void ColourTableMaker::add(std::span<const uint8_t> ycrcb, std::span<const uint8_t> labels,
                           int width_px, int height_px) {
  for (int v = 1; v + 1 < height_px; ++v) {
    for (int u = 1; u + 1 < width_px; ++u) {
      const size_t i = static_cast<size_t>(v) * width_px + u;
      bool alone = true;
      for (int dv = -1; dv <= 1; ++dv) {
        for (int du = -1; du <= 1; ++du) alone &= labels[i + dv * width_px + du] == labels[i];
      }
      const int channel = colour_channel(static_cast<Label>(labels[i]));
      if (!alone || channel < 0) continue;
      auto& counts = counts_[channel * kLumaSegments + ycrcb[3 * i] / 8];
      ++counts[ycrcb[3 * i + 1]];
      ++counts[256 + ycrcb[3 * i + 2]];
    }
  }
}

ColourTable ColourTableMaker::table(double outliers, int margin) const {
  ColourTable table;
  for (int channel = 0; channel < kColourChannels; ++channel) {
    const auto range_of = [&](int segment) {
      const auto& counts = counts_[channel * kLumaSegments + segment];
      uint64_t total = 0;
      for (int i = 0; i < 256; ++i) total += counts[i];
      ColourRange range;
      if (total == 0) return range;
      const auto [cr_low, cr_high] = trimmed_range(counts.data(), outliers);
      const auto [cb_low, cb_high] = trimmed_range(counts.data() + 256, outliers);
      const auto byte = [](int value) { return static_cast<uint8_t>(std::clamp(value, 0, 255)); };
      range = {byte(cr_low - margin), byte(cr_high + margin), byte(cb_low - margin),
               byte(cb_high + margin)};
      return range;
    };
    constexpr int kReach = 3;
    for (int segment = 0; segment < kLumaSegments; ++segment) {
      for (int away = 0; away <= kReach; ++away) {
        for (const int near : {segment - away, segment + away}) {
          if (near < 0 || near >= kLumaSegments) continue;
          ColourRange& range = table.channel(channel)[segment];
          if (range.cr_min > range.cr_max) range = range_of(near);
        }
      }
    }
  }
  return table;
}

}  // namespace seam::render
