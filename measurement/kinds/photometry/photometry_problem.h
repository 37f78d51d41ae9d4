// Kind `photometry` as the engine sees it.
#pragma once

#include <functional>
#include <memory>
#include <mutex>

#include "measurement/kinds/kinds.h"
#include "measurement/kinds/photometry/means/photometry_means.h"
#include "measurement/kinds/photometry/photometry_starts.h"
#include "measurement/numerics/maximise.h"
#include "measurement/problem/problem.h"
#include "measurement/sets/set.h"

namespace seam::measurement {

using SumsOfGroups =
    std::vector<std::pair<std::pair<Groups, bool>, std::shared_ptr<const PhotometrySums>>>;

// Images without a filter over neighbours, the smaller sensor of them, and sums.
struct UnmixedStack {
  PhotometryData data;
  std::unique_ptr<const PhotometryData> small;
  mutable std::mutex mutex;
  mutable SumsOfGroups sums;
};

// What a model is compared with: the images, without the filter that it has.
struct HeldView {
  std::shared_ptr<const UnmixedStack> stack;  // Null: there is none.
  std::shared_ptr<const PhotometrySums> sums;
  PhotometryView view;
};
using ViewsOfModels = std::function<HeldView(const Model&)>;

class PhotometryProblem : public Problem {
 public:
  explicit PhotometryProblem(const MeasurementSet& set);

  Evaluation evaluate(const Model& model, const Groups& groups,
                      const Evaluation* warm) const override;
  Score score(const Model& model, const Groups& groups) const override;
  Fit fit(const Model& given, const std::vector<Unknown>& unknowns,
          const Groups& groups) const override;
  std::vector<Structure> structure(const Model& model, const Groups& groups,
                                   int fitted) const override;
  const Problem& with_residuals() const override;
  ResidualView residual_view(const Model& model, const Groups& groups) const override;
  std::vector<Figure> figures(const Model& model) const override;
  void check_model(const Model& model) const override;
  std::string not_testable(const Model& model, const EffectDefinition& effect,
                           size_t parameter) const override;
  std::vector<std::vector<double>> starts(const Model& model,
                                          const EffectDefinition& effect) const override;
  bool groups_are_independent(const Model&) const override { return false; }
  // The dark, and each level of light.
  std::vector<Groups> regimes() const override;
  double looks(const Model& model, const EffectDefinition& effect) const override;
  std::vector<char> find_outliers(const Model& model) const override;
  std::string no_outliers_because() const override;

  const PhotometryData& data() const { return data_; }

 private:
  // `small`: of the thinned images, where there are any.
  std::shared_ptr<const PhotometrySums> sums(const Groups& groups, bool small = false) const;
  bool noise_is_shared() const;  // By neighbours, beyond doubt.
  // The images without this filter over neighbours (photometry_unmixed.cc).
  std::shared_ptr<const UnmixedStack> unmixed_stack(const effects::Mixing& mixing) const;
  HeldView view_of(const Model& model, const Groups& groups, bool small = false) const;
  HeldView rough_view(const Model& model, const Groups& groups) const;
  // `curvature` (maximise.h): where it is not empty, one with the correlations that this one has,
  // and 0 where these are not known; then the one at the end.
  Fit fit_all(const Model& start, const std::vector<Unknown>& unknowns, const Groups& groups,
              std::vector<double>& curvature) const;
  std::vector<SearchParameter> sought(const Model& start,
                                      const std::vector<Unknown>& unknowns) const;
  // `first`: a smaller sensor of the same, where there is one.
  Fit fit_to(const ViewsOfModels& views, const Model& start, const std::vector<Unknown>& unknowns,
             const ViewsOfModels& first, std::vector<double>& curvature) const;
  Fit without_misfit(const Fit& fit, const Model& start, const std::vector<Unknown>& unknowns,
                     const Groups& groups) const;
  Model with_straight_response(const PhotometryView& view, const Model& start,
                               const std::vector<Unknown>& unknowns) const;
  Fit widened(const Fit& alone, const std::vector<Unknown>& unknowns, size_t fixed) const;

  PhotometryData data_;
  std::unique_ptr<const PhotometryData> small_;  // Of large images: a smaller sensor of them.
  Thinning thinning_;                            // Its places.
  CellStore cells_, small_cells_;
  double set_noise_dn_ = 0;
  bool channels_share_ = true;
  NoiseLikeness noise_;  // Of the images as they are.
  mutable std::mutex mutex_;
  // Keys of fits that were done, and the curvature at each.
  mutable std::vector<std::pair<std::string, std::vector<double>>> optima_;
  mutable SumsOfGroups cache_;
  mutable std::vector<std::shared_ptr<const UnmixedStack>> unmixed_;  // The latest last.
  mutable std::once_flag means_made_;
  mutable std::unique_ptr<const PhotometryMeans> means_;
  mutable std::mutex rough_mutex_;
  mutable std::string rough_key_;
  mutable std::shared_ptr<const PhotometrySums> rough_;  // Of `rough_view`.
};

// `seam measure` for this kind (photometry_measure.cc).
void measure_photometry(const Model& truth, const MeasurementSet& protocol,
                        const MeasureOptions& options);

}  // namespace seam::measurement
