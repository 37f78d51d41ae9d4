#include "measurement/imaging/image_file.h"

#include <tiffio.h>

#include <algorithm>
#include <cstdarg>
#include <cstring>
#include <memory>

#include "sim_core/base/error.h"
#include "sim_core/base/files.h"

namespace seam::measurement {
namespace {

constexpr uint64_t kMaxFileBytes = uint64_t{512} << 20;
constexpr uint64_t kMaxPixels = 64'000'000;
// What a damaged header may make the library ask for at once.
constexpr tmsize_t kMaxAllocation = tmsize_t{512} << 20;

struct TiffBytes {
  const std::string& bytes;
  uint64_t position = 0;
  std::string message;  // The first that the library gave.
};

tmsize_t read_bytes(thandle_t handle, void* out, tmsize_t count) {
  auto* file = static_cast<TiffBytes*>(handle);
  if (file->position >= file->bytes.size()) return 0;
  const auto here = static_cast<tmsize_t>(
      std::min<uint64_t>(static_cast<uint64_t>(count), file->bytes.size() - file->position));
  std::memcpy(out, file->bytes.data() + file->position, static_cast<size_t>(here));
  file->position += static_cast<uint64_t>(here);
  return here;
}
tmsize_t write_nothing(thandle_t, void*, tmsize_t) {
  return 0;
}
toff_t seek_to(thandle_t handle, toff_t offset, int whence) {
  auto* file = static_cast<TiffBytes*>(handle);
  if (whence == SEEK_SET) file->position = offset;
  if (whence == SEEK_CUR) file->position += offset;
  if (whence == SEEK_END) file->position = file->bytes.size() + offset;
  return file->position;
}
int close_nothing(thandle_t) {
  return 0;
}
toff_t size_of(thandle_t handle) {
  return static_cast<TiffBytes*>(handle)->bytes.size();
}

int on_error(TIFF*, void* user, const char*, const char* format, va_list arguments) {
  auto* file = static_cast<TiffBytes*>(user);
  char text[256];
  std::vsnprintf(text, sizeof text, format, arguments);
  if (file->message.empty()) file->message = text;
  return 1;
}
int on_warning(TIFF*, void*, const char*, const char*, va_list) {
  return 1;
}

class TiffReader {
 public:
  TiffReader(const std::string& bytes, const std::string& name) : file_{bytes}, name_(name) {
    const std::unique_ptr<TIFFOpenOptions, void (*)(TIFFOpenOptions*)> options(
        TIFFOpenOptionsAlloc(), TIFFOpenOptionsFree);
    TIFFOpenOptionsSetErrorHandlerExtR(options.get(), on_error, &file_);
    TIFFOpenOptionsSetWarningHandlerExtR(options.get(), on_warning, &file_);
    TIFFOpenOptionsSetMaxSingleMemAlloc(options.get(), kMaxAllocation);
    // `m`: never mapped; the bytes come by read_bytes, which knows their end.
    tiff_.reset(TIFFClientOpenExt(name.c_str(), "rm", &file_, read_bytes, write_nothing, seek_to,
                                  close_nothing, size_of, nullptr, nullptr, options.get()));
    if (!tiff_) fail();
  }

  Image read() {
    describe();
    image_.samples.resize(static_cast<size_t>(image_.width_px) * image_.height_px *
                          image_.channels);
    if (TIFFIsTiled(tiff_.get())) {
      read_tiles();
    } else {
      read_rows();
    }
    if (!TIFFLastDirectory(tiff_.get())) fail("several images, expected one a file");
    return std::move(image_);
  }

 private:
  [[noreturn]] void fail(const std::string& why = "") const {
    const std::string& text = why.empty() ? file_.message : why;
    throw InputError(
        fmt::format("{}: not a readable TIFF: {}", name_, text.empty() ? "it is damaged" : text));
  }

  uint16_t tag(uint32_t which) const {
    uint16_t value = 0;
    TIFFGetFieldDefaulted(tiff_.get(), which, &value);
    return value;
  }

  void describe() {
    uint32_t width = 0, height = 0;
    TIFFGetField(tiff_.get(), TIFFTAG_IMAGEWIDTH, &width);
    TIFFGetField(tiff_.get(), TIFFTAG_IMAGELENGTH, &height);
    const uint16_t bits = tag(TIFFTAG_BITSPERSAMPLE), channels = tag(TIFFTAG_SAMPLESPERPIXEL);
    if (width == 0 || height == 0 || width > kMaxPixels || height > kMaxPixels ||
        uint64_t{width} * height > kMaxPixels)
      fail(fmt::format("{} x {} pixels, expected 1 to 64 million", width, height));
    if (bits != 8 && bits != 16)
      fail(fmt::format("{} bits a sample, expected 8 or 16 (12 bits stand in files of 16)", bits));
    if (channels != 1 && channels != 3)
      fail(fmt::format("{} samples a pixel, expected 1 (grey) or 3 (RGB)", channels));
    if (channels == 3 && tag(TIFFTAG_PLANARCONFIG) != PLANARCONFIG_CONTIG)
      fail("a plane for each colour, expected the colours of a pixel side by side");
    const uint16_t expected = channels == 1 ? PHOTOMETRIC_MINISBLACK : PHOTOMETRIC_RGB;
    if (uint16_t meaning = 0;
        TIFFGetField(tiff_.get(), TIFFTAG_PHOTOMETRIC, &meaning) && meaning != expected)
      fail(fmt::format("photometric interpretation {}, expected {} (black is 0)", meaning,
                       expected));
    if (tag(TIFFTAG_SAMPLEFORMAT) != SAMPLEFORMAT_UINT)
      fail("samples that are no whole numbers from 0 on");
    image_ = {.width_px = static_cast<int>(width),
              .height_px = static_cast<int>(height),
              .channels = channels,
              .bits = bits};
  }

  // `count` samples of the library's buffer, in this machine's byte order.
  void copy(const unsigned char* from, size_t count, uint16_t* to) const {
    if (image_.bits == 16) {
      std::memcpy(to, from, 2 * count);
    } else {
      std::copy(from, from + count, to);
    }
  }

  void read_rows() {
    const size_t row = static_cast<size_t>(image_.width_px) * image_.channels;
    const auto bytes = static_cast<size_t>(TIFFScanlineSize64(tiff_.get()));
    if (bytes != row * static_cast<size_t>(image_.bits) / 8) fail("rows of another length");
    std::vector<unsigned char> buffer(bytes);
    for (int v = 0; v < image_.height_px; ++v) {
      if (TIFFReadScanline(tiff_.get(), buffer.data(), static_cast<uint32_t>(v), 0) < 0) fail();
      copy(buffer.data(), row, &image_.samples[static_cast<size_t>(v) * row]);
    }
  }

  void read_tiles() {
    uint32_t width = 0, height = 0;
    TIFFGetField(tiff_.get(), TIFFTAG_TILEWIDTH, &width);
    TIFFGetField(tiff_.get(), TIFFTAG_TILELENGTH, &height);
    const uint64_t bytes = TIFFTileSize64(tiff_.get());
    const auto channels = static_cast<size_t>(image_.channels);
    const uint64_t expected = uint64_t{width} * height * channels * image_.bits / 8;
    if (width == 0 || height == 0 || uint64_t{width} * height > kMaxPixels || bytes != expected)
      fail(fmt::format("tiles of {} x {}", width, height));
    std::vector<unsigned char> buffer(bytes);
    const size_t tile_row = width * channels * static_cast<size_t>(image_.bits) / 8;
    for (uint32_t v = 0; v < static_cast<uint32_t>(image_.height_px); v += height) {
      for (uint32_t u = 0; u < static_cast<uint32_t>(image_.width_px); u += width) {
        if (TIFFReadTile(tiff_.get(), buffer.data(), u, v, 0, 0) < 0) fail();
        const uint32_t rows = std::min(height, static_cast<uint32_t>(image_.height_px) - v);
        const uint32_t columns = std::min(width, static_cast<uint32_t>(image_.width_px) - u);
        for (uint32_t row = 0; row < rows; ++row) {
          const size_t at = (static_cast<size_t>(v + row) * image_.width_px + u) * channels;
          copy(&buffer[row * tile_row], columns * channels, &image_.samples[at]);
        }
      }
    }
  }

  TiffBytes file_;
  const std::string& name_;
  std::unique_ptr<TIFF, void (*)(TIFF*)> tiff_{nullptr, TIFFClose};
  Image image_;
};

bool is_tiff(const std::string& bytes) {
  return bytes.starts_with(std::string("II*\0", 4)) || bytes.starts_with(std::string("MM\0*", 4)) ||
         bytes.starts_with(std::string("II+\0", 4)) || bytes.starts_with(std::string("MM\0+", 4));
}

}  // namespace

Image read_image(const std::filesystem::path& path) {
  return decode_image(read_file(path, kMaxFileBytes), path.string());
}

Image decode_image(std::string bytes, const std::string& name) {
  if (is_tiff(bytes)) return TiffReader(bytes, name).read();
  if (!bytes.starts_with("\x89PNG"))
    throw InputError(
        fmt::format("{}: neither PNG nor TIFF, expected an image of one of these", name));
  return decode_png(std::move(bytes), name);
}

}  // namespace seam::measurement
