// Stacks of flat fields and darks as sets of photometry: what the kinds of images share.
#pragma once

#include <limits>
#include <string>
#include <vector>

#include "app/import/draft/set_draft.h"
#include "sim_core/base/image.h"

namespace seam::app {

struct StackFrame {
  std::string file;  // Inside the set.
  double exposure_s = 0;
  double illumination = std::numeric_limits<double>::quiet_NaN();  // Blank in the set.
  double photons = std::numeric_limits<double>::quiet_NaN();
  std::string level;   // Frames of one level see the same light; empty: by the illumination.
  double mean_dn = 0;  // Of the green samples of colour images.
};

class PhotometryDraft {
 public:
  explicit PhotometryDraft(SetDraft& draft) : draft_(draft) {}

  // Takes an image into the set; `name` is its path there. `bytes` are the file's, or empty where
  // `image` was made of another format and is to be written as PNG.
  void add(StackFrame frame, const std::string& name, const std::string& bytes, const Image& image,
           const std::string& where);
  // Writes frames.csv and the nominal model. `bits` of the converter, 0 where nobody says;
  // `where` names the source of what is said of all frames.
  void finish(int bits, const std::string& where);

  size_t frames() const { return frames_.size(); }

 private:
  int told_bits(int bits, const std::string& where) const;
  std::string effects() const;

  SetDraft& draft_;
  std::vector<StackFrame> frames_;
  int file_bits_ = 0;
  uint16_t most_ = 0, any_bit_ = 0;  // The highest sample; bits that are set in any.
  double dark_sigma_dn_ = 0;
  std::vector<uint16_t> last_dark_;
};

}  // namespace seam::app
