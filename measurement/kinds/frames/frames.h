// Kind `frames` as the engine sees it: residuals are the samples of whole images.
#pragma once

#include <map>
#include <mutex>

#include "measurement/imaging/sensor_response.h"
#include "measurement/kinds/frames/frame_data.h"
#include "measurement/kinds/frames/frame_errors.h"
#include "measurement/kinds/kinds.h"
#include "sim_core/base/image.h"

namespace seam::measurement {

// What a model leaves of some frames, which stand one after another.
struct FrameResiduals {
  std::vector<size_t> frames;
  std::vector<double> residual, sigma, whitened;  // By sample, as an Evaluation has them.
  std::vector<char> used;
  std::vector<double> log_det;                // By frame.
  std::shared_ptr<const FrameErrors> errors;  // None: the model gives no image.
};
// Of the whitened samples: about 1 where a model is right, infinite where it gives no image.
double mean_square(const FrameResiduals& residuals);

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
  // The same of some frames alone: what Evaluation and jacobian hold, and log_likelihood_of.
  std::vector<size_t> frames_of(const Groups& groups) const;
  FrameResiduals residuals_of(const Model& model, std::vector<size_t> frames) const;
  std::vector<std::vector<double>> slopes_of(const Model& model,
                                             const std::vector<Unknown>& unknowns,
                                             const FrameResiduals& here) const;
  double log_likelihood(const FrameResiduals& residuals) const;  // -inf without an image.
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
  void check_pixels() const;
  LightStore light_store(Detail detail) const;
  FrameResiduals residuals_with(const LightStore& store, const Model& model,
                                std::vector<size_t> frames) const;
  // Residuals of these frames and, if wanted, the variances of the sensor alone; false: no image.
  bool predict(const LightStore& store, const Model& model, const effects::SensorChain& chain,
               const std::vector<size_t>& frames, std::vector<double>& residual,
               std::vector<double>* variance) const;
  // Of flickering lamps: the strongest wave in what this model leaves of the rows
  // (frames_flicker.cc).
  std::vector<double> flicker_start(const Model& model) const;
  // Of the model with the effect at these values, by rough images; minus infinity where it predicts
  // no image.
  double likelihood(const Model& model, const EffectDefinition& effect,
                    const std::vector<double>& values, const std::vector<size_t>& frames) const;
  std::vector<std::vector<double>> ceiling_start(const Model& model,
                                                 const EffectDefinition& effect) const;
  Groups some_training_frames(size_t count) const;
  // `tables` by colour; `scale` is the signal (DN) of light 1. From the frame's first sample on.
  void predict_frame(const effects::SensorChain& chain, const std::vector<ResponseTable>& tables,
                     double scale, size_t frame, const std::vector<float>& light, double* residual,
                     double* variance) const;
  std::vector<ImageSlope> image_slopes_of(const FrameResiduals& here) const;
  void whiten(const effects::SensorChain& chain, FrameResiduals& out) const;
  Fit fit_anew(const Model& start, const std::vector<Unknown>& unknowns,
               const Groups& groups) const;
  // `frame`: on which it is found.
  double find_step(const Model& model, const Unknown& unknown, size_t frame) const;
  double step_of(const Model& model, const Unknown& unknown,
                 const std::vector<size_t>& frames) const;

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
