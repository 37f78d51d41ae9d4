#include <csetjmp>
#include <cstddef>
#include <cstdio>

// Needs the types of the two above.
#include <jpeglib.h>

#include "render/assets/assets.h"
#include "sim_core/base/error.h"
#include "sim_core/base/image.h"

namespace seam::render {
namespace {

// A picture in several scans is held whole until the last of them, 6 bytes a pixel and more.
constexpr uint64_t kCostOfScans = 3;
constexpr int kMostScans = 100;

struct JpegErrors {
  jpeg_error_mgr manager;
  std::jmp_buf away;
  char message[JMSG_LENGTH_MAX];
};

void give_up(j_common_ptr info) {
  auto* const errors = reinterpret_cast<JpegErrors*>(info->err);
  errors->manager.format_message(info, errors->message);
  std::longjmp(errors->away, 1);
}
void say_nothing(j_common_ptr, int) {}

// Each scan goes over the whole picture, and a scan may be a few bytes long.
void count_scans(j_common_ptr info) {
  const auto* const decompress = reinterpret_cast<j_decompress_ptr>(info);
  if (decompress->input_scan_number <= kMostScans) return;
  auto* const errors = reinterpret_cast<JpegErrors*>(info->err);
  std::snprintf(errors->message, sizeof errors->message, "more than %d scans", kMostScans);
  std::longjmp(errors->away, 1);
}

// Fills the picture; false where the bytes are no whole JPEG. No object with a destructor may be
// made here, for longjmp skips it.
bool decode_rows(jpeg_decompress_struct& info, JpegErrors& errors, Picture& picture) {
  if (setjmp(errors.away) != 0) return false;
  info.out_color_space = JCS_RGB;
  jpeg_start_decompress(&info);
  while (info.output_scanline < info.output_height) {
    JSAMPROW row = &picture.rgb[size_t{3} * info.output_scanline * info.output_width];
    jpeg_read_scanlines(&info, &row, 1);
  }
  jpeg_finish_decompress(&info);
  return true;
}
bool read_header(jpeg_decompress_struct& info, JpegErrors& errors, jpeg_progress_mgr& progress,
                 const std::string& bytes) {
  if (setjmp(errors.away) != 0) return false;
  jpeg_create_decompress(&info);
  progress.progress_monitor = count_scans;
  info.progress = &progress;
  jpeg_mem_src(&info, reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size());
  jpeg_read_header(&info, TRUE);
  return true;
}

Picture decode_jpeg(const std::string& bytes, const std::string& name, AssetLimits& limits) {
  jpeg_decompress_struct info{};
  JpegErrors errors{};
  jpeg_progress_mgr progress{};
  info.err = jpeg_std_error(&errors.manager);
  errors.manager.error_exit = give_up;
  errors.manager.emit_message = say_nothing;
  struct Cleanup {
    jpeg_decompress_struct& info;
    ~Cleanup() { jpeg_destroy_decompress(&info); }
  } const cleanup{info};
  const auto fail = [&] {
    throw InputError(fmt::format("{}: not a readable JPEG: {}", name, errors.message));
  };
  if (!read_header(info, errors, progress, bytes)) fail();
  limits.take_picture(info.image_width, info.image_height,
                      jpeg_has_multiple_scans(&info) ? kCostOfScans : 1, name);
  Picture picture{static_cast<int>(info.image_width), static_cast<int>(info.image_height), {}};
  picture.rgb.resize(size_t{3} * info.image_width * info.image_height);
  if (!decode_rows(info, errors, picture)) fail();
  return picture;
}

}  // namespace

Picture decode_picture(const std::string& bytes, const std::string& name, AssetLimits& limits) {
  if (bytes.starts_with("\xff\xd8")) return decode_jpeg(bytes, name, limits);
  if (!bytes.starts_with("\x89PNG"))
    throw InputError(fmt::format("{}: found neither PNG nor JPEG", name));
  Picture picture;
  size_t channels = 0, bytes_a_sample = 0;
  uint8_t* out = nullptr;
  read_png_rows(
      bytes, name,
      [&](const PngHeader& header) {
        limits.take_picture(static_cast<uint64_t>(header.width_px),
                            static_cast<uint64_t>(header.height_px), 1, name);
        picture = {header.width_px, header.height_px, {}};
        channels = static_cast<size_t>(header.channels);
        bytes_a_sample = header.bits == 16 ? 2 : 1;
        picture.rgb.resize(size_t{3} * header.width_px * header.height_px);
        out = picture.rgb.data();
      },
      [&](std::span<const uint8_t> row) {
        for (size_t u = 0; u < static_cast<size_t>(picture.width_px); ++u) {
          const uint8_t* const pixel = &row[u * channels * bytes_a_sample];
          for (size_t c = 0; c < 3; ++c) *out++ = pixel[channels == 3 ? c * bytes_a_sample : 0];
        }
      });
  return picture;
}

void AssetLimits::take_picture(uint64_t width_px, uint64_t height_px, uint64_t cost,
                               const std::string& name) {
  const uint64_t most = kMostTexturePixels;
  if (width_px < 1 || height_px < 1 || width_px > most || height_px > most)
    throw InputError(fmt::format("{}: found a picture of {}x{} pixels, expected 1 to {} a side",
                                 name, width_px, height_px, most));
  const uint64_t pixels = width_px * height_px;
  if (cost * pixels > kMostPixels - pixels_)
    throw InputError(fmt::format(
        "{}: found a picture of {}x{} pixels{}, with {:.3g} million in the pictures before it, "
        "expected at most {} million in all pictures of a scene: make them smaller",
        name, width_px, height_px,
        cost > 1 ? fmt::format(" in several scans, which take {} times the memory", cost) : "",
        1e-6 * static_cast<double>(pixels_), kMostPixels / 1'000'000));
  pixels_ += pixels;
}

void AssetLimits::take_triangles(uint64_t count) {
  triangles_ += count;
  if (triangles_ > kMostTriangles)
    throw InputError(fmt::format("found {} triangles, expected at most {} in all meshes of a scene",
                                 triangles_, kMostTriangles));
}

void AssetLimits::take_bytes(uint64_t count) {
  bytes_ += count;
  if (bytes_ > kMostBytes)
    throw InputError(fmt::format(
        "found files of {} bytes, expected at most {} in all meshes and pictures of a scene",
        bytes_, kMostBytes));
}

}  // namespace seam::render
