#include "measurement/kinds/ranges/range_simulation.h"

#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "effects/stages/detector.h"
#include "effects/stages/geometry.h"
#include "effects/stages/optics.h"
#include "effects/stages/row_schedule.h"
#include "measurement/imaging/frame_predictor.h"
#include "sim_core/base/error.h"
#include "sim_core/base/maths.h"
#include "sim_core/scene/scene_file.h"

namespace seam::measurement {
namespace {

constexpr int kTrials = 24;          // Frames with noise of their own, a place.
constexpr int kDisplacements = 8;    // Of images, where jumps are smoothed,
constexpr int kTrialsDisplaced = 2;  // each with so many frames.
constexpr int kTrialsOfSpread = 8;
constexpr int kSquares = 3;  // Where jumps are counted: so many such squares, one in the other.

bool has_patterns(const effects::SensorChain& chain) {
  return chain.has_pixel_patterns() || chain.column_sigma_dn > 0 ||
         (chain.hot_fraction > 0 && chain.hot_level_dn != 0);
}

effects::SensorChain noiseless(effects::SensorChain chain) {
  chain.electrons_per_dn = std::numeric_limits<double>::infinity();
  chain.read_sigma_dn = chain.row_sigma_dn = 0;
  return chain;
}

bool has_noise(const effects::SensorChain& chain) {
  return chain.has_shot_noise() || chain.row_sigma_dn > 0 || chain.read_sigma_dn > 0;
}

effects::SensorExposure exposure_of(const Model& model) {
  return {.exposure_s = effects::timing_of(model).exposure_s};
}

RandomStream trial_stream(size_t place, int trial) {
  return RandomStream{.seed = 0x5EA3}.child("ranges").child(place).child(
      static_cast<uint64_t>(trial));
}

// Weights of four neighbours for a value at this fraction behind the second (Catmull and Rom).
std::array<float, 4> cubic_weights(double fraction) {
  const auto t = static_cast<float>(fraction);
  return {0.5f * t * (-1 + t * (2 - t)), 0.5f * (2 + t * t * (-5 + 3 * t)),
          0.5f * t * (1 + t * (4 - 3 * t)), 0.5f * t * t * (t - 1)};
}

// Light of a window of the image, displaced.
std::vector<float> displaced(const std::vector<float>& light, int width_px, int height_px,
                             const PixelWindow& window, double shift_u, double shift_v) {
  const auto row_at = [&](int v) {
    return &light[3 * static_cast<size_t>(std::clamp(v, 0, height_px - 1)) * width_px];
  };
  std::vector<float> out;
  out.reserve(static_cast<size_t>(window.width_px) * window.height_px * 3);
  if (shift_u == 0 && shift_v == 0) {
    for (int v = window.v; v < window.v + window.height_px; ++v) {
      const float* first = row_at(v) + 3 * static_cast<std::ptrdiff_t>(window.u);
      out.insert(out.end(), first, first + 3 * static_cast<std::ptrdiff_t>(window.width_px));
    }
    return out;
  }
  // What is now at u was at u - shift.
  const double back_u = std::floor(-shift_u), back_v = std::floor(-shift_v);
  const auto wu = cubic_weights(-shift_u - back_u), wv = cubic_weights(-shift_v - back_v);
  const int du = static_cast<int>(back_u) - 1, dv = static_cast<int>(back_v) - 1;
  std::vector<float> row(3 * static_cast<size_t>(window.width_px + 3));
  for (int v = window.v; v < window.v + window.height_px; ++v) {
    for (int u = 0; u < window.width_px + 3; ++u) {
      const size_t column = static_cast<size_t>(std::clamp(window.u + u + du, 0, width_px - 1));
      for (size_t c = 0; c < 3; ++c) {
        float sum = 0;
        for (int k = 0; k < 4; ++k) sum += wv[k] * row_at(v + dv + k)[3 * column + c];
        row[3 * static_cast<size_t>(u) + c] = sum;
      }
    }
    for (size_t i = 0; i < 3 * static_cast<size_t>(window.width_px); ++i) {
      out.push_back(std::max(
          0.0f, wu[0] * row[i] + wu[1] * row[i + 3] + wu[2] * row[i + 6] + wu[3] * row[i + 9]));
    }
  }
  return out;
}

// Points of a lattice that fills a square evenly, each with its opposite: means over them are free
// of what is linear in the displacement.
std::pair<double, double> displacement(int k, double half_width_px) {
  static_assert(kDisplacements == 8);
  return {half_width_px * ((k + 0.5) / 4 - 1), half_width_px * (std::fmod(3 * k + 1.5, 8) / 4 - 1)};
}

struct Moments {
  double mean = 0, variance = 0, fourth = 0;
};
Moments moments_of(const std::vector<double>& values) {
  Moments m;
  const double n = static_cast<double>(values.size());
  for (const double value : values) m.mean += value / n;
  for (const double value : values) {
    const double d2 = (value - m.mean) * (value - m.mean);
    m.variance += d2 / std::max(1.0, n - 1), m.fourth += d2 * d2 / n;
  }
  return m;
}

}  // namespace

double variance_of_spread(double variance, double fourth, double n) {
  if (!(variance > 0) || n < 2) return 0;
  // The second is that of any distribution for many values; it is larger where few values jump.
  return std::max(variance / (2 * (n - 1)), (fourth - variance * variance) / (4 * variance * n));
}

RangeSimulation::RangeSimulation(const MeasurementSet& set, const std::vector<BallPlace>& places,
                                 const Instruments& instruments)
    : width_px_(set.camera.width_px > 0 ? set.camera.width_px : 178),
      height_px_(set.camera.height_px > 0 ? set.camera.height_px : 144),
      places_(places) {
  if (!instruments.render || !instruments.detect) {
    throw InputError(
        "sets of kind ranges need a renderer and a detector, which this program does not have");
  }
  if (set.root.find("rig"))
    set.root.at("rig").fail("a set of ranges has none: its camera is that of the standing robot");
  const ConfigNode detector = set.root.at("detector");
  const auto table = set.root.find("colour_table");
  detector_ = instruments.detect({.name = detector.text(),
                                  .width_px = width_px_,
                                  .height_px = height_px_,
                                  .colour_table = table ? set.inside(*table).string() : ""});
  if (!detector_) {
    detector.fail(fmt::format("found '{}', expected a behaviour that measures distances: {}",
                              detector.text(), fmt::join(instruments.detectors, ", ")));
  }
  const ConfigNode file = set.root.at("scene");
  const std::filesystem::path scene_file = set.inside(file);
  if (!std::filesystem::exists(scene_file))
    file.fail(fmt::format("no file {}, expected one of format seam-scene/1", scene_file.string()));
  const auto scene = read_scene(scene_file);
  make_predictor_ = instruments.render(scene->files());
  background_ = scene->background(), lighting_ = scene->lighting();
  scene->primitives_at(SimTime(), primitives_);
  const auto ball = std::find_if(primitives_.begin(), primitives_.end(),
                                 [](const Primitive& p) { return p.shape == Shape::sphere; });
  if (ball == primitives_.end())
    file.fail(fmt::format("{} has no sphere, expected a ball to measure", file.text()));
  ball_ = static_cast<size_t>(ball - primitives_.begin());
  store_ =
      std::make_unique<LightStore>(places_.size(), width_px_, height_px_,
                                   [this](const Model& model, const std::vector<size_t>& chosen) {
                                     return render(model, chosen);
                                   });
}

std::vector<LightImage> RangeSimulation::render(const Model& model,
                                                const std::vector<size_t>& places) const {
  const auto predictor = make_predictor_(model, width_px_, height_px_, SimTime(), Detail::fine);
  const Pose X_LC = effects::mount_of(model);
  FrameJob job;
  // The head rests and so does the ball: every instant shows the same, but for the lamps.
  effects::Timing timing = effects::timing_of(model);
  if (!effects::lamps_flicker(model)) timing = {};
  job.schedule = effects::make_row_schedule(timing, job.stamp, height_px_, {.instants_per_row = 1});
  job.background = background_, job.lighting = lighting_;
  std::vector<LightImage> light;
  for (const size_t place : places) {
    SceneInstant instant{.X_WC = detector_->gaze(model, places_[place].true_m).X_WL * X_LC,
                         .primitives = primitives_};
    Vec3& p_WB = instant.primitives[ball_].X_WO.p;
    p_WB.x = places_[place].true_m * maths::cos(places_[place].bearing_rad);
    p_WB.y = places_[place].true_m * maths::sin(places_[place].bearing_rad);
    job.instants.clear();
    for (const SimTime time : job.schedule.instants) {
      instant.time = time;
      job.instants.push_back(instant);
    }
    light.push_back(std::make_shared<const std::vector<float>>(predictor->light(job)));
  }
  return light;
}

void RangeSimulation::look_about(const Model& model) {
  const effects::Projection projection(model, width_px_, height_px_);
  const Pose X_LC = effects::mount_of(model);
  const double radius_m = primitives_[ball_].size.x;
  windows_.clear();
  surroundings_.clear();
  for (const BallPlace& place : places_) {
    const Pose X_CW = (detector_->gaze(model, place.true_m).X_WL * X_LC).inverse();
    const Vec3 p_C =
        X_CW * Vec3(place.true_m * maths::cos(place.bearing_rad),
                    place.true_m * maths::sin(place.bearing_rad), primitives_[ball_].X_WO.p.z);
    const effects::ImagePoint centre = projection.project(p_C);
    PixelWindow window{0, 0, width_px_, height_px_};
    if (centre.visible && p_C.z > 0) {
      const int half = static_cast<int>(std::ceil(1.25 * centre.fx * radius_m / p_C.z)) + 8;
      const int u0 = std::clamp(static_cast<int>(centre.u) - half, 0, width_px_ - 1);
      const int v0 = std::clamp(static_cast<int>(centre.v) - half, 0, height_px_ - 1);
      const int u1 = std::clamp(static_cast<int>(centre.u) + half, u0, width_px_ - 1);
      const int v1 = std::clamp(static_cast<int>(centre.v) + half, v0, height_px_ - 1);
      window = {u0, v0, u1 - u0 + 1, v1 - v0 + 1};
    }
    windows_.push_back(detector_->whole(window));
    surroundings_.push_back(surroundings(model, surroundings_.size()));
  }
}

// Colours of a whole frame without noise: what surrounds the window that gets noise.
std::vector<uint8_t> RangeSimulation::surroundings(const Model& model, size_t place) const {
  const LightImage light = store_->light(model, {place}).front();
  std::vector<uint8_t> rgb(light->size());
  const effects::FixedPattern even = effects::fixed_pattern({}, width_px_, height_px_, 3, {});
  effects::expose_bytes(
      noiseless(effects::sensor_of(model)), even, [&](size_t at, size_t) { return &(*light)[at]; },
      exposure_of(model), {}, rgb);
  return detector_->colours(rgb);
}

// Measurements of some trials at one place; fewer than `count` where no ball is seen.
std::vector<double> RangeSimulation::trial_values(const Trials& trials,
                                                  const std::vector<float>& light, double shift_u,
                                                  double shift_v, int first, int count) const {
  const PixelWindow& window = trials.window;
  const std::vector<float> seen = displaced(light, width_px_, height_px_, window, shift_u, shift_v);
  const effects::FixedPattern even =
      effects::fixed_pattern({}, window.width_px, window.height_px, 3, {});
  std::vector<uint8_t> rgb(seen.size()), colours = trials.surroundings;
  std::vector<double> values;
  for (int trial = first; trial < first + count; ++trial) {
    const RandomStream stream = trial_stream(trials.place, trial);
    const auto light_at = [&](size_t at, size_t) { return &seen[at]; };
    if (trials.patterns) {
      const auto pattern =
          effects::fixed_pattern(trials.chain, window.width_px, window.height_px, 3, stream);
      effects::expose_bytes(trials.chain, pattern, light_at, trials.exposure, stream, rgb);
    } else {
      effects::expose_bytes(trials.chain, even, light_at, trials.exposure, stream, rgb);
    }
    detector_->recolour(window, rgb, colours);
    const auto sighting = detector_->measure(colours, trials.gaze);
    if (!sighting) continue;
    effects::Detection detection{.range_m = sighting->distance_m,
                                 .bearing_rad = sighting->bearing_rad};
    effects::apply_detector(trials.model, detection);
    values.push_back(detection.range_m);
  }
  return values;
}

RangeSimulation::Trials RangeSimulation::trials_of(const Model& model,
                                                   const effects::SensorChain& chain,
                                                   size_t place) const {
  const PixelWindow frame{0, 0, width_px_, height_px_};
  return {.model = model,
          .chain = chain,
          .exposure = exposure_of(model),
          .place = place,
          .gaze = detector_->gaze(model, places_[place].true_m),
          .window = windows_.empty() ? detector_->whole(frame) : windows_[place],
          .surroundings = windows_.empty() ? surroundings(model, place) : surroundings_[place]};
}

std::vector<RangePrediction> RangeSimulation::predict(const Model& model,
                                                      const std::vector<size_t>& places,
                                                      double dither_px) const {
  const std::vector<LightImage> light = store_->light(model, places);
  const effects::SensorChain chain = effects::sensor_of(model);
  const int displacements = dither_px > 0 ? kDisplacements : 1;
  const int trials = !has_noise(chain) ? 1 : dither_px > 0 ? kTrialsDisplaced : kTrials;
  std::vector<RangePrediction> out;
  for (size_t i = 0; i < places.size(); ++i) {
    Trials setting = trials_of(model, chain, places[i]);
    RangePrediction prediction{.trials = trials * displacements};
    const auto collect = [&](bool patterns, Moments& all, double& within, double& fourth) {
      std::vector<double> values;
      setting.patterns = patterns;
      within = fourth = 0;
      for (int k = 0; k < displacements; ++k) {
        const auto [u, v] = dither_px > 0 ? displacement(k, dither_px) : std::pair(0.0, 0.0);
        const std::vector<double> part = trial_values(setting, *light[i], u, v, k * trials, trials);
        const Moments m = moments_of(part);
        within += m.variance / displacements, fourth += m.fourth / displacements;
        values.insert(values.end(), part.begin(), part.end());
      }
      all = moments_of(values);
      return static_cast<int>(values.size());
    };
    Moments all;
    prediction.seen = collect(false, all, prediction.variance_m2, prediction.fourth_m4);
    prediction.mean_m = all.mean;
    prediction.own_variance_m2 = prediction.variance_m2 / std::max(1, prediction.seen);
    if (has_patterns(chain)) {
      double within = 0, fourth = 0;
      Moments with;
      collect(true, with, within, fourth);
      prediction.pattern_variance_m2 = std::max(0.0, with.variance - all.variance);
    }
    // Effects of the detector: a spread of its own for each measurement.
    effects::Detection detection{.range_m = prediction.mean_m,
                                 .bearing_rad = places_[places[i]].bearing_rad};
    effects::apply_detector(model, detection);
    const double extra = detection.range_variance;
    prediction.fourth_m4 += 6 * prediction.variance_m2 * extra + 3 * extra * extra;
    prediction.variance_m2 += extra;
    out.push_back(prediction);
  }
  return out;
}

std::vector<RangeSimulation::Scatter> RangeSimulation::scatter(const Model& model,
                                                               double dither_px) const {
  const effects::SensorChain chain = effects::sensor_of(model), quiet = noiseless(chain);
  std::vector<Scatter> out;
  for (size_t p = 0; p < places_.size(); ++p) {
    const LightImage light = store_->light(model, {p}).front();
    const Trials clean = trials_of(model, quiet, p), noisy = trials_of(model, chain, p);
    std::vector<double> values, spreads;
    for (int k = 0; k < kSquares * kDisplacements; ++k) {
      const auto [u, v] =
          displacement(k % kDisplacements, dither_px * (k / kDisplacements + 1) / kSquares);
      const auto one = trial_values(clean, *light, u, v, 0, 1);
      values.insert(values.end(), one.begin(), one.end());
      if (!has_noise(chain)) continue;
      spreads.push_back(
          std::sqrt(moments_of(trial_values(noisy, *light, u, v, 0, kTrialsOfSpread)).variance));
    }
    out.push_back({moments_of(values).variance, moments_of(spreads).variance});
  }
  return out;
}

std::optional<RangeSighting> RangeSimulation::measure_once(const Model& model, size_t place,
                                                           const effects::FixedPattern& pattern,
                                                           RandomStream frame_noise,
                                                           bool noise) const {
  const LightImage light = store_->light(model, {place}).front();
  const Image image = effects::expose(effects::sensor_of(model), pattern, *light,
                                      exposure_of(model), frame_noise, noise);
  const auto sighting = detector_->measure(
      detector_->colours(std::vector<uint8_t>(image.samples.begin(), image.samples.end())),
      detector_->gaze(model, places_[place].true_m));
  if (!sighting) return std::nullopt;
  effects::Detection detection{.range_m = sighting->distance_m,
                               .bearing_rad = sighting->bearing_rad};
  effects::apply_detector(model, detection, true);
  if (noise && detection.range_variance > 0)
    detection.range_m +=
        std::sqrt(detection.range_variance) * normal(effects::range_noise_stream(frame_noise), 0);
  return RangeSighting{detection.range_m, detection.bearing_rad};
}

}  // namespace seam::measurement
