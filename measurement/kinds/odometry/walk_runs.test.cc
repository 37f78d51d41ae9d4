#include <gtest/gtest.h>

#include "measurement/kinds/odometry/odometry.h"
#include "sim_core/base/random.h"

namespace seam::measurement {
namespace {

TEST(WalkRuns, NoiseIsFoundWithAndWithoutARandomWalk) {
  const RandomStream random{4, 1};
  for (const double step : {0.0, 0.004}) {
    WalkRun run;
    double slip = 0;
    for (int k = 0; k < 6000; ++k) {
      slip += step * normal(random, 10 * k);
      run.time_s.push_back(0.2 * k);
      run.command.push_back({0.1, 0, 0});
      run.pose.push_back({0.02 * k + slip + 0.002 * normal(random, 10 * k + 1),
                          slip + 0.002 * normal(random, 10 * k + 2),
                          0.003 * normal(random, 10 * k + 3)});
    }
    const auto noise = noise_of_walks({run});
    EXPECT_NEAR(noise[0], 0.002, 0.0003) << step;
    EXPECT_NEAR(noise[2], 0.003, 0.0003) << step;
  }
}

}  // namespace
}  // namespace seam::measurement
