// Plain images and PNG files (libpng).
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace seam {

// Row-major, channels interleaved, (0, 0) the top-left pixel. Samples are 0..2^bits - 1.
struct Image {
  int width_px = 0;
  int height_px = 0;
  int channels = 1;  // 1 grey, 3 RGB.
  int bits = 8;      // 8 or 16: what the file holds.
  std::vector<uint16_t> samples;

  uint16_t& at(int u, int v, int channel) {
    return samples[(static_cast<size_t>(v) * width_px + u) * channels + channel];
  }
  uint16_t at(int u, int v, int channel) const {
    return samples[(static_cast<size_t>(v) * width_px + u) * channels + channel];
  }
};

// Grey or RGB, 8 or 16 bits; throws InputError for anything else, damaged files, or more than
// 64 million pixels.
Image read_png(const std::filesystem::path& path);
// The same of a file's bytes; `name` is what errors call it.
Image decode_png(std::string bytes, const std::string& name);

// A picture's size and form: an Image without its samples.
using PngHeader = Image;
// The same row by row, for those that keep less of it: `begin` is called with what the header says,
// before memory is taken for pixels, then `row` with each row's bytes, samples of 16 bits with the
// higher byte first. Either may throw.
void read_png_rows(std::string_view bytes, const std::string& name,
                   const std::function<void(const PngHeader&)>& begin,
                   const std::function<void(std::span<const uint8_t>)>& row);

// The bytes of a PNG file.
std::string encode_png(const Image& image);

// Written to a temporary, then renamed.
void write_png(const std::filesystem::path& path, const Image& image);

}  // namespace seam
