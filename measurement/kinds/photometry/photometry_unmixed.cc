// Images and their sums as a model looks at them: without the filter over neighbours that it has.
// A change of variables: the likelihood is that of the images before the filter, over the filter's
// determinant, and so every other effect acts on independent noise.
#include <algorithm>

#include "effects/stages/sensor/sensor.h"
#include "measurement/kinds/photometry/photometry_problem.h"
#include "measurement/kinds/photometry/photometry_smooth.h"
#include "measurement/problem/fit_key.h"
#include "sim_core/base/hash.h"

namespace seam::measurement {
namespace {

constexpr size_t kMostSums = 6;
// Of stacks of images that are kept, together.
constexpr double kMostValues = 5e7;
constexpr double kMostStacks = 12;

}  // namespace

std::shared_ptr<const UnmixedStack> PhotometryProblem::unmixed_stack(
    const effects::Mixing& mixing) const {
  {
    const std::scoped_lock lock(mutex_);
    for (const auto& stack : unmixed_) {
      if (stack->data.mixing == mixing) return stack;
    }
  }
  auto made = std::make_shared<UnmixedStack>();
  made->data = unmixed(data_, mixing);
  if (small_) made->small = std::make_unique<const PhotometryData>(thinned(made->data, thinning_));
  const auto values = static_cast<double>(data_.samples() * data_.frames.size());
  const auto most = static_cast<size_t>(std::clamp(kMostValues / values, 1.0, kMostStacks));
  const std::scoped_lock lock(mutex_);
  unmixed_.push_back(made);
  while (unmixed_.size() > most) unmixed_.erase(unmixed_.begin());
  return made;
}

HeldView PhotometryProblem::view_of(const Model& model, const Groups& groups, bool small) const {
  small = small && small_ != nullptr;
  const CellStore* cells = small ? &small_cells_ : &cells_;
  const effects::Mixing mixing = effects::sensor_of(model).mixing;
  if (!mixing.acts()) {
    const auto own = sums(groups, small);
    return {nullptr, own, {small ? *small_ : data_, *own, set_noise_dn_, channels_share_, cells}};
  }
  const auto stack = unmixed_stack(mixing);
  const PhotometryData& data = small ? *stack->small : stack->data;
  std::shared_ptr<const PhotometrySums> own;
  {
    const std::scoped_lock lock(stack->mutex);
    const std::pair key(groups, small);
    for (const auto& [known, value] : stack->sums) {
      if (known == key) own = value;
    }
    if (!own) {
      own = std::make_shared<const PhotometrySums>(sum_frames(data, groups, facts_.group_of_row));
      if (stack->sums.size() >= kMostSums) stack->sums.erase(stack->sums.begin());
      stack->sums.emplace_back(key, own);
    }
  }
  const effects::ImageShape shape{data_.width_px, data_.height_px, data_.channels};
  return {stack,
          own,
          {.data = data,
           .sums = *own,
           .set_noise_dn = set_noise_dn_,
           .channels_share = channels_share_,
           .cells = cells,
           .log_mixing = effects::log_mixing(mixing, shape)}};
}

// The sums with the misfit of each level's mean and of its smooth field taken out: what noise and
// fixed patterns show, whatever the mean lacks.
HeldView PhotometryProblem::rough_view(const Model& model, const Groups& groups) const {
  const HeldView held = view_of(model, groups, true);
  const PhotometryView& view = held.view;
  const std::string key = fit_key(model, {}, groups);
  const std::scoped_lock lock(rough_mutex_);
  if (!rough_ || rough_key_ != key) {
    PhotometrySums rough = *held.sums;
    const PhotometryPrediction prediction = predict(view.data, rough, model, set_noise_dn_);
    const SmoothField field(view.data);
    for (size_t l = 0; l < rough.levels.size(); ++l) {
      std::vector<double>& mean = rough.levels[l].mean;
      if (mean.empty()) continue;
      std::vector<double> residual = mean;
      for (size_t i = 0; i < mean.size(); ++i) residual[i] -= prediction.levels[l].mean[i];
      const std::vector<double> smooth = field.of(residual);
      for (size_t i = 0; i < mean.size(); ++i) mean[i] -= smooth[i];
    }
    set_side_by_side(rough);
    Hasher id;
    id.add(key);
    rough.id = id.digest();
    rough_ = std::make_shared<const PhotometrySums>(std::move(rough));
    rough_key_ = key;
  }
  return {held.stack,
          rough_,
          {.data = view.data,
           .sums = *rough_,
           .set_noise_dn = view.set_noise_dn,
           .channels_share = view.channels_share,
           .cells = view.cells,
           .log_mixing = view.log_mixing}};
}

}  // namespace seam::measurement
