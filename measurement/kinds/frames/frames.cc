// Kind `frames`: whole images, predicted by rendering them.
#include "measurement/kinds/frames/frames.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "measurement/problem/fit_key.h"
#include "sim_core/base/error.h"

namespace seam::measurement {

FramesProblem::FramesProblem(const MeasurementSet& set, const Instruments& instruments)
    : table_(set.table("frames")),
      protocol_(set, table_, instruments),
      store_(light_store(Detail::fine)),
      rough_store_(light_store(Detail::rough)) {
  check_pixels();
  for (size_t row = 0; row < table_.rows(); ++row) {
    Image image = read_png(set.inside(table_, row, "file"));
    if (image.width_px != protocol_.width_px() || image.height_px != protocol_.height_px() ||
        image.channels != 3 || image.bits != 8) {
      table_.fail(row, "file",
                  fmt::format("an image of {} x {}, {} channels of {} bits", image.width_px,
                              image.height_px, image.channels, image.bits),
                  fmt::format("{} x {}, 3 channels of 8 bits", protocol_.width_px(),
                              protocol_.height_px()));
    }
    images_.push_back(std::move(image.samples));
    facts_.line_of_row.push_back(table_.line(row));
    facts_.time_of_row.push_back((protocol_.stamp(row) - protocol_.reference()).s());
  }
  facts_.set.kind = effects::kFrames;
  facts_.title = set.title;
  facts_.fingerprint = set.fingerprint();
  facts_.file = table_.file();
  facts_.channels = {{.name = "dn", .noise = set.noise_of("dn")}};
  facts_.group_of_row =
      number_groups(table_.texts(table_.has(set.group) ? set.group : "frame"), facts_.groups);
  samples_ = images_.front().size();
  facts_.channel_of.assign(samples_ * images_.size(), 0);
  for (size_t row = 0; row < images_.size(); ++row)
    facts_.row_of.insert(facts_.row_of.end(), samples_, static_cast<int>(row));
}

// All images stay in memory with their residuals, about 100 bytes a pixel: one limit on all of
// them, since a small file may be named by many rows.
void FramesProblem::check_pixels() const {
  constexpr int64_t kMostPixels = int64_t{32} << 20;
  const int64_t pixels =
      static_cast<int64_t>(table_.rows()) * protocol_.width_px() * protocol_.height_px();
  if (pixels > kMostPixels)
    throw InputError(fmt::format(
        "{}: {} images of {} x {} px hold {} million pixels, expected at most {} million in all: "
        "leave out rows",
        table_.file(), table_.rows(), protocol_.width_px(), protocol_.height_px(),
        pixels / 1'000'000, kMostPixels / 1'000'000));
}

LightStore FramesProblem::light_store(Detail detail) const {
  return {protocol_.frames(), protocol_.width_px(), protocol_.height_px(),
          [this, detail](const Model& model, const std::vector<size_t>& frames) {
            return protocol_.render(model, frames, detail);
          }};
}

std::vector<size_t> FramesProblem::frames_of(const Groups& groups) const {
  std::vector<size_t> frames;
  for (size_t f = 0; f < images_.size(); ++f) {
    if (groups[facts_.group_of_row[f]]) frames.push_back(f);
  }
  return frames;
}

Evaluation FramesProblem::evaluate(const Model& model, const Groups& groups,
                                   const Evaluation*) const {
  FrameResiduals found = residuals_of(model, frames_of(groups));
  Evaluation out{.valid = found.errors != nullptr};
  out.log_det.assign(facts_.groups.size(), 0);
  for (size_t k = 0; k < found.log_det.size(); ++k)
    out.log_det[facts_.group_of_row[found.frames[k]]] += found.log_det[k];
  const auto spread = [&](auto& of_frames, auto& of_all) {
    if (of_frames.size() == facts_.scalars()) return of_all.swap(of_frames);
    of_all.assign(facts_.scalars(), 0);
    for (size_t k = 0; k < found.frames.size() && !of_frames.empty(); ++k) {
      std::copy_n(&of_frames[k * samples_], samples_, &of_all[found.frames[k] * samples_]);
    }
  };
  spread(found.residual, out.residual), spread(found.sigma, out.sigma);
  spread(found.whitened, out.whitened), spread(found.used, out.used);
  out.reusable = std::move(found.errors);
  return out;
}

// Searches ask for the same again: what each of many effects would add to is one model.
Score FramesProblem::score(const Model& model, const Groups& groups) const {
  const std::string key = fmt::format("{};{}", times_marked(), fit_key(model, {}, groups));
  {
    const std::scoped_lock lock(scores_mutex_);
    if (const auto known = scores_.find(key); known != scores_.end()) return known->second;
  }
  const Score score = Problem::score(model, groups);
  const std::scoped_lock lock(scores_mutex_);
  return scores_.try_emplace(key, score).first->second;
}

std::vector<std::vector<double>> FramesProblem::jacobian(const Model& model,
                                                         const std::vector<Unknown>& unknowns,
                                                         const Groups& groups,
                                                         const Evaluation& here) const {
  FrameResiduals of_frames{.frames = frames_of(groups)};
  of_frames.errors = std::static_pointer_cast<const FrameErrors>(here.reusable);
  for (const size_t frame : of_frames.frames) {
    const auto gather = [&](const auto& of_all, auto& to) {
      const auto* first = &of_all[frame * samples_];
      to.insert(to.end(), first, first + samples_);
    };
    gather(here.residual, of_frames.residual), gather(here.sigma, of_frames.sigma);
    gather(here.whitened, of_frames.whitened), gather(here.used, of_frames.used);
  }
  std::vector<std::vector<double>> columns;
  for (const std::vector<double>& slopes : slopes_of(model, unknowns, of_frames)) {
    std::vector<double>& column = columns.emplace_back(facts_.scalars(), 0);
    for (size_t k = 0; k < of_frames.frames.size(); ++k) {
      std::copy_n(&slopes[k * samples_], samples_, &column[of_frames.frames[k] * samples_]);
    }
  }
  return columns;
}

// Groups of `count` training frames, evenly spread.
Groups FramesProblem::some_training_frames(size_t count) const {
  Groups groups(facts_.groups.size(), 0);
  const std::vector<size_t> training = frames_of(training_groups());
  count = std::min(count, training.size());
  for (size_t k = 0; k < count; ++k)
    groups[facts_.group_of_row[training[k * training.size() / count]]] = 1;
  return groups;
}

std::optional<Groups> FramesProblem::screening_groups() const {
  return some_training_frames(3);
}

// Two right renderers displace edges, each sample by its own amount and all by a common one, up to
// twice kRendererShiftPx. What differs by no more than that, beside an edge or on it, cannot be
// told apart, however many samples say so.
bool FramesProblem::is_visible(const Model& a, const Model& b) const {
  constexpr double kShare = 0.02;
  constexpr double kAccuracy2 = 4 * kRendererShiftPx * kRendererShiftPx;
  const std::vector<size_t> frames = frames_of(some_training_frames(3));
  const FrameResiduals before = residuals_of(a, frames), after = residuals_of(b, frames);
  if (!before.errors || !after.errors) return true;
  const std::vector<ImageSlope> slopes = image_slopes_of(before);
  double mean_excess = 0, mean_accuracy = 0, spread_change = 0, spread_accuracy = 0;
  for (size_t k = 0; k < frames.size(); ++k) {
    const std::vector<float> square =
        steepest_nearby(slopes[k], protocol_.width_px(), protocol_.height_px());
    for (size_t i = 0; i < samples_; ++i) {
      const size_t at = k * samples_ + i;
      const double tolerance = kAccuracy2 * square[i];
      const double mean = after.residual[at] - before.residual[at];
      const double spread = after.sigma[at] * after.sigma[at] - before.sigma[at] * before.sigma[at];
      mean_excess += std::max(0.0, mean * mean - tolerance);
      mean_accuracy += tolerance;
      const double right = slopes[k].right[i], down = slopes[k].down[i];
      spread_change += std::abs(spread);
      spread_accuracy += kAccuracy2 * (right * right + down * down);
    }
  }
  // Errors at edges look like a spread of all bright samples: only the sums can be compared.
  return mean_excess > kShare * mean_accuracy || spread_change > spread_accuracy;
}

void FramesProblem::check_model(const Model& model) const {
  check_columns(model, {effects::Stage::geometry});
  if (!effects::has_base(model, effects::Base::projection)) {
    throw InputError(fmt::format("model '{}': {} is missing: a set of frames needs a projection",
                                 model.name(), effects::base_name(effects::Base::projection)));
  }
}

std::vector<char> FramesProblem::find_outliers(const Model&) const {
  return std::vector<char>(facts_.scalars(), 0);
}

std::string FramesProblem::no_outliers_because() const {
  return "a pixel that stays odd is an effect (hot_pixels, pixel_gain_spread), and neighbouring "
         "pixels differ at every edge of the scene";
}

Kind frames_kind() {
  return {.bit = effects::kFrames,
          .observations = {.file = "frames", .keys = {"file"}},
          .open = [](const MeasurementSet& set,
                     const Instruments& instruments) -> std::unique_ptr<Problem> {
            return std::make_unique<FramesProblem>(set, instruments);
          },
          .measure = measure_frames};
}

}  // namespace seam::measurement
