// `seam import flats`: a folder of flat fields and darks. Exposures come from a CSV, from FITS and
// EXIF headers, or from names.
#include <algorithm>
#include <cctype>
#include <cmath>
#include <map>
#include <set>

#include "app/import/bags/reading_progress.h"
#include "app/import/draft/checks.h"
#include "app/import/draft/photometry_draft.h"
#include "app/import/files/fits.h"
#include "app/import/files/source_file.h"
#include "app/import/files/text_table.h"
#include "app/import/kinds/kinds.h"
#include "measurement/imaging/image_file.h"
#include "sim_core/base/error.h"

namespace seam::app {
namespace {

namespace fs = std::filesystem;

std::string lower(std::string text) {
  for (char& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return text;
}

bool is_image(const fs::path& path) {
  static const std::set<std::string> kinds = {".png", ".tif", ".tiff", ".fits", ".fit", ".fts"};
  return kinds.contains(lower(path.extension().string()));
}

struct Flat {
  fs::path path;
  std::string name;  // Inside the set.
  std::optional<double> exposure_s, illumination, photons;
  std::string level;
  std::string from;  // Who said the exposure.
};

bool is_dark_name(const std::string& name) {
  for (const char* word : {"dark", "bias", "black", "capped", "offset"}) {
    if (name.find(word) != std::string::npos) return true;
  }
  return false;
}

// 12.5ms, 0p5s, 100us in a name, where no letter stands around it.
std::optional<double> exposure_in_name(const std::string& name) {
  for (size_t start = 0; start < name.size(); ++start) {
    const auto digit = [&](size_t at) {
      return at < name.size() && std::isdigit(static_cast<unsigned char>(name[at])) != 0;
    };
    if (!digit(start) || (start > 0 && (digit(start - 1) || name[start - 1] == '.'))) continue;
    size_t end = start;
    std::string number;
    while (digit(end) || ((name[end] == '.' || name[end] == 'p') && digit(end + 1)))
      number += name[end] == 'p' ? '.' : name[end], ++end;
    if (end < name.size() && (name[end] == '_' || name[end] == '-') && end + 1 < name.size() &&
        name[end + 1] != 's' && name[end + 1] != 'm' && name[end + 1] != 'u')
      continue;
    if (end < name.size() && (name[end] == '_' || name[end] == '-')) ++end;
    double value = 0;
    if (!parse_number(number, value)) continue;
    for (const auto& [unit, factor] : {std::pair<std::string, double>{"msec", 1e-3},
                                       {"ms", 1e-3},
                                       {"usec", 1e-6},
                                       {"us", 1e-6},
                                       {"ns", 1e-9},
                                       {"sec", 1},
                                       {"s", 1}}) {
      if (name.compare(end, unit.size(), unit) != 0) continue;
      const size_t after = end + unit.size();
      if (after < name.size() && std::isalpha(static_cast<unsigned char>(name[after])) != 0)
        continue;
      return value * factor;
    }
  }
  return std::nullopt;
}

// The words of a name without numbers and units: frames of one stack have them in common.
std::string stem_of(const std::string& name) {
  static const std::set<std::string> kUnits = {"s", "ms", "us", "ns", "sec", "msec", "usec"};
  std::string stem, word;
  for (const char c : fs::path(name).stem().string() + "_") {
    if (std::isalpha(static_cast<unsigned char>(c)) != 0) {
      word += c;
    } else if (!word.empty()) {
      if (!kUnits.contains(lower(word)) && lower(word) != "p")
        stem += (stem.empty() ? "" : "_") + word;
      word.clear();
    }
  }
  return stem.empty() ? "level" : stem;
}

class FlatsImport {
 public:
  FlatsImport(const ImportRequest& request, SetDraft& draft)
      : request_(request), draft_(draft), stack_(draft) {}

  void run() {
    for (const auto& source : request_.sources) find(source);
    if (flats_.empty())
      throw InputError(
          fmt::format("{}: holds no PNG, TIFF or FITS images", request_.sources.front().string()));
    std::sort(flats_.begin(), flats_.end(),
              [](const Flat& a, const Flat& b) { return a.name < b.name; });
    for (const auto& table : tables_) read_table(table);
    // Others relate to the exposure of the first, so that it cannot be one of no length.
    const auto exposed = std::find_if(flats_.begin(), flats_.end(), [](const Flat& flat) {
      return flat.exposure_s ? *flat.exposure_s > 0
                             : lower(flat.name).find("bias") == std::string::npos;
    });
    if (exposed != flats_.end()) std::rotate(flats_.begin(), exposed, std::next(exposed));
    ReadingProgress progress("flats", flats_.size(), "pictures", 1);
    for (size_t i = 0; i < flats_.size(); ++i) {
      progress.at(i);
      add(flats_[i]);
    }
    stack_.finish(0, request_.sources.front().string());
    for (const auto& [from, count] : said_by_)
      draft_.did(fmt::format("exposures of {} frames from {}", count, from));
    if (one_lamp_)
      draft_.could_not_know(
          "the light of the lamp: all bright frames are taken to see the same, so that the "
          "exposure "
          "alone counts");
    if (has_levels_)
      draft_.could_not_know(
          "the light of the bright frames: blank, and equal within a level by the files' names");
  }

 private:
  void find(const fs::path& source) {
    if (!fs::exists(source)) throw InputError(fmt::format("{}: no such file", source.string()));
    if (!fs::is_directory(source)) {
      if (is_image(source)) {
        flats_.push_back({.path = source, .name = "images/" + source.filename().string()});
      } else {
        tables_.push_back(source);
      }
      return;
    }
    for (const auto& entry : fs::recursive_directory_iterator(source)) {
      if (!entry.is_regular_file()) continue;
      if (entry.path().extension() == ".csv") tables_.push_back(entry.path());
      if (is_image(entry.path()))
        flats_.push_back({.path = entry.path(),
                          .name = "images/" + fs::relative(entry.path(), source).string()});
    }
    std::sort(tables_.begin(), tables_.end());
  }

  void read_table(const fs::path& path) {
    const TextTable table = TextTable::read(path);
    const auto column = [&](const char* quantity, std::vector<std::string> usual) {
      const std::string mapped = request_.name_of(quantity);
      if (!mapped.empty()) usual = {mapped};
      return table.find(usual);
    };
    const int file = column("file", {"file", "filename", "image", "name", "path"});
    const int exposure =
        column("exposure", {"exposure_s", "exposure", "exposure_time", "exptime", "t_exp", "exp",
                            "shutter", "integration_time", "time"});
    const int light =
        column("illumination", {"illumination", "light", "irradiance", "radiance", "lux"});
    const int photons = column("photons", {"photons", "photons_per_pixel"});
    if (file < 0 || (exposure < 0 && light < 0))
      throw InputError(fmt::format(
          "{}:1: expected columns file and exposure (or illumination); say theirs with --map",
          table.file()));
    std::map<std::string, size_t> rows;
    for (size_t row = 0; row < table.rows(); ++row)
      rows[fs::path(std::string(table.cell(row, static_cast<size_t>(file)))).filename().string()] =
          row;
    for (Flat& flat : flats_) {
      const auto found = rows.find(flat.path.filename().string());
      if (found == rows.end()) continue;
      if (exposure >= 0) {
        flat.exposure_s = 1e-9 * exposure_unit(table.full_name(static_cast<size_t>(exposure))) *
                          table.number(found->second, static_cast<size_t>(exposure));
        flat.from = table.file();
      }
      if (light >= 0) flat.illumination = blank_or(table, found->second, light);
      if (photons >= 0) flat.photons = blank_or(table, found->second, photons);
    }
  }

  static std::optional<double> blank_or(const TextTable& table, size_t row, int column) {
    const double value = table.number_or_blank(row, static_cast<size_t>(column));
    return std::isnan(value) ? std::nullopt : std::optional(value);
  }

  double exposure_unit(const std::string& column) const {
    if (!request_.time_unit.empty()) return static_cast<double>(nanoseconds_in(request_.time_unit));
    const std::string unit = unit_in(column, {"s", "ms", "us", "ns"});
    return static_cast<double>(nanoseconds_in(unit.empty() ? "s" : unit));
  }

  void add(Flat& flat) {
    const std::string where = flat.path.string();
    const std::string bytes = read_source(flat.path);
    Image image;
    bool made = false, dark = is_dark_name(lower(flat.name));
    if (is_fits(bytes)) {
      FitsImage fits = read_fits(bytes, where);
      image = std::move(fits.image), made = true;
      for (const char* keyword : {"EXPTIME", "EXPOSURE"}) {
        double seconds = 0;
        const auto found = fits.header.find(keyword);
        if (flat.exposure_s || found == fits.header.end()) continue;
        if (parse_number(found->second, seconds)) flat.exposure_s = seconds;
        flat.from = "FITS headers";
      }
      const std::string type = lower(fits.header["IMAGETYP"]);
      if (!type.empty()) dark = is_dark_name(type);
      flat.name = fs::path(flat.name).replace_extension(".png").string();
    } else {
      image = measurement::decode_image(bytes, where);
      const auto seconds = exif_exposure_s(bytes);
      if (!flat.exposure_s && seconds) flat.exposure_s = seconds, flat.from = "EXIF";
    }
    if (!flat.exposure_s) {
      flat.exposure_s = exposure_in_name(lower(flat.name));
      flat.from = "names";
    }
    if (!flat.exposure_s && lower(flat.name).find("bias") != std::string::npos) flat.exposure_s = 0;
    if (!flat.exposure_s)
      throw InputError(fmt::format(
          "{}: its exposure is not known: expected it in the name (flat_10ms_01.png), in EXIF, a "
          "FITS header or a CSV of file and exposure_s",
          where));
    ++said_by_[flat.from];
    StackFrame frame{.exposure_s = *flat.exposure_s};
    if (flat.photons) frame.photons = *flat.photons;
    if (dark) {
      frame.illumination = 0;
    } else if (flat.illumination) {
      frame.illumination = *flat.illumination;
    } else if (bright_stems() == 1) {
      frame.illumination = 1;
      one_lamp_ = true;
    } else {
      frame.level = stem_of(flat.name);
      has_levels_ = true;
    }
    if (frame.level.empty() && bright_stems() > 1) frame.level = dark ? "dark" : "";
    stack_.add(frame, flat.name, made ? "" : bytes, image, where);
  }

  // How many kinds of bright frames the names distinguish.
  size_t bright_stems() {
    if (stems_.empty()) {
      for (const Flat& flat : flats_) {
        if (!is_dark_name(lower(flat.name)) && !flat.illumination)
          stems_.insert(stem_of(flat.name));
      }
      if (stems_.empty()) stems_.insert("level");
    }
    return stems_.size();
  }

  const ImportRequest& request_;
  SetDraft& draft_;
  PhotometryDraft stack_;
  std::vector<Flat> flats_;
  std::vector<fs::path> tables_;
  std::set<std::string> stems_;
  std::map<std::string, size_t> said_by_;
  bool one_lamp_ = false, has_levels_ = false;
};

}  // namespace

void import_flats(const ImportRequest& request, SetDraft& draft) {
  FlatsImport(request, draft).run();
}

}  // namespace seam::app
