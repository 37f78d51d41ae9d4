// `seam import emva1288`: a series of EMVA 1288 by its descriptor text and its images.
#include <algorithm>
#include <cmath>
#include <sstream>

#include "app/import/bags/reading_progress.h"
#include "app/import/draft/photometry_draft.h"
#include "app/import/files/source_file.h"
#include "app/import/files/text_table.h"
#include "app/import/kinds/kinds.h"
#include "measurement/imaging/image_file.h"
#include "sim_core/base/error.h"
#include "sim_core/input/file_names.h"

namespace seam::app {
namespace {

class Descriptor {
 public:
  Descriptor(const std::filesystem::path& path, SetDraft& draft)
      : path_(path), draft_(draft), stack_(draft) {}

  void read() {
    std::istringstream text(read_source(path_, uint64_t{64} << 20));
    std::string row;
    for (line_ = 1; std::getline(text, row); ++line_) take(row);
    if (bits_ == 0) fail("the line 'n BITS WIDTH HEIGHT' is missing");
    ReadingProgress progress("emva1288", images_.size(), "pictures", 1);
    for (size_t i = 0; i < images_.size(); ++i) {
      progress.at(i);
      add(images_[i]);
    }
    stack_.finish(bits_, path_.string());
    draft_.did(
        fmt::format("exposures in ns and photons a pixel from {}; light is photons over "
                    "exposure, in units of the median",
                    path_.filename().string()));
  }

 private:
  struct ImageLine {
    std::string name;
    int line = 0;
    double exposure_s = 0, photons = 0;
  };

  [[noreturn]] void fail(const std::string& why) const {
    throw InputError(fmt::format("{}:{}: {}", path_.string(), line_, why));
  }

  // The numbers behind a line's letter.
  std::vector<double> numbers(const std::string& rest, size_t count) const {
    std::istringstream words(rest);
    std::vector<double> values;
    for (std::string word; words >> word;) {
      double value = 0;
      if (!parse_number(word, value) || value < 0)
        fail(fmt::format("found '{}', expected a number of 0 or more", word));
      values.push_back(value);
    }
    if (values.size() < count)
      fail(fmt::format("found {} numbers, expected {}", values.size(), count));
    return values;
  }

  void take(std::string row) {
    const size_t last = row.find_last_not_of(" \t\r");
    row.resize(last == std::string::npos ? 0 : last + 1);
    const size_t first = row.find_first_not_of(" \t");
    if (first == std::string::npos || row[first] == '#') return;
    const char what = row[first];
    const std::string rest = row.substr(first + 1);
    if (what == 'v') {
      return;
    } else if (what == 'n') {
      const auto n = numbers(rest, 3);
      if (!(n[0] >= 1 && n[0] <= 16)) fail(fmt::format("found {} bits, expected 1 to 16", n[0]));
      bits_ = static_cast<int>(n[0]);
      width_px_ = n[1], height_px_ = n[2];
    } else if (what == 'b' || what == 'd') {
      const auto n = numbers(rest, what == 'b' ? 2 : 1);
      exposure_s_ = n[0] * 1e-9;
      photons_ = what == 'b' ? n[1] : 0;
      in_level_ = true;
      if (what == 'b' && n[0] > 0) rates_.push_back(n[1] / exposure_s_);
    } else if (what == 'i') {
      if (!in_level_) fail("found an image before the first 'b' or 'd'");
      const size_t name = rest.find_first_not_of(" \t");
      if (name == std::string::npos) fail("found no name of an image");
      std::string file = rest.substr(name);
      std::replace(file.begin(), file.end(), '\\', '/');
      images_.push_back({file, line_, exposure_s_, photons_});
    } else {
      fail(fmt::format("found '{}', expected v, n, b, d, i or #", row.substr(first, 20)));
    }
  }

  void add(const ImageLine& image) {
    line_ = image.line;
    const auto folder = path_.has_parent_path() ? path_.parent_path() : ".";
    const std::string why = why_not_inside(folder, image.name);
    if (!why.empty()) fail(why);
    if (!std::filesystem::is_regular_file(folder / image.name))
      fail(fmt::format("image {} is missing", image.name));
    const std::string bytes = read_source(folder / image.name);
    const Image pixels = measurement::decode_image(bytes, (folder / image.name).string());
    if (pixels.width_px != width_px_ || pixels.height_px != height_px_)
      fail(fmt::format("{} is {} x {} px, expected {} x {}", image.name, pixels.width_px,
                       pixels.height_px, width_px_, height_px_));
    if (pixels.channels != 1) fail(fmt::format("{} is in colour, expected grey", image.name));
    StackFrame frame{.exposure_s = image.exposure_s, .photons = image.photons};
    const double rate = image.exposure_s > 0 ? image.photons / image.exposure_s : image.photons;
    frame.illumination = image.photons == 0 ? 0 : rate / usual_rate();
    stack_.add(frame, image.name, bytes, pixels, fmt::format("{}:{}", path_.string(), line_));
  }

  double usual_rate() {
    if (rates_.empty()) return 1;
    std::nth_element(rates_.begin(),
                     rates_.begin() + static_cast<std::ptrdiff_t>(rates_.size() / 2), rates_.end());
    const double rate = rates_[rates_.size() / 2];
    return rate > 0 ? rate : 1;
  }

  std::filesystem::path path_;
  SetDraft& draft_;
  PhotometryDraft stack_;
  int line_ = 0, bits_ = 0;
  double width_px_ = 0, height_px_ = 0, exposure_s_ = 0, photons_ = 0;
  bool in_level_ = false;
  std::vector<double> rates_;  // Photons a second by level.
  std::vector<ImageLine> images_;
};

}  // namespace

void import_emva1288(const ImportRequest& request, SetDraft& draft) {
  if (request.sources.size() != 1) throw UsageError("emva1288: expected one descriptor or folder");
  std::filesystem::path path = request.sources[0];
  if (std::filesystem::is_directory(path)) {
    std::vector<std::filesystem::path> found;
    for (const auto& entry : std::filesystem::directory_iterator(path)) {
      if (entry.path().extension() == ".txt") found.push_back(entry.path());
    }
    std::sort(found.begin(), found.end());
    if (found.empty())
      throw InputError(fmt::format("{}: holds no descriptor (.txt)", path.string()));
    const auto named = std::find_if(found.begin(), found.end(), [](const auto& file) {
      return file.filename().string().find("EMVA") != std::string::npos;
    });
    path = named == found.end() ? found.front() : *named;
  }
  Descriptor(path, draft).read();
}

}  // namespace seam::app
