#include "measurement/kinds/photometry/stack/emva.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <optional>

namespace seam::measurement {
namespace {

// Rounding to whole numbers, DN^2.
constexpr double kRounding = 1.0 / 12;
// Shares of the saturation signal between which the standard fits: sensitivity and responsivity,
// and linearity.
constexpr double kMostForGain = 0.7;
constexpr double kLeastForLinearity = 0.05, kMostForLinearity = 0.95;
// By the standard so many of the values of dark frames may be 0.
constexpr double kMostAtZero = 0.005;
constexpr double kPercent = 100;
constexpr const char* kSystemGain = "system gain K";
// Figures of means, which no noise moves.
constexpr const char* kOfMeans[] = {"dark signal", "saturation signal", "linearity error LE",
                                    "responsivity R"};

struct Value {
  double value = 0, sigma = 0;
};

// A level beside dark frames of the same exposure (of the nearest, where there are none).
struct Point {
  const PhotometryLevel* level;
  const PhotometryLevel* dark;
  double light;   // In units of the first frame's illumination and exposure.
  double signal;  // Mean above dark, DN.
  double signal_sigma;
  double noise2;  // Variance in time above dark, DN^2.
  double noise2_sigma;
};

double sigma_of_variance(const LevelStatistics& s) {
  return s.temporal_variance * std::sqrt(2 / (s.samples * (s.frames - 1)));
}
// Of a mean: what samples leave, and how far the frames' means lie apart.
double sigma_of_mean(const LevelStatistics& s) {
  const double of_samples = s.temporal_variance / (s.samples * s.frames);
  return std::sqrt(std::max(of_samples, s.frame_scatter / s.frames));
}
// Spatial variance of the samples' means without what noise in time leaves of them.
double own_spatial_variance(const LevelStatistics& s) {
  return s.spatial_variance - s.temporal_variance / s.frames;
}

const PhotometryLevel* nearest_dark(const PhotometryData& data, double exposure_s, double gain) {
  const PhotometryLevel* best = nullptr;
  for (const PhotometryLevel& level : data.levels) {
    if (level.illumination != 0 || level.whole.frames < 2 || level.gain != gain) continue;
    const double apart = std::abs(level.exposure_s - exposure_s);
    const double least = best ? std::abs(best->exposure_s - exposure_s) : 0;
    if (!best || apart < least || (apart == least && level.whole.frames > best->whole.frames))
      best = &level;
  }
  return best;
}

std::vector<Point> points_of(const PhotometryData& data) {
  std::vector<Point> points;
  for (const PhotometryLevel& level : data.levels) {
    if (level.illumination == 0 || level.whole.frames < 2 || level.gain != data.levels[0].gain)
      continue;
    const PhotometryLevel* dark = nearest_dark(data, level.exposure_s, level.gain);
    if (!dark) continue;
    const LevelStatistics &lit = level.whole, &off = dark->whole;
    points.push_back({&level, dark, level.light(), lit.mean - off.mean,
                      std::hypot(sigma_of_mean(lit), sigma_of_mean(off)),
                      lit.temporal_variance - off.temporal_variance,
                      std::hypot(sigma_of_variance(lit), sigma_of_variance(off))});
  }
  std::stable_sort(points.begin(), points.end(),
                   [](const Point& a, const Point& b) { return a.signal < b.signal; });
  return points;
}

// A line through the origin by least squares. Its error: what the points' own errors leave, or
// their scatter about the line where that is larger.
template <typename X, typename Y, typename Sigma>
std::optional<Value> slope_through_origin(const std::vector<const Point*>& points, X x, Y y,
                                          Sigma sigma) {
  double xx = 0, xy = 0, own = 0, square = 0;
  for (const Point* p : points) xx += x(*p) * x(*p), xy += x(*p) * y(*p);
  if (points.size() < 2 || !(xx > 0)) return std::nullopt;
  const double slope = xy / xx;
  for (const Point* p : points) {
    const double r = y(*p) - slope * x(*p);
    own += x(*p) * x(*p) * sigma(*p) * sigma(*p), square += x(*p) * x(*p) * r * r;
  }
  const auto n = static_cast<double>(points.size());
  return Value{slope, std::sqrt(std::max(own, square * n / (n - 1))) / xx};
}

// A line with an offset by least squares: what is alike in all points has no part in its slope.
template <typename X, typename Y, typename Sigma>
std::optional<Value> slope_of_line(const std::vector<const Point*>& points, X x, Y y, Sigma sigma) {
  const auto n = static_cast<double>(points.size());
  if (n < 3) return std::nullopt;
  double x0 = 0, y0 = 0, xx = 0, xy = 0, own = 0, square = 0;
  for (const Point* p : points) x0 += x(*p) / n, y0 += y(*p) / n;
  for (const Point* p : points) {
    xx += (x(*p) - x0) * (x(*p) - x0);
    xy += (x(*p) - x0) * (y(*p) - y0);
  }
  if (!(xx > 0)) return std::nullopt;
  const double slope = xy / xx;
  for (const Point* p : points) {
    const double r = y(*p) - y0 - slope * (x(*p) - x0), away2 = (x(*p) - x0) * (x(*p) - x0);
    own += away2 * sigma(*p) * sigma(*p), square += away2 * r * r;
  }
  return Value{slope, std::sqrt(std::max(own, square * n / (n - 2))) / xx};
}

// The standard's line of least relative deviations, and the mean of their sizes, percent.
std::optional<Value> linearity_error(const std::vector<const Point*>& points) {
  if (points.size() < 3) return std::nullopt;
  double w = 0, x = 0, y = 0, xx = 0, xy = 0;
  for (const Point* p : points) {
    const double own = 1 / (p->signal * p->signal);
    w += own, x += own * p->light, y += own * p->signal;
    xx += own * p->light * p->light, xy += own * p->light * p->signal;
  }
  const double slope = (w * xy - x * y) / (w * xx - x * x), offset = (y - slope * x) / w;
  double sum = 0, variance = 0;
  for (const Point* p : points) {
    const double line = offset + slope * p->light;
    sum += kPercent * std::abs(p->signal - line) / line;
    variance += std::pow(kPercent * p->signal_sigma / line, 2);
  }
  const auto n = static_cast<double>(points.size());
  return Value{sum / n, std::sqrt(variance) / n};
}

class Emva {
 public:
  explicit Emva(const PhotometryData& data)
      : data_(data), points_(points_of(data)), darks_are_cut_off_(darks_cut_off(data) > 0) {}

  FigureTable run() {
    if (points_.size() < 3) return {};
    find_saturation();
    const auto gain = photon_transfer(
        below(kMostForGain), [](const Point& p) { return p.signal; },
        [](const Point& p) { return p.noise2; }, [](const Point& p) { return p.noise2_sigma; });
    if (!gain || !(gain->value > 0)) return {};
    gain_ = *gain;
    table_.title = "EMVA 1288";
    add(kSystemGain, "DN/e-", gain_);
    add("1/K", "e-/DN", {1 / gain_.value, gain_.sigma / (gain_.value * gain_.value)});
    if (!darks_are_cut_off_) {
      add_dark();
      add_saturation();
      add_nonuniformity();
    }
    if (const auto error = linearity_error(between(kLeastForLinearity, kMostForLinearity)))
      add("linearity error LE", "%", *error);
    if (!darks_are_cut_off_) {
      add_efficiency();
      add_curve();
    }
    return table_;
  }

  std::optional<double> gain_of(const effects::SensorChain& chain) {
    if (points_.size() < 3) return std::nullopt;
    find_saturation();
    const auto of = [&](const PhotometryLevel& level) {
      const effects::SensorExposure exposure{.exposure_s = level.exposure_s,
                                             .exposure_ratio = level.exposure_ratio,
                                             .gain = level.gain,
                                             .file_bits = data_.file_bits};
      const double signal = effects::signal_dn(chain, level.illumination, exposure);
      return effects::response_moments(chain, signal, 1, exposure);
    };
    std::vector<const Point*> known = below(kMostForGain);
    std::erase_if(known, [](const Point* p) { return !std::isfinite(p->light); });
    const auto slope = photon_transfer(
        known, [&](const Point& p) { return of(*p.level).mean_dn - of(*p.dark).mean_dn; },
        [&](const Point& p) { return of(*p.level).variance_dn2 - of(*p.dark).variance_dn2; },
        [](const Point&) { return 0.0; });
    if (!slope || !(slope->value > 0)) return std::nullopt;
    return slope->value;
  }

 private:
  // The slope of the noise over the signal.
  template <typename... Coordinates>
  std::optional<Value> photon_transfer(const std::vector<const Point*>& points,
                                       Coordinates... coordinates) const {
    return darks_are_cut_off_ ? slope_of_line(points, coordinates...)
                              : slope_through_origin(points, coordinates...);
  }
  void add(const std::string& name, const std::string& unit, Value v) {
    table_.figures.push_back({name, unit, v.value, v.sigma});
  }

  // Where the noise in time is largest: from there on values are clipped.
  void find_saturation() {
    saturation_ =
        &*std::max_element(points_.begin(), points_.end(),
                           [](const Point& a, const Point& b) { return a.noise2 < b.noise2; });
    is_saturated_ = std::any_of(points_.begin(), points_.end(), [&](const Point& p) {
      return p.signal > saturation_->signal && p.noise2 < 0.9 * saturation_->noise2;
    });
  }
  std::vector<const Point*> between(double least, double most) const {
    std::vector<const Point*> chosen;
    for (const Point& p : points_) {
      const double share = p.signal / saturation_->signal;
      if (share >= least && share <= most) chosen.push_back(&p);
    }
    return chosen;
  }
  std::vector<const Point*> below(double most) const { return between(0, most); }

  // A value in DN as electrons.
  Value electrons(Value dn) const {
    const double value = dn.value / gain_.value;
    return {value, std::hypot(dn.sigma / gain_.value, value * gain_.sigma / gain_.value)};
  }

  void add_dark() {
    const PhotometryLevel* dark = nearest_dark(data_, 0, data_.levels[0].gain);
    const LevelStatistics& s = dark->whole;
    add("dark signal", "DN", {s.mean, sigma_of_mean(s)});
    const double own = std::max(s.temporal_variance - kRounding, 0.0);
    dark_noise_ = {std::sqrt(own), own > 0 ? sigma_of_variance(s) / (2 * std::sqrt(own)) : 0};
    add("dark noise", "DN", dark_noise_);
    add("dark noise sigma_d", "e-", electrons(dark_noise_));
    add_dark_current();
  }

  void add_dark_current() {
    double n = 0, x = 0, y = 0, xx = 0, xy = 0;
    for (const PhotometryLevel& level : data_.levels) {
      if (level.illumination != 0 || level.gain != data_.levels[0].gain) continue;
      const double t = level.exposure_s, m = level.whole.mean;
      n += 1, x += t, y += m, xx += t * t, xy += t * m;
    }
    const double spread = xx - x * x / std::max(n, 1.0);
    if (n < 3 || !(spread > 1e-9 * xx)) return;
    const double slope = (xy - x * y / n) / spread, offset = (y - slope * x) / n;
    double square = 0;
    for (const PhotometryLevel& level : data_.levels) {
      if (level.illumination != 0 || level.gain != data_.levels[0].gain) continue;
      const double r = level.whole.mean - offset - slope * level.exposure_s;
      square += r * r;
    }
    add("dark current", "e-/s", electrons({slope, std::sqrt(square / (n - 2) / spread)}));
  }

  void add_saturation() {
    if (!is_saturated_) return;
    const Value signal{saturation_->signal, saturation_->signal_sigma};
    add("saturation signal", "DN",
        {saturation_->level->whole.mean, sigma_of_mean(saturation_->level->whole)});
    const Value capacity = electrons(signal);
    add("saturation capacity", "e-", capacity);
    const double root = std::sqrt(capacity.value);
    add("SNR max", "", {root, capacity.sigma / (2 * root)});
    const Value noise = electrons(dark_noise_);
    const double least2 = noise.value * noise.value + kRounding / (gain_.value * gain_.value);
    const double least = std::sqrt(least2 + 0.25) + 0.5;
    add("sensitivity threshold", "e-",
        {least, noise.value * noise.sigma / std::sqrt(least2 + 0.25)});
    add("dynamic range", "",
        {capacity.value / least,
         std::hypot(capacity.sigma / least, capacity.value * noise.value * noise.sigma /
                                                (least * least * std::sqrt(least2 + 0.25)))});
  }

  // DSNU from the dark level and PRNU from the level nearest to half of saturation, of most frames.
  void add_nonuniformity() {
    const Point* half = nullptr;
    const auto off = [&](const Point& p) { return std::abs(p.signal / saturation_->signal - 0.5); };
    for (const Point& p : points_) {
      if (off(p) > 0.2) continue;
      const bool more = half && p.level->whole.frames > half->level->whole.frames;
      const bool nearer =
          half && p.level->whole.frames == half->level->whole.frames && off(p) < off(*half);
      if (!half || more || nearer) half = &p;
    }
    if (!half) return;
    const LevelStatistics &lit = half->level->whole, &dark = half->dark->whole;
    const auto sigma = [](const LevelStatistics& s) {
      const double of_time = sigma_of_variance(s) / s.frames;
      return std::hypot(s.spatial_variance * std::sqrt(2 / s.samples), of_time);
    };
    const double offsets = own_spatial_variance(dark);
    if (offsets > 0) {
      const Value dn{std::sqrt(offsets), sigma(dark) / (2 * std::sqrt(offsets))};
      add("DSNU", "DN", dn);
      add("DSNU1288", "e-", electrons(dn));
    }
    const double gains = own_spatial_variance(lit) - offsets;
    if (!(gains > 0)) return;
    const double prnu = std::sqrt(gains) / half->signal;
    add("PRNU1288", "%",
        {kPercent * prnu,
         kPercent * std::hypot(sigma(lit), sigma(dark)) / (2 * std::sqrt(gains) * half->signal)});
  }

  void add_efficiency() {
    std::vector<const Point*> counted;
    for (const Point* p : below(kMostForGain))
      if (p->level->photons > 0) counted.push_back(p);
    const auto slope = slope_through_origin(
        counted, [](const Point& p) { return p.level->photons; },
        [](const Point& p) { return p.signal; }, [](const Point& p) { return p.signal_sigma; });
    if (!slope) return;
    add("responsivity R", "DN/photon", *slope);
    const double efficiency = slope->value / gain_.value;
    efficiency_ = efficiency;
    add("quantum efficiency", "%",
        {kPercent * efficiency,
         kPercent * efficiency *
             std::hypot(slope->sigma / slope->value, gain_.sigma / gain_.value)});
  }

  // The measured ratio of signal to noise, and that of a sensor with these figures.
  void add_curve() {
    const double dark2 = std::pow(dark_noise_.value / gain_.value, 2);
    const double rounding2 = kRounding / (gain_.value * gain_.value);
    for (const Point& p : points_) {
      const double noise2 = p.level->whole.temporal_variance;
      if (!(noise2 > 0) || !(p.signal > 0)) continue;
      const double photons = p.level->photons;
      const double e =
          photons > 0 && efficiency_ > 0 ? efficiency_ * photons : p.signal / gain_.value;
      const double snr = p.signal / std::sqrt(noise2);
      table_.curve.push_back(
          {.light = photons > 0 ? photons : p.light,
           .signal_dn = p.signal,
           .snr = snr,
           .sigma = snr * std::hypot(p.signal_sigma / p.signal,
                                     0.5 * sigma_of_variance(p.level->whole) / noise2),
           .expected = e / std::sqrt(dark2 + rounding2 + e)});
    }
  }

  const PhotometryData& data_;
  std::vector<Point> points_;
  bool darks_are_cut_off_;
  const Point* saturation_ = nullptr;
  bool is_saturated_ = false;
  Value gain_, dark_noise_;
  double efficiency_ = 0;
  FigureTable table_;
};

}  // namespace

double darks_cut_off(const PhotometryData& data) {
  double share = 0;
  for (const PhotometryLevel& level : data.levels) {
    if (level.illumination == 0) share = std::max(share, level.whole.at_zero);
  }
  return share > kMostAtZero ? share : 0;
}

FigureTable emva_figures(const PhotometryData& data) {
  if (data.channels != 1) return {};
  return Emva(data).run();
}

FigureTable without_noise(FigureTable figures) {
  std::erase_if(figures.figures, [](const Figure& figure) {
    return std::find(std::begin(kOfMeans), std::end(kOfMeans), figure.name) == std::end(kOfMeans);
  });
  // What was measured stays; what the gain let expect goes with it.
  for (FigurePoint& point : figures.curve)
    point.expected = std::numeric_limits<double>::quiet_NaN();
  figures.title += ", without what rests on noise";
  return figures;
}

bool has_system_gain(const FigureTable& figures) {
  return std::any_of(figures.figures.begin(), figures.figures.end(),
                     [](const Figure& figure) { return figure.name == kSystemGain; });
}

std::optional<double> emva_gain(const PhotometryData& data, const effects::SensorChain& chain) {
  if (data.channels != 1 || !chain.has_shot_noise()) return std::nullopt;
  return Emva(data).gain_of(chain);
}

}  // namespace seam::measurement
