#include "open_r/robot/image_vector.h"

#include <OPENR/OFbkImage.h>

#include <algorithm>
#include <cstring>
#include <vector>

#include "open_r/robot/joint_board.h"

namespace seam::open_r {
namespace {

constexpr size_t kBands = 3, kLayers = 4;
// Layers are halves and quarters of the picture.
constexpr int kColumnsAPiece = 4;

// A layer of an image as its bands' lines take turns.
struct Layer {
  int width, height;
  std::vector<byte> bytes;

  Layer(int w, int h, size_t bands)
      : width(w), height(h), bytes(bands * static_cast<size_t>(w * h)) {}
  byte& at(size_t band, int x, int y) {
    return bytes[(static_cast<size_t>(y) * kBands + band) * static_cast<size_t>(width) +
                 static_cast<size_t>(x)];
  }
};

Layer whole_picture(const sdk::Frame& frame, const CameraSettings& settings) {
  const int width = frame.width_px / kColumnsAPiece * kColumnsAPiece;
  const int height = frame.height_px / kColumnsAPiece * kColumnsAPiece;
  const int left = (frame.width_px - width) / 2;
  Layer layer(width, height, kBands);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      std::array<byte, kBands> pixel;
      std::memcpy(pixel.data(),
                  &frame.ycrcb[static_cast<size_t>(y * frame.width_px + left + x) * kBands],
                  kBands);
      if (!settings.are_default()) pixel = settings.applied(pixel);
      for (size_t band = 0; band < kBands; ++band) layer.at(band, x, y) = pixel[band];
    }
  return layer;
}

// Each pixel is the mean of two by two.
Layer half_of(Layer& whole) {
  Layer half(whole.width / 2, whole.height / 2, kBands);
  for (int y = 0; y < half.height; ++y)
    for (int x = 0; x < half.width; ++x)
      for (size_t band = 0; band < kBands; ++band) {
        const int sum = whole.at(band, 2 * x, 2 * y) + whole.at(band, 2 * x + 1, 2 * y) +
                        whole.at(band, 2 * x, 2 * y + 1) + whole.at(band, 2 * x + 1, 2 * y + 1);
        half.at(band, x, y) = static_cast<byte>((sum + 2) / 4);
      }
  return half;
}

byte colours_of(const ColourTable& table, byte y, byte cr, byte cb) {
  byte bits = 0;
  for (size_t channel = 0; channel < table.size(); ++channel) {
    const longword range = table[channel][y / (256 / ocdtMAX_Y_SEGMENT)];
    const bool inside = cb <= range >> 24 && cb >= (range >> 16 & 0xff) &&
                        cr <= (range >> 8 & 0xff) && cr >= (range & 0xff);
    if (inside && range != ocdtINIT) bits = static_cast<byte>(bits | 1 << channel);
  }
  return bits;
}

Layer detect(Layer& picture, const ColourTable& table) {
  Layer layer(picture.width, picture.height, 1);
  for (int y = 0; y < layer.height; ++y)
    for (int x = 0; x < layer.width; ++x)
      layer.bytes[static_cast<size_t>(y * layer.width + x)] =
          colours_of(table, picture.at(0, x, y), picture.at(1, x, y), picture.at(2, x, y));
  return layer;
}

// Where the last line has the count of a channel.
size_t place_of_count(size_t channel) {
  return channel < 4 ? 8 + channel : channel;
}

// The last line of each band: the counter, and how many pixels / 16 each colour has.
void write_tag(Layer& layer, size_t bands, word counter, const std::array<byte, 8>& counts) {
  const auto width = static_cast<size_t>(layer.width);
  for (size_t band = 0; band < bands; ++band) {
    byte* line =
        layer.bytes.data() + ((static_cast<size_t>(layer.height) - 1) * bands + band) * width;
    std::fill_n(line, width, byte{0});
    line[0] = static_cast<byte>(counter & 0xff);
    line[1] = static_cast<byte>(counter >> 8);
    for (size_t channel = 0; channel < counts.size(); ++channel)
      line[place_of_count(channel)] = counts[channel];
  }
}

std::array<byte, 8> counts_of(const Layer& colours) {
  std::array<int, 8> pixels{};
  // Without the last line, which is no picture.
  const size_t end = colours.bytes.size() - static_cast<size_t>(colours.width);
  for (size_t i = 0; i < end; ++i)
    for (size_t channel = 0; channel < 8; ++channel)
      pixels[channel] += colours.bytes[i] >> channel & 1;
  std::array<byte, 8> counts{};
  for (size_t channel = 0; channel < 8; ++channel)
    counts[channel] = static_cast<byte>(std::min(255, pixels[channel] / 16));
  return counts;
}

}  // namespace

RCRegion* make_image_vector(const sdk::Frame& frame, const CameraSettings& settings,
                            const ColourTable& table, OPrimitiveID camera, longword frame_number,
                            word counter) {
  Layer high = whole_picture(frame, settings), middle = half_of(high), low = half_of(middle);
  Layer colours = detect(middle, table);
  const std::array<byte, 8> counts = counts_of(colours);
  Layer* layers[kLayers] = {&high, &middle, &low, &colours};

  const size_t header = sizeof(OFbkImageVectorData) + (kLayers - 1) * sizeof(OFbkImageInfo);
  size_t total = header;
  for (const Layer* layer : layers) total += layer->bytes.size();
  auto* region = new RCRegion(total);
  auto* vector = reinterpret_cast<OFbkImageVectorData*>(region->Base());
  vector->vectorInfo.memRegionID = region->MemID();
  vector->vectorInfo.totalSize = total;
  vector->vectorInfo.type = odataFBKIMAGE_VECTOR;
  vector->vectorInfo.infoSize = sizeof(OFbkImageInfo);
  vector->vectorInfo.maxNumData = vector->vectorInfo.numData = kLayers;
  vector->vectorInfo.syncKey = ovrsynckeyUNDEF;
  size_t offset = header;
  for (size_t i = 0; i < kLayers; ++i) {
    Layer& layer = *layers[i];
    const bool is_colours = i == kLayers - 1;
    write_tag(layer, is_colours ? 1 : kBands, counter, counts);
    vector->info[i] = {is_colours ? odataFBK_CDT : odataFBK_YCrCb,
                       camera,
                       frame_number,
                       offset,
                       layer.bytes.size(),
                       static_cast<size_t>(layer.width),
                       static_cast<size_t>(layer.height),
                       {0}};
    std::memcpy(region->Base() + offset, layer.bytes.data(), layer.bytes.size());
    offset += layer.bytes.size();
  }
  return region;
}

longword frame_number_of(const sdk::Frame& frame) {
  const int64_t middle_ns = frame.row_middle_ns(frame.height_px / 2);
  return static_cast<longword>(std::max<int64_t>(0, (middle_ns + kFrameNs / 2) / kFrameNs));
}

}  // namespace seam::open_r

// ---- OFbkImage ----

OFbkImage::OFbkImage(OFbkImageInfo* info, byte* data, OFbkImageBand band)
    : image_(nullptr), width_(0), height_(0), skip_(0) {
  if (info == nullptr || data == nullptr) return;
  const bool colours = info->type == odataFBK_CDT;
  if (colours != (band == ofbkimageBAND_CDT) || band > ofbkimageBAND_CDT) return;
  width_ = static_cast<int>(info->width);
  height_ = static_cast<int>(info->height);
  skip_ = colours ? 0 : 2 * width_;
  image_ = data + (colours ? 0 : band * info->width);
}

word OFbkImage::FieldCounter() const {
  return static_cast<word>(last_line()[0] | last_line()[1] << 8);
}

byte OFbkImage::ColorFrequency(OCdtChannel channel) const {
  for (size_t i = 0; i < ocdtNUM_CHANNELS; ++i)
    if (channel == 1u << i) return last_line()[seam::open_r::place_of_count(i)];
  return 0;
}
