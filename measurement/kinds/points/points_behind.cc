#include "measurement/kinds/points/points_data.h"

namespace seam::measurement {

std::vector<int> lines_behind_camera(const Model& model, const MeasurementSet& set) {
  Facts facts;
  const PointsData data = read_points(set, false, facts);
  std::vector<int> lines;
  if (data.rig.type() == Rig::Type::unknown) return lines;
  const Rig::Motion motion = data.rig.motion(model);
  for (size_t row = 0; row < data.p_W.size(); ++row) {
    if (motion.to_camera(data.stamp_s[row], data.p_W[row]).z <= 0)
      lines.push_back(facts.line_of_row[row]);
  }
  return lines;
}

}  // namespace seam::measurement
