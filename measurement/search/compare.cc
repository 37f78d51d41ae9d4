#include "measurement/search/compare.h"

namespace seam::measurement {

CompareResult compare(Problem& problem, const Model& model, double material) {
  problem.check_model(model);
  problem.prepare(model);
  CompareResult result;
  SearchResult marks;
  problem.leave_out({});
  Assessment assessment = assess(problem, model, refitted_unknowns(model));
  check_enough(problem, assessment);
  for (int round = 0; round < kOutlierRounds && mark_outliers(problem, assessment.model, marks);
       ++round) {
    assessment = assess(problem, model, refitted_unknowns(model));
  }
  result.outliers = marks.outliers;
  result.outlier_share = marks.outlier_share;
  result.base.assessment = std::move(assessment);
  SplitStructure found = significant_structure(problem, result.base.assessment, material);
  result.structure = std::move(found.material);
  result.traces = std::move(found.traces);
  result.material = material;
  return result;
}

}  // namespace seam::measurement
