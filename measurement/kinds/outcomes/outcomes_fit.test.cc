// Fits of numbers that change gently to one side of where they begin, and fall off a cliff on the
// other, as counts of pixels of a colour do: runs that are calculated by hand.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "effects/registry.h"
#include "measurement/kinds/outcomes/outcomes.h"
#include "sim_core/base/random.h"

namespace seam::measurement {
namespace {

constexpr double kSigma = 0.013;

double seen_at(double gamma) {
  if (gamma > 1.3) return -10;
  return gamma > 1 ? 0.1 * (gamma - 1) : 0.5 * (gamma - 1);
}

class CliffRuns final : public RunMaker {
 public:
  std::vector<std::string> columns(size_t) const override { return {"seen"}; }
  uint64_t runs(size_t) const override { return 40; }
  uint64_t alike(size_t) const override { return 40; }
  std::map<std::string, std::string> files(size_t) const override { return {}; }
  RunTable make(size_t, const effects::Model& model, uint64_t draw) override {
    const effects::ModelEffect* gamma = model.find("response_gamma");
    RunTable table;
    for (uint64_t run = 0; run < runs(0); ++run) {
      const double noise = 0.01 * kSigma * normal(RandomStream{.seed = draw}, run);
      const double at = gamma == nullptr ? 1 : gamma->parameters[0].value;
      table.runs.push_back({seen_at(at) + noise});
    }
    return table;
  }
};

class OutcomesFit : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = testing::TempDir() + "/outcomes_fit";
    std::filesystem::remove_all(folder_);
    std::filesystem::create_directories(folder_);
    std::ofstream(folder_ + "/one.yaml");
    std::ofstream(folder_ + "/measurement.yaml")
        << "format: seam-measurement/1\nkind: outcomes\nfiles: {outcomes: outcomes.csv}\n"
           "scenarios: {one: one.yaml}\ncandidates: {response_gamma: {gamma: [0.5, 2]}}\n";
    std::ofstream(folder_ + "/outcomes.csv")
        << "scenario,value,statistic,measured,sigma\n"
        << "one,seen,mean," << seen_at(kTruth) << "," << kSigma << "\n";
  }
  static constexpr double kTruth = 0.87;
  std::string folder_;
};

TEST_F(OutcomesFit, FindsWhatLiesAwayFromACliff) {
  Instruments instruments;
  instruments.runs = [](const RunSpec&) -> std::unique_ptr<RunMaker> {
    return std::make_unique<CliffRuns>();
  };
  OutcomesProblem problem(MeasurementSet::open(folder_), instruments);
  Model model = Model::from_config(
      ConfigNode::from_text("format: seam-model/1\nname: camera\neffects:\n"
                            "  pinhole: {fx_px: 160, fy_px: 160, cx_px: 88, cy_px: 72}\n",
                            "camera.yaml"));
  problem.prepare(model);
  model.add_neutral(effects::find_effect("response_gamma"));
  const Fit fit = problem.fit(model, {{"response_gamma", 0}}, problem.all_groups());
  // The number changes by half of what gamma does.
  EXPECT_NEAR(fit.value[0], kTruth, kSigma / 0.5);
}

}  // namespace
}  // namespace seam::measurement
