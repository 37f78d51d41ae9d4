#include "app/import/draft/photometry_draft.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <set>

#include "sim_core/base/error.h"

namespace seam::app {
namespace {

std::string or_blank(double value) {
  return std::isnan(value) ? "" : exact(value);
}

}  // namespace

void PhotometryDraft::add(StackFrame frame, const std::string& name, const std::string& bytes,
                          const Image& image, const std::string& where) {
  if (!(frame.exposure_s >= 0 && frame.exposure_s < 1e5))
    throw InputError(fmt::format("{}: found an exposure of {} s, expected 0 to 100000", where,
                                 frame.exposure_s));
  if (frames_.empty()) {
    draft_.camera.width_px = image.width_px, draft_.camera.height_px = image.height_px;
    draft_.camera.channels = image.channels == 1 ? "grey" : "rgb";
    file_bits_ = image.bits;
  }
  const bool fits = image.width_px == draft_.camera.width_px &&
                    image.height_px == draft_.camera.height_px && image.bits == file_bits_ &&
                    (image.channels == 1) == (draft_.camera.channels == "grey");
  if (!fits)
    throw InputError(fmt::format(
        "{}: found {} x {} px of {} bits in {} channels, expected {} x {} of {} ({}) as before",
        where, image.width_px, image.height_px, image.bits, image.channels, draft_.camera.width_px,
        draft_.camera.height_px, file_bits_, draft_.camera.channels));
  const size_t first = image.channels == 1 ? 0 : 1;
  double sum = 0;
  size_t count = 0;
  for (size_t i = first; i < image.samples.size(); i += static_cast<size_t>(image.channels))
    sum += image.samples[i], ++count;
  for (const uint16_t sample : image.samples) {
    most_ = std::max(most_, sample);
    any_bit_ = static_cast<uint16_t>(any_bit_ | sample);
  }
  // Exposures that differ by rounding alone are one.
  const std::string rounded = fmt::format("{:.9g}", frame.exposure_s);
  std::from_chars(rounded.data(), rounded.data() + rounded.size(), frame.exposure_s);
  frame.mean_dn = sum / static_cast<double>(count);
  frame.file = name;
  if (frame.illumination == 0) {
    // Two darks in a row: half the variance of their difference is the read noise's.
    if (dark_sigma_dn_ == 0 && last_dark_.size() == image.samples.size()) {
      double s = 0, s2 = 0;
      for (size_t i = 0; i < last_dark_.size(); ++i) {
        const double d = static_cast<double>(image.samples[i]) - last_dark_[i];
        s += d, s2 += d * d;
      }
      const auto n = static_cast<double>(last_dark_.size());
      dark_sigma_dn_ = std::sqrt(std::max(0.0, 0.5 * (s2 / n - s / n * (s / n))));
    }
    last_dark_ = image.samples;
  }
  frames_.push_back(std::move(frame));
  draft_.add_file(name, bytes.empty() ? encode_png(image) : bytes);
}

int PhotometryDraft::told_bits(int bits, const std::string& where) const {
  if (bits > 0 && bits < file_bits_ && most_ >= 1u << bits) {
    const int shift = file_bits_ - bits;
    const bool left = (any_bit_ & ((1u << shift) - 1)) == 0;
    draft_.warn(left ? fmt::format("{}: {} bits, but all samples are multiples of {}: the values "
                                   "are left-aligned and taken as {} bits",
                                   where, bits, 1 << shift, file_bits_)
                     : fmt::format("{}: {} bits, but samples reach {}: taken as {} bits", where,
                                   bits, most_, file_bits_));
    return file_bits_;
  }
  return bits > 0 ? bits : file_bits_;
}

std::string PhotometryDraft::effects() const {
  // The line of means over light, where light is known; light counts from the first frame's
  // exposure.
  double n = 0, sx = 0, sy = 0, sxx = 0, sxy = 0;
  const double first_s = frames_.front().exposure_s;
  const double top = most_;
  for (const StackFrame& frame : frames_) {
    if (std::isnan(frame.illumination) || frame.mean_dn > 0.9 * top) continue;
    const double ratio = first_s > 0 ? frame.exposure_s / first_s : 1;
    const double x = frame.illumination * ratio;
    n += 1, sx += x, sy += frame.mean_dn, sxx += x * x, sxy += x * frame.mean_dn;
  }
  double darkest = frames_.front().mean_dn, brightest = darkest;
  for (const StackFrame& frame : frames_) {
    darkest = std::min(darkest, frame.mean_dn);
    brightest = std::max(brightest, frame.mean_dn);
  }
  const double det = n * sxx - sx * sx;
  double gain = det > 0 ? (n * sxy - sx * sy) / det : 0;
  double black = n > 0 ? (sy - gain * sx) / n : darkest;
  if (!(gain > 0)) gain = std::max(1.0, brightest - darkest), black = darkest;
  return fmt::format(
      "  linear_response: {{gain_dn: {{value: {:.6g}, free: true}}, black_dn: {{value: {:.6g}, "
      "free: true}}}}\n  read_noise: {{sigma_dn: {{value: {:.4g}, free: true}}}}\n",
      gain, black, dark_sigma_dn_ > 0.05 ? dark_sigma_dn_ : 1.0);
}

void PhotometryDraft::finish(int bits, const std::string& where) {
  if (frames_.size() < 2)
    throw InputError(fmt::format("{}: found {} images, expected 2 or more", where, frames_.size()));
  draft_.kind = "photometry";
  draft_.group = "frame";
  draft_.camera.bits = told_bits(bits, where);
  const auto any = [&](auto of) { return std::any_of(frames_.begin(), frames_.end(), of); };
  const bool photons = any([](const StackFrame& f) { return !std::isnan(f.photons); });
  const bool levels = any([](const StackFrame& f) { return !f.level.empty(); });
  std::vector<std::string> columns = {"frame", "file", "time_s", "exposure_s", "illumination"};
  if (photons) columns.emplace_back("photons");
  if (levels) columns.emplace_back("level");
  measurement::CsvWriter table(columns);
  size_t darks = 0;
  std::set<double> exposures;
  for (size_t i = 0; i < frames_.size(); ++i) {
    const StackFrame& frame = frames_[i];
    std::vector<std::string> cells = {fmt::format("{}", i), frame.file, fmt::format("{}", i),
                                      exact(frame.exposure_s), or_blank(frame.illumination)};
    if (photons) cells.push_back(or_blank(frame.photons));
    if (levels) cells.push_back(frame.level);
    table.row(cells);
    darks += frame.illumination == 0;
    exposures.insert(frame.exposure_s);
  }
  draft_.add_table("frames", table);
  draft_.effects = effects();
  draft_.did(fmt::format("{} frames, {} of them dark, at {} exposures of {} to {} s",
                         frames_.size(), darks, exposures.size(), exact(*exposures.begin()),
                         exact(*exposures.rbegin())));
  if (darks == 0)
    draft_.warn(
        "no dark frames: black level, read noise and fixed offsets hang on the line of the "
        "bright ones");
  if (darks == 1) draft_.warn("one dark frame: read noise takes two at the same exposure");
  draft_.could_not_know(
      "when the frames were taken: numbered by seconds in their order; lamps that flicker or drift "
      "show only if that is right");
}

}  // namespace seam::app
