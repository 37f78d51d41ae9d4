// The formats: FITS 4.0 (IAU FWG), TIFF 6.0 and Exif 2.3.
#include "app/import/files/fits.h"

#include <algorithm>
#include <cmath>

#include "app/import/files/text_table.h"
#include "sim_core/base/error.h"

namespace seam::app {
namespace {

constexpr size_t kCard = 80, kBlock = 2880;
constexpr double kMaxPixels = 64e6;

// The value of a card behind "KEYWORD = ", without quotes and comment.
std::string value_of(std::string_view card) {
  std::string_view rest = card.substr(10);
  const size_t first = rest.find_first_not_of(' ');
  if (first == std::string_view::npos) return "";
  rest = rest.substr(first);
  if (rest.front() == '\'') {
    const size_t end = rest.find('\'', 1);
    rest = rest.substr(1, end == std::string_view::npos ? end : end - 1);
  } else {
    rest = rest.substr(0, rest.find('/'));
  }
  const size_t last = rest.find_last_not_of(' ');
  return last == std::string_view::npos ? "" : std::string(rest.substr(0, last + 1));
}

// The header's cards; returns where the data begin.
size_t read_cards(std::string_view bytes, const std::string& name,
                  std::map<std::string, std::string>& header) {
  for (size_t at = 0; at + kCard <= bytes.size(); at += kCard) {
    const std::string_view card = bytes.substr(at, kCard);
    std::string keyword(card.substr(0, 8));
    keyword.resize(keyword.find_last_not_of(' ') + 1);
    if (keyword == "END") return (at + kCard + kBlock - 1) / kBlock * kBlock;
    if (card.substr(8, 2) == "= ") header.try_emplace(keyword, value_of(card));
  }
  throw InputError(fmt::format("{}: the FITS header does not end: damaged or cut", name));
}

class Tiff {
 public:
  explicit Tiff(std::string_view bytes) : bytes_(bytes), big_(bytes.starts_with("MM")) {}

  uint32_t number(size_t at, size_t size) const {
    if (at > bytes_.size() || bytes_.size() - at < size) return 0;
    uint32_t value = 0;
    for (size_t i = 0; i < size; ++i) {
      const auto byte = static_cast<uint8_t>(bytes_[at + (big_ ? i : size - 1 - i)]);
      value = value << 8 | byte;
    }
    return value;
  }

  // Where the entry of a tag stands in the directory at `at`; 0: none.
  size_t entry(size_t at, uint32_t tag) const {
    const uint32_t count = number(at, 2);
    for (uint32_t i = 0; i < count; ++i) {
      const size_t place = at + 2 + size_t{12} * i;
      if (place + 12 > bytes_.size()) return 0;
      if (number(place, 2) == tag) return place;
    }
    return 0;
  }

 private:
  std::string_view bytes_;
  bool big_;
};

std::optional<double> exposure_in_tiff(std::string_view bytes) {
  constexpr uint32_t kExifDirectory = 34665, kExposureTime = 33434;
  if (!bytes.starts_with("II") && !bytes.starts_with("MM")) return std::nullopt;
  const Tiff tiff(bytes);
  const size_t root = tiff.number(4, 4);
  const size_t pointer = tiff.entry(root, kExifDirectory);
  size_t entry = pointer == 0 ? 0 : tiff.entry(tiff.number(pointer + 8, 4), kExposureTime);
  if (entry == 0) entry = tiff.entry(root, kExposureTime);
  if (entry == 0) return std::nullopt;
  const size_t value = tiff.number(entry + 8, 4);
  const double below = tiff.number(value + 4, 4);
  if (below == 0) return std::nullopt;
  return tiff.number(value, 4) / below;
}

}  // namespace

bool is_fits(std::string_view bytes) {
  return bytes.starts_with("SIMPLE  =");
}

FitsImage read_fits(std::string_view bytes, const std::string& name) {
  FitsImage fits;
  const size_t data = read_cards(bytes, name, fits.header);
  const auto number = [&](const std::string& keyword, double fallback) {
    const auto found = fits.header.find(keyword);
    if (found == fits.header.end()) return fallback;
    double value = 0;
    if (!parse_number(found->second, value))
      throw InputError(
          fmt::format("{}: {}: found '{}', expected a number", name, keyword, found->second));
    return value;
  };
  const double axes = number("NAXIS", 0), width = number("NAXIS1", 0), height = number("NAXIS2", 0);
  const double bits = number("BITPIX", 0), zero = number("BZERO", 0), scale = number("BSCALE", 1);
  if (axes < 2 || (axes > 2 && number("NAXIS3", 1) != 1) || width < 1 || height < 1 ||
      width * height > kMaxPixels)
    throw InputError(fmt::format("{}: found {} axes of {} x {}, expected one plane of pixels", name,
                                 axes, width, height));
  if ((bits != 8 && bits != 16) || scale != 1)
    throw InputError(fmt::format(
        "{}: found BITPIX {} and BSCALE {}, expected the camera's numbers of 8 or 16 bits", name,
        bits, scale));
  fits.image = {.width_px = static_cast<int>(width),
                .height_px = static_cast<int>(height),
                .channels = 1,
                .bits = static_cast<int>(bits)};
  const size_t count = static_cast<size_t>(width) * static_cast<size_t>(height);
  const size_t size = bits == 8 ? 1 : 2;
  if (data > bytes.size() || (bytes.size() - data) / size < count)
    throw InputError(fmt::format("{}: holds {} of {} pixels: cut", name,
                                 data > bytes.size() ? 0 : (bytes.size() - data) / size, count));
  fits.image.samples.resize(count);
  for (size_t i = 0; i < count; ++i) {
    const auto* at = reinterpret_cast<const uint8_t*>(bytes.data() + data + i * size);
    const double raw =
        size == 1 ? *at : static_cast<int16_t>(static_cast<uint16_t>(at[0] << 8 | at[1]));
    const double value = raw + zero;
    if (!(value >= 0 && value <= 65535))
      throw InputError(fmt::format("{}: pixel {}: found {}, expected 0 to 65535", name, i, value));
    fits.image.samples[i] = static_cast<uint16_t>(value);
  }
  return fits;
}

std::optional<double> exif_exposure_s(std::string_view bytes) {
  if (!bytes.starts_with("\x89PNG")) return exposure_in_tiff(bytes);
  // Chunks: length, name, data, CRC.
  for (size_t at = 8; at + 12 <= bytes.size();) {
    uint64_t length = 0;
    for (size_t i = 0; i < 4; ++i) length = length << 8 | static_cast<uint8_t>(bytes[at + i]);
    if (length > bytes.size() - at - 12) return std::nullopt;
    if (bytes.substr(at + 4, 4) == "eXIf") return exposure_in_tiff(bytes.substr(at + 8, length));
    at += 12 + length;
  }
  return std::nullopt;
}

}  // namespace seam::app
