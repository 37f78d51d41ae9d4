// Kind `ranges` as the engine sees it: two residuals a row, of the mean and of the spread of the
// measurements at one place.
//
// A detector's answer is a staircase: it jumps where the edge of the ball's region crosses a colour
// pixel. A ball is put in its place by hand, to a millimetre or two, and edges move with it
// (kPlaceAccuracy_px). So each place has an error of its own: the scatter of the prediction over
// images displaced by so little. Fits look at predictions smoothed over such displacements
// (ranges_fit.cc).
#pragma once

#include <map>
#include <mutex>

#include "measurement/kinds/kinds.h"
#include "measurement/kinds/ranges/range_simulation.h"

namespace seam::measurement {

// Half the width of the square over which images are displaced: 1.5 mm at 0.8 m.
inline constexpr double kPlaceAccuracy_px = 0.3;

class RangesProblem : public Problem {
 public:
  RangesProblem(const MeasurementSet& set, const Instruments& instruments);

  Evaluation evaluate(const Model& model, const Groups& groups,
                      const Evaluation* warm = nullptr) const override;
  // The same with the detector's jumps smoothed over so many pixels to either side.
  Evaluation evaluate_smoothed(const Model& model, const Groups& groups, double dither_px) const;

  // Over steps that the residuals notice.
  std::vector<std::vector<double>> jacobian(const Model& model,
                                            const std::vector<Unknown>& unknowns,
                                            const Groups& groups,
                                            const Evaluation& here) const override;
  Fit fit(const Model& start, const std::vector<Unknown>& unknowns,
          const Groups& groups) const override;

  std::vector<Structure> structure(const Model& model, const Groups& groups,
                                   int fitted) const override;
  void check_model(const Model& model) const override;
  bool is_smooth(const Model&) const override { return true; }
  // A look at every effect costs less than fits of all: only the promising ones are fitted.
  std::optional<Groups> screening_groups() const override { return all_groups(); }
  std::string not_testable(const Model& model, const EffectDefinition& effect,
                           size_t parameter) const override;
  std::vector<std::vector<double>> starts(const Model& model,
                                          const EffectDefinition& effect) const override;
  std::vector<char> find_outliers(const Model& model) const override;
  std::string advice(const std::string& effect, const std::string& other) const override;
  const std::vector<Groups>& folds() const override { return data_.folds; }

 protected:
  void place(const Model& given) override;

 private:
  RangeData data_;
  RangeSimulation simulation_;
  std::vector<RangeSimulation::Scatter> scatter_;  // By place, within kPlaceAccuracy_px.
};

// `seam measure` for this kind (ranges_measure.cc).
void measure_ranges(const Model& truth, const MeasurementSet& protocol,
                    const MeasureOptions& options, const Instruments& instruments);

}  // namespace seam::measurement
