// Kind `frames` as the engine sees it: residuals are the samples of whole images.
#pragma once

#include <functional>
#include <map>
#include <mutex>

#include "measurement/imaging/sensor_response.h"
#include "measurement/kinds/frames/frame_data.h"
#include "measurement/kinds/frames/frame_errors.h"
#include "measurement/kinds/kinds.h"
#include "sim_core/base/image.h"

namespace seam::measurement {

// Fixed patterns count as spread of each frame (a frame is a group of its own); what rows and
// columns share is whitened within a frame.
class FramesProblem : public Problem {
 public:
  FramesProblem(const MeasurementSet& set, const Instruments& instruments);

  Evaluation evaluate(const Model& model, const Groups& groups,
                      const Evaluation* warm = nullptr) const override;
  std::vector<std::vector<double>> jacobian(const Model& model,
                                            const std::vector<Unknown>& unknowns,
                                            const Groups& groups,
                                            const Evaluation& here) const override;
  Score score(const Model& model, const Groups& groups) const override;
  // Gauss-Newton with few renderings: linear steps as long as they promise anything
  // (frames_fit.cc).
  Fit fit(const Model& start, const std::vector<Unknown>& unknowns,
          const Groups& groups) const override;
  std::vector<Structure> structure(const Model& model, const Groups& groups,
                                   int fitted) const override;
  void check_model(const Model& model) const override;
  bool is_smooth(const Model&) const override { return true; }
  std::optional<Groups> screening_groups() const override;
  size_t groups_for_one_fold() const override { return 4; }  // Each fit is dear.
  bool is_visible(const Model& a, const Model& b) const override;
  std::vector<std::vector<double>> starts(const Model& model,
                                          const EffectDefinition& effect) const override;
  std::vector<char> find_outliers(const Model& model) const override;
  std::string no_outliers_because() const override;
  double looks(const Model& model, const EffectDefinition& effect) const override;

 private:
  LightStore light_store(Detail detail) const;
  Evaluation evaluate_with(const LightStore& store, const Model& model, const Groups& groups) const;
  // Of one frame, by sample: residuals, and the variances of the sensor alone (null: not wanted).
  struct Prediction {
    double* residual = nullptr;
    double* variance = nullptr;
  };
  // The k-th of these frames goes to its place; false: the model gives no image.
  bool predict(const LightStore& store, const Model& model, const effects::SensorChain& chain,
               const std::vector<size_t>& frames,
               const std::function<Prediction(size_t k)>& place) const;
  bool predict_means(const Model& model, const std::vector<size_t>& frames,
                     std::vector<double>& residual) const;
  // Of flickering lamps: the strongest wave in what this model leaves of the rows
  // (frames_flicker.cc).
  std::vector<double> flicker_start(const Model& model) const;
  // Of the model with the effect at these values, by rough images; minus infinity where it predicts
  // no image.
  double likelihood(const Model& model, const EffectDefinition& effect,
                    const std::vector<double>& values, const Groups& groups) const;
  std::vector<std::vector<double>> ceiling_start(const Model& model,
                                                 const EffectDefinition& effect) const;
  std::vector<size_t> frames_of(const Groups& groups) const;
  Groups some_training_frames(size_t count) const;
  // `tables` by colour; `scale` is the signal (DN) of light 1.
  void predict_frame(const effects::SensorChain& chain, const std::vector<ResponseTable>& tables,
                     double scale, size_t frame, const std::vector<float>& light,
                     const Prediction& out) const;
  std::vector<ImageSlope> slopes_of(const std::vector<size_t>& frames,
                                    const Evaluation& here) const;
  void whiten(const effects::SensorChain& chain, const std::vector<size_t>& frames,
              Evaluation& out) const;
  Fit fit_anew(const Model& start, const std::vector<Unknown>& unknowns,
               const Groups& groups) const;
  double find_step(const Model& model, const Unknown& unknown, const Groups& groups) const;
  double step_of(const Model& model, const Unknown& unknown, const Groups& groups) const;

  CsvTable table_;
  FrameProtocol protocol_;
  LightStore store_, rough_store_;
  std::vector<std::vector<uint16_t>> images_;
  size_t samples_ = 0;  // Of a frame.
  mutable std::mutex steps_mutex_;
  mutable std::map<std::string, double> steps_;  // Of differences, by parameter.
  mutable std::mutex fits_mutex_;
  mutable std::map<std::string, Fit> fits_;
  mutable std::mutex scores_mutex_;
  mutable std::map<std::string, Score> scores_;
};

// `seam measure` for this kind (frames_measure.cc).
void measure_frames(const Model& truth, const MeasurementSet& protocol,
                    const MeasureOptions& options, const Instruments& instruments);

}  // namespace seam::measurement
