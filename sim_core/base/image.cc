#include "sim_core/base/image.h"

#include <png.h>

#include <csetjmp>
#include <cstring>
#include <string>

#include "sim_core/base/error.h"
#include "sim_core/base/files.h"
#include "sim_core/base/output.h"

namespace seam {
namespace {

constexpr uint64_t kMaxPixels = 64'000'000;
constexpr uint64_t kMaxPngBytes = uint64_t{512} << 20;

struct PngBytes {
  std::string_view bytes;
  size_t position = 0;
};

void on_error(png_structp png, png_const_charp message) {
  *static_cast<std::string*>(png_get_error_ptr(png)) = message;
  png_longjmp(png, 1);
}
void on_warning(png_structp, png_const_charp) {}

void read_bytes(png_structp png, png_bytep out, size_t count) {
  auto* reader = static_cast<PngBytes*>(png_get_io_ptr(png));
  if (count > reader->bytes.size() - reader->position) png_error(png, "the file ends early");
  std::memcpy(out, reader->bytes.data() + reader->position, count);
  reader->position += count;
}

void write_bytes(png_structp png, png_bytep data, size_t count) {
  static_cast<std::string*>(png_get_io_ptr(png))
      ->append(reinterpret_cast<const char*>(data), count);
}

}  // namespace

Image read_png(const std::filesystem::path& path) {
  return decode_png(read_file(path, kMaxPngBytes), path.string());
}

namespace {

// Frees what libpng holds, whichever way is taken out.
struct PngReader {
  std::string message;
  png_structp png = png_create_read_struct(PNG_LIBPNG_VER_STRING, &message, on_error, on_warning);
  png_infop info = png_create_info_struct(png);
  ~PngReader() { png_destroy_read_struct(&png, &info, nullptr); }
};

// The two below: false with a message where libpng gives up. No object with a destructor may be
// made in them, for longjmp skips it.
bool read_header(PngReader& reader, PngBytes& bytes, PngHeader& header) {
  png_structp const png = reader.png;
  if (setjmp(png_jmpbuf(png)) != 0) return false;
  png_set_read_fn(png, &bytes, read_bytes);
  png_read_info(png, reader.info);
  header.width_px = static_cast<int>(png_get_image_width(png, reader.info));
  header.height_px = static_cast<int>(png_get_image_height(png, reader.info));
  header.bits = png_get_bit_depth(png, reader.info);
  const int colour = png_get_color_type(png, reader.info);
  if (static_cast<uint64_t>(header.width_px) * header.height_px > kMaxPixels)
    png_error(png, "more than 64 million pixels");
  if (header.bits < 8) png_set_expand_gray_1_2_4_to_8(png), header.bits = 8;
  if (colour == PNG_COLOR_TYPE_PALETTE) png_set_palette_to_rgb(png);
  if ((colour & PNG_COLOR_MASK_ALPHA) != 0) png_set_strip_alpha(png);
  png_read_update_info(png, reader.info);
  header.channels = png_get_channels(png, reader.info);
  if (header.channels != 1 && header.channels != 3) png_error(png, "expected grey or RGB");
  if (png_get_interlace_type(png, reader.info) != PNG_INTERLACE_NONE)
    png_error(png, "interlaced, expected plain rows");
  return true;
}

bool read_row(PngReader& reader, png_bytep row) {
  if (setjmp(png_jmpbuf(reader.png)) != 0) return false;
  png_read_row(reader.png, row, nullptr);
  return true;
}
bool read_end(PngReader& reader) {
  if (setjmp(png_jmpbuf(reader.png)) != 0) return false;
  png_read_end(reader.png, nullptr);
  return true;
}

}  // namespace

void read_png_rows(std::string_view bytes, const std::string& name,
                   const std::function<void(const PngHeader&)>& begin,
                   const std::function<void(std::span<const uint8_t>)>& row) {
  PngBytes source{bytes};
  PngReader reader;
  PngHeader header;
  const auto fail = [&] {
    throw InputError(fmt::format("{}: not a readable PNG: {}", name, reader.message));
  };
  if (!read_header(reader, source, header)) fail();
  begin(header);
  std::vector<png_byte> read(png_get_rowbytes(reader.png, reader.info));
  for (int v = 0; v < header.height_px; ++v) {
    if (!read_row(reader, read.data())) fail();
    row(read);
  }
  if (!read_end(reader)) fail();
}

Image decode_png(std::string bytes, const std::string& name) {
  Image image;
  read_png_rows(
      bytes, name,
      [&](const PngHeader& header) {
        image = header;
        image.samples.reserve(static_cast<size_t>(image.width_px) * image.height_px *
                              image.channels);
      },
      [&](std::span<const uint8_t> row) {
        if (image.bits == 8) {
          image.samples.insert(image.samples.end(), row.begin(), row.end());
          return;
        }
        for (size_t i = 0; i + 1 < row.size(); i += 2)
          image.samples.push_back(static_cast<uint16_t>(row[i] << 8 | row[i + 1]));
      });
  return image;
}

std::string encode_png(const Image& image) {
  SEAM_CHECK(image.samples.size() ==
                 static_cast<size_t>(image.width_px) * image.height_px * image.channels,
             "{} samples", image.samples.size());
  std::string encoded, message;
  std::vector<png_byte> row;
  png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, &message, on_error, on_warning);
  png_infop info = png_create_info_struct(png);
  if (setjmp(png_jmpbuf(png)) != 0) {
    png_destroy_write_struct(&png, &info);
    throw InputError(fmt::format("a picture of {} x {} pixels cannot be encoded as PNG: {}",
                                 image.width_px, image.height_px, message));
  }
  png_set_write_fn(png, &encoded, write_bytes, nullptr);
  png_set_compression_level(png, 3);
  png_set_IHDR(png, info, image.width_px, image.height_px, image.bits,
               image.channels == 1 ? PNG_COLOR_TYPE_GRAY : PNG_COLOR_TYPE_RGB, PNG_INTERLACE_NONE,
               PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
  png_write_info(png, info);
  const size_t count = static_cast<size_t>(image.width_px) * image.channels;
  row.resize(count * (image.bits == 16 ? 2 : 1));
  for (int v = 0; v < image.height_px; ++v) {
    const uint16_t* samples = image.samples.data() + v * count;
    for (size_t i = 0; i < count; ++i) {
      if (image.bits == 16) {
        row[2 * i] = static_cast<png_byte>(samples[i] >> 8);
        row[2 * i + 1] = static_cast<png_byte>(samples[i]);
      } else {
        row[i] = static_cast<png_byte>(samples[i]);
      }
    }
    png_write_row(png, row.data());
  }
  png_write_end(png, nullptr);
  png_destroy_write_struct(&png, &info);
  return encoded;
}

void write_png(const std::filesystem::path& path, const Image& image) {
  write_file_atomically(path, encode_png(image));
}

}  // namespace seam
