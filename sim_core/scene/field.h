// The field: carpet, lines, walls, beacons and goals, read from a file of format seam-field/1
// (models/field_2002.yaml).
#pragma once

#include <vector>

#include "sim_core/input/config_table.h"
#include "sim_core/scene/scene.h"

namespace seam {

struct FieldColours {
  Rgb carpet{0.04, 0.3, 0.07};
  Rgb white{0.85, 0.85, 0.82};
  Rgb pink{0.85, 0.25, 0.45};
  Rgb yellow{0.85, 0.7, 0.05};
  Rgb skyblue{0.1, 0.45, 0.75};
  Rgb green{0.03, 0.45, 0.2};
  Rgb orange{0.9, 0.28, 0.02};
};

struct FieldSpec {
  double half_length_m = 2.1;  // Playing area, to the inside of the walls.
  double half_width_m = 1.35;
  double line_m = 0.025;
  double wall_footprint_m = 0.1;
  double wall_height_m = 0.1;
  double corner_m = 0.3;  // Legs of the corner triangles.
  double outer_wall_height_m = 0.3;
  double outer_wall_distance_m = 0.3;  // From the playing area's edge.
  double beacon_x_m = 2.2;
  double beacon_y_m = 1.45;
  double beacon_diameter_m = 0.1;
  double beacon_height_m = 0.4;
  double beacon_band_m = 0.1;
  bool skyblue_beacons_at_skyblue_goal = true;  // Sources disagree which end is which.
  double goal_width_m = 0.6;
  double goal_depth_m = 0.3;
  double goal_height_m = 0.3;
  double goal_wall_m = 0.02;
  double goal_area_width_m = 1.0;
  double goal_area_depth_m = 0.5;
  double centre_circle_m = 0.3;  // Diameter.
  FieldColours colours;
};

void describe(ConfigTable& table, FieldSpec& field);

// The field's parts; nothing of it moves. Object ids count up from `first_object_id`.
std::vector<Primitive> field_primitives(const FieldSpec& field, uint16_t first_object_id);

}  // namespace seam
