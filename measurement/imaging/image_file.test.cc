// Files written by libtiff's own writer, read back; damaged and hostile ones are refused.
#include "measurement/imaging/image_file.h"

#include <gtest/gtest.h>
#include <tiffio.h>

#include <filesystem>
#include <functional>

#include "sim_core/base/error.h"
#include "sim_core/base/files.h"

namespace seam::measurement {
namespace {

struct Written {
  int bits = 16, channels = 1;
  uint32_t tile = 0;  // 0: in strips.
  uint16_t compression = COMPRESSION_NONE;
  const char* mode = "w";
  int pages = 1;
};

constexpr uint32_t kWidth = 37, kHeight = 21;

uint16_t sample(size_t i, int bits) {
  return static_cast<uint16_t>(static_cast<uint32_t>(i) * 2654435761u >> (bits == 16 ? 16 : 24));
}

void describe(TIFF* tiff, const Written& how) {
  TIFFSetField(tiff, TIFFTAG_IMAGEWIDTH, kWidth);
  TIFFSetField(tiff, TIFFTAG_IMAGELENGTH, kHeight);
  TIFFSetField(tiff, TIFFTAG_BITSPERSAMPLE, how.bits);
  TIFFSetField(tiff, TIFFTAG_SAMPLESPERPIXEL, how.channels);
  TIFFSetField(tiff, TIFFTAG_PLANARCONFIG, PLANARCONFIG_CONTIG);
  TIFFSetField(tiff, TIFFTAG_PHOTOMETRIC,
               how.channels == 1 ? PHOTOMETRIC_MINISBLACK : PHOTOMETRIC_RGB);
  TIFFSetField(tiff, TIFFTAG_COMPRESSION, how.compression);
  if (how.tile > 0) {
    TIFFSetField(tiff, TIFFTAG_TILEWIDTH, how.tile);
    TIFFSetField(tiff, TIFFTAG_TILELENGTH, how.tile);
  } else {
    TIFFSetField(tiff, TIFFTAG_ROWSPERSTRIP, 4);
  }
}

// `count` samples from (u, v) on along a row.
std::string row_of(uint32_t u, uint32_t v, uint32_t count, const Written& how) {
  std::string bytes;
  for (size_t i = 0; i < size_t{count} * how.channels; ++i) {
    const uint16_t value = sample((size_t{v} * kWidth + u) * how.channels + i, how.bits);
    if (how.bits == 16) {
      bytes.append(reinterpret_cast<const char*>(&value), 2);
    } else {
      bytes.push_back(static_cast<char>(value));
    }
  }
  return bytes;
}

std::string written(const Written& how) {
  const std::string test = testing::UnitTest::GetInstance()->current_test_info()->name();
  const auto path = std::filesystem::path(testing::TempDir()) / ("seam_" + test + ".tif");
  TIFF* tiff = TIFFOpen(path.c_str(), how.mode);
  for (int page = 0; page < how.pages; ++page) {
    describe(tiff, how);
    if (how.tile == 0) {
      for (uint32_t v = 0; v < kHeight; ++v)
        TIFFWriteScanline(tiff, row_of(0, v, kWidth, how).data(), v, 0);
    } else {
      for (uint32_t v = 0; v < kHeight; v += how.tile) {
        for (uint32_t u = 0; u < kWidth; u += how.tile) {
          std::string tile;
          for (uint32_t row = 0; row < how.tile; ++row) tile += row_of(u, v + row, how.tile, how);
          TIFFWriteTile(tiff, tile.data(), u, v, 0, 0);
        }
      }
    }
    if (how.pages > 1) TIFFWriteDirectory(tiff);
  }
  TIFFClose(tiff);
  std::string bytes = read_file(path, 1 << 20);
  std::filesystem::remove(path);
  return bytes;
}

std::string refusal(const std::string& bytes) {
  try {
    decode_image(bytes, "field.tif");
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(ImageFile, ReadsWhatLibtiffWrites) {
  for (const Written& how :
       {Written{}, Written{.mode = "wb"}, Written{.bits = 8}, Written{.channels = 3},
        Written{.bits = 8, .channels = 3}, Written{.compression = COMPRESSION_LZW},
        Written{.compression = COMPRESSION_ADOBE_DEFLATE}, Written{.tile = 16},
        Written{.channels = 3, .tile = 16, .mode = "wb"}, Written{.mode = "w8"}}) {
    const Image image = decode_image(written(how), "field.tif");
    ASSERT_EQ(image.width_px, static_cast<int>(kWidth));
    ASSERT_EQ(image.height_px, static_cast<int>(kHeight));
    EXPECT_EQ(image.bits, how.bits);
    ASSERT_EQ(image.channels, how.channels);
    for (size_t i = 0; i < image.samples.size(); ++i)
      ASSERT_EQ(image.samples[i], sample(i, how.bits)) << i;
  }
}

TEST(ImageFile, SaysWhatItDoesNotRead) {
  EXPECT_NE(refusal(written({.pages = 2})).find("several images"), std::string::npos);
  EXPECT_NE(refusal("GIF89a").find("neither PNG nor TIFF"), std::string::npos);
  EXPECT_NE(refusal("").find("neither PNG nor TIFF"), std::string::npos);
  EXPECT_NE(refusal(std::string("II*\0", 4)).find("field.tif"), std::string::npos);
}

// Every prefix of a file, and files with any one byte changed, are read or refused, never worse.
TEST(ImageFile, DamagedFilesAreRefusedOrRead) {
  const std::string whole = written({.compression = COMPRESSION_LZW});
  size_t refused = 0;
  for (size_t length = 0; length < whole.size(); length += 7)
    refused += !refusal(whole.substr(0, length)).empty();
  EXPECT_GT(refused, whole.size() / 14);
  for (size_t at = 0; at < whole.size(); ++at) {
    for (const char with : {'\xff', '\x00', '\x7f'}) {
      std::string damaged = whole;
      damaged[at] = with;
      refusal(damaged);
    }
  }
}

// A header that promises 65535 x 65535 pixels over no data asks for no memory.
TEST(ImageFile, HugeHeadersAreRefused) {
  std::string bytes("II*\0\x08\0\0\0\x04\0", 10);
  const auto entry = [&](uint16_t tag, uint32_t value) {
    for (const uint32_t part : {uint32_t{tag} | 4u << 16, 1u, value})
      for (int shift = 0; shift < 32; shift += 8)
        bytes.push_back(static_cast<char>(part >> shift & 0xff));
  };
  entry(TIFFTAG_IMAGEWIDTH, 65535), entry(TIFFTAG_IMAGELENGTH, 65535);
  entry(TIFFTAG_BITSPERSAMPLE, 16), entry(TIFFTAG_STRIPOFFSETS, 8);
  bytes.append(4, '\0');
  EXPECT_NE(refusal(bytes).find("64 million"), std::string::npos) << refusal(bytes);
}

}  // namespace
}  // namespace seam::measurement
