#include "sim_core/scene/placement.h"

namespace seam {

void describe(ConfigTable& table, Placement& placement) {
  const Range place{-1e6, 1e6}, turn{-7, 7};
  Vec3 &at = placement.place_m, &turns = placement.roll_pitch_yaw_rad;
  table.number({"x_m", "Of its origin, m."}, at.x, place);
  table.number({"y_m", "Of its origin, m."}, at.y, place);
  table.number({"z_m", "Of its origin, m."}, at.z, place);
  table.number({"roll_rad", "The first turn, about x, rad."}, turns.x, turn);
  table.number({"pitch_rad", "Then about y, rad."}, turns.y, turn);
  table.number({"yaw_rad", "Then about z, rad."}, turns.z, turn);
}

}  // namespace seam
