// Each test projects the residual on a few smooth functions of a covariate and compares the result
// with its exact covariance under the model: sums of b' S b over the parts of S (values, samples'
// patterns, columns, rows). No inverse of S is needed, and directions that refitted parameters
// explain are projected out first, so that estimates made from the same data do not matter.
#include "measurement/kinds/photometry/structure/photometry_structure.h"

#include <Eigen/Core>
#include <algorithm>

#include "measurement/kinds/photometry/structure/photometry_mean_tests.h"
#include "measurement/kinds/photometry/structure/photometry_neighbour_tests.h"
#include "measurement/kinds/photometry/structure/photometry_spread_tests.h"
#include "measurement/kinds/photometry/structure/photometry_time_tests.h"
#include "measurement/numerics/legendre.h"
#include "measurement/numerics/regression.h"

namespace seam::measurement {
namespace {

using Eigen::VectorXd;

// Smooth functions over the image, alone and in proportion to the light.
std::vector<std::pair<std::string, PlaceBasis>> place_bases() {
  const auto series = [](double x, double scale, VectorXd& b) {
    for (int k = 0; k < 8; ++k) b[k] = scale * legendre(k + 1, x);
  };
  const auto grid = [](const SamplePlace& p, double scale, VectorXd& b) {
    int at = 0;
    for (int i = 1; i <= 3; ++i)
      for (int k = 1; k <= 3; ++k)
        if (i + k <= 5) b[at++] = scale * legendre(i, p.x) * legendre(k, p.y);
  };
  return {
      {"column", [=](const SamplePlace& p, double, VectorXd& b) { series(p.x, 1, b); }},
      {"row", [=](const SamplePlace& p, double, VectorXd& b) { series(p.y, 1, b); }},
      {"radius",
       [=](const SamplePlace& p, double, VectorXd& b) { series(2 * p.radius - 1, 1, b); }},
      {"row*column", [=](const SamplePlace& p, double, VectorXd& b) { grid(p, 1, b); }},
      {"column*illumination",
       [=](const SamplePlace& p, double g, VectorXd& b) { series(p.x, g, b); }},
      {"row*illumination", [=](const SamplePlace& p, double g, VectorXd& b) { series(p.y, g, b); }},
      {"radius*illumination",
       [=](const SamplePlace& p, double g, VectorXd& b) { series(2 * p.radius - 1, g, b); }},
      {"row*column*illumination",
       [=](const SamplePlace& p, double g, VectorXd& b) { grid(p, g, b); }},
  };
}

}  // namespace

std::vector<Structure> photometry_structure(const PhotometryView& view, const Model& model) {
  const MeanTests means(view, model);
  std::vector<StructureTest> tests;
  for (const auto& [name, basis] : place_bases()) tests.push_back(means.run(name, 8, basis));
  const auto levels = static_cast<int>(view.sums.levels.size());
  tests.push_back(means.run(
      "illumination", std::min(levels, 16), [levels](const SamplePlace& p, double, VectorXd& b) {
        // Few levels: a mean for each; many: polynomials of their order.
        if (levels <= 16)
          b[static_cast<Eigen::Index>(p.level)] = 1;
        else
          for (int k = 0; k < 16; ++k)
            b[k] = legendre(k, 2.0 * static_cast<double>(p.level) / (levels - 1) - 1);
      }));
  if (view.data.channels == 3) {
    tests.push_back(means.run("channel", 6, [](const SamplePlace& p, double g, VectorXd& b) {
      b[p.channel] = 1, b[3 + p.channel] = g;
    }));
  }
  for (const StructureTest& test : time_tests(view, means.prediction())) tests.push_back(test);
  for (const StructureTest& test : spread_tests(view, means.prediction())) tests.push_back(test);
  for (const StructureTest& test : neighbour_tests(view, means.prediction())) tests.push_back(test);
  std::vector<Structure> found;
  for (StructureTest& test : tests) {
    if (test.freedom == 0) continue;
    const double p =
        corrected(chi2_tail(test.chi2, test.freedom), static_cast<double>(tests.size()));
    if (!(p < 0.01)) continue;
    test.structure.p_value = p;
    found.push_back(test.structure);
  }
  std::stable_sort(found.begin(), found.end(),
                   [](const Structure& a, const Structure& b) { return a.strength > b.strength; });
  return found;
}

}  // namespace seam::measurement
