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

constexpr uint64_t kMostPixels = 64'000'000;

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

void check_size(uint64_t width, uint64_t height, const std::string& name) {
  if (width < 1 || height < 1 || width > kMostTexturePixels || height > kMostTexturePixels ||
      width * height > kMostPixels) {
    throw InputError(
        fmt::format("{}: found a picture of {}x{} pixels, expected at most {} a side and {} in all",
                    name, width, height, kMostTexturePixels, kMostPixels));
  }
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
bool read_header(jpeg_decompress_struct& info, JpegErrors& errors, const std::string& bytes) {
  if (setjmp(errors.away) != 0) return false;
  jpeg_create_decompress(&info);
  jpeg_mem_src(&info, reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size());
  jpeg_read_header(&info, TRUE);
  return true;
}

Picture decode_jpeg(const std::string& bytes, const std::string& name) {
  jpeg_decompress_struct info{};
  JpegErrors errors{};
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
  if (!read_header(info, errors, bytes)) fail();
  check_size(info.image_width, info.image_height, name);
  Picture picture{static_cast<int>(info.image_width), static_cast<int>(info.image_height), {}};
  picture.rgb.resize(size_t{3} * info.image_width * info.image_height);
  if (!decode_rows(info, errors, picture)) fail();
  return picture;
}

}  // namespace

Picture decode_picture(const std::string& bytes, const std::string& name) {
  if (bytes.starts_with("\xff\xd8")) return decode_jpeg(bytes, name);
  if (!bytes.starts_with("\x89PNG"))
    throw InputError(fmt::format("{}: found neither PNG nor JPEG", name));
  const Image image = decode_png(bytes, name);
  check_size(static_cast<uint64_t>(image.width_px), static_cast<uint64_t>(image.height_px), name);
  Picture picture{image.width_px, image.height_px, {}};
  for (int v = 0; v < image.height_px; ++v) {
    for (int u = 0; u < image.width_px; ++u) {
      for (int c = 0; c < 3; ++c) {
        const uint16_t sample = image.at(u, v, image.channels == 3 ? c : 0);
        picture.rgb.push_back(static_cast<uint8_t>(image.bits == 16 ? sample >> 8 : sample));
      }
    }
  }
  return picture;
}

}  // namespace seam::render
