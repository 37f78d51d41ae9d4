#include "sim_core/scene/field.h"

#include <cmath>

#include "sim_core/base/maths.h"

namespace seam {
namespace {

constexpr Range kMetres{0, 100};
constexpr double kLineLift = 5e-4;  // Lines lie on the carpet, above it in depth.

// Adds parts with the colours of the field; each call of `object` starts a new object id.
class Builder {
 public:
  explicit Builder(uint16_t first_id) : id_(first_id) {}

  void box(Label label, const Rgb& rgb, const Vec3& centre, const Vec3& size, double yaw_rad = 0) {
    add(Shape::box, label, rgb, {rotation_zyx(0, 0, yaw_rad), centre}, size);
  }
  void flat(Label label, const Rgb& rgb, const Vec3& centre, double size_x, double size_y,
            double yaw_rad = 0) {
    add(Shape::rectangle, label, rgb, {rotation_zyx(0, 0, yaw_rad), centre}, {size_x, size_y, 0});
  }
  void cylinder(Label label, const Rgb& rgb, const Vec3& base, double radius, double height) {
    add(Shape::cylinder, label, rgb, translation(base), {radius, 0, height});
  }
  void next_object() { ++id_; }
  void add(Shape shape, Label label, const Rgb& rgb, const Pose& X_WO, const Vec3& size) {
    out_.push_back(
        {.shape = shape, .label = label, .object_id = id_, .X_WO = X_WO, .size = size, .rgb = rgb});
  }
  std::vector<Primitive> take() { return std::move(out_); }

 private:
  uint16_t id_;
  std::vector<Primitive> out_;
};

void add_carpet(Builder& build, const FieldSpec& f) {
  build.flat(Label::carpet, f.colours.carpet, {0, 0, 0},
             2 * (f.half_length_m + f.outer_wall_distance_m),
             2 * (f.half_width_m + f.outer_wall_distance_m));
  build.next_object();
}

// The centre line, the circle (as a ring of straight pieces) and the two goal areas.
void add_lines(Builder& build, const FieldSpec& f) {
  const Rgb& white = f.colours.white;
  const double z = kLineLift;
  build.flat(Label::line, white, {0, 0, z}, f.line_m, 2 * f.half_width_m);
  constexpr int kPieces = 32;
  const double radius = 0.5 * (f.centre_circle_m - f.line_m);
  const double length = 2 * 0.5 * f.centre_circle_m * maths::tan(maths::kPi / kPieces);
  for (int i = 0; i < kPieces; ++i) {
    const double angle = 2 * maths::kPi * i / kPieces;
    build.flat(Label::line, white, {radius * maths::cos(angle), radius * maths::sin(angle), z},
               f.line_m, length, angle);
  }
  for (const double side : {-1.0, 1.0}) {
    const double front = side * (f.half_length_m - f.goal_area_depth_m);
    build.flat(Label::line, white, {front, 0, z}, f.line_m, f.goal_area_width_m);
    for (const double y : {-0.5, 0.5}) {
      build.flat(Label::line, white,
                 {side * (f.half_length_m - 0.5 * f.goal_area_depth_m), y * f.goal_area_width_m, z},
                 f.goal_area_depth_m, f.line_m);
    }
    build.flat(Label::line, white, {side * (f.half_length_m - 0.5 * f.line_m), 0, z}, f.line_m,
               f.goal_width_m);
  }
  build.next_object();
}

// A sloping plate from the playing area's edge up to the wall's top.
void add_slope(Builder& build, const FieldSpec& f, const Vec3& foot_middle, double length,
               double yaw_rad) {
  const double rise = maths::atan2(f.wall_height_m, f.wall_footprint_m);
  const double width =
      std::sqrt(f.wall_height_m * f.wall_height_m + f.wall_footprint_m * f.wall_footprint_m);
  const Pose X_WF = {rotation_zyx(0, 0, yaw_rad), foot_middle};
  const Pose X_FS = {rotation_about({0, 1, 0}, -rise),
                     {0.5 * f.wall_footprint_m, 0, 0.5 * f.wall_height_m}};
  build.add(Shape::rectangle, Label::wall, f.colours.white, X_WF * X_FS, {width, length, 0});
}

void add_walls(Builder& build, const FieldSpec& f) {
  const double side_length = 0.5 * (2 * f.half_width_m - f.goal_width_m);
  for (const double side : {-1.0, 1.0}) {
    const double yaw = side > 0 ? 0 : maths::kPi;
    for (const double y : {-1.0, 1.0}) {
      add_slope(build, f, {side * f.half_length_m, y * 0.5 * (f.goal_width_m + side_length), 0},
                side_length, yaw);
    }
    add_slope(build, f, {0, side * f.half_width_m, 0}, 2 * f.half_length_m,
              side * 0.5 * maths::kPi);
  }
  build.next_object();
  // Corner triangles: the plate from leg end to leg end, as high as the walls.
  const double diagonal = f.corner_m * std::sqrt(2.0);
  for (const double x : {-1.0, 1.0}) {
    for (const double y : {-1.0, 1.0}) {
      const double yaw = maths::atan2(y, x);
      add_slope(
          build, f,
          {x * (f.half_length_m - 0.5 * f.corner_m), y * (f.half_width_m - 0.5 * f.corner_m), 0},
          diagonal, yaw);
    }
  }
  build.next_object();
  const double x = f.half_length_m + f.outer_wall_distance_m;
  const double y = f.half_width_m + f.outer_wall_distance_m;
  const double thickness = 0.02;
  for (const double side : {-1.0, 1.0}) {
    const double z = 0.5 * f.outer_wall_height_m;
    build.box(Label::wall, f.colours.white, {side * (x + 0.5 * thickness), 0, z},
              {thickness, 2 * y + 2 * thickness, f.outer_wall_height_m});
    build.box(Label::wall, f.colours.white, {0, side * (y + 0.5 * thickness), z},
              {2 * x, thickness, f.outer_wall_height_m});
  }
  build.next_object();
}

void add_beacon(Builder& build, const FieldSpec& f, double x, double y) {
  const double radius = 0.5 * f.beacon_diameter_m;
  const double band = f.beacon_band_m;
  const double low = f.beacon_height_m - 2 * band;
  Label other = Label::beacon_green;
  Rgb other_rgb = f.colours.green;
  if (x != 0) {
    const bool skyblue = (x > 0) == f.skyblue_beacons_at_skyblue_goal;
    other = skyblue ? Label::beacon_skyblue : Label::beacon_yellow;
    other_rgb = skyblue ? f.colours.skyblue : f.colours.yellow;
  }
  const bool pink_below = y > 0;
  build.cylinder(Label::beacon_white, f.colours.white, {x, y, 0}, radius, low);
  build.cylinder(pink_below ? Label::beacon_pink : other, pink_below ? f.colours.pink : other_rgb,
                 {x, y, low}, radius, band);
  build.cylinder(pink_below ? other : Label::beacon_pink, pink_below ? other_rgb : f.colours.pink,
                 {x, y, low + band}, radius, band);
  build.next_object();
}

// Two side walls and a back wall, open in front and above; sky-blue at +x.
void add_goal(Builder& build, const FieldSpec& f, double side) {
  const Label label = side > 0 ? Label::goal_skyblue : Label::goal_yellow;
  const Rgb& rgb = side > 0 ? f.colours.skyblue : f.colours.yellow;
  const double z = 0.5 * f.goal_height_m;
  const double y = 0.5 * (f.goal_width_m + f.goal_wall_m);
  for (const double s : {-1.0, 1.0}) {
    build.box(label, rgb, {side * (f.half_length_m + 0.5 * f.goal_depth_m), s * y, z},
              {f.goal_depth_m, f.goal_wall_m, f.goal_height_m});
  }
  build.box(label, rgb, {side * (f.half_length_m + f.goal_depth_m + 0.5 * f.goal_wall_m), 0, z},
            {f.goal_wall_m, f.goal_width_m + 2 * f.goal_wall_m, f.goal_height_m});
  build.next_object();
}

}  // namespace

void describe(ConfigTable& table, FieldSpec& f) {
  const auto metres = [&](const char* key, const char* help, double& value) {
    table.number({key, help}, value, kMetres);
  };
  table.format("seam-field/1");
  metres("half_length_m", "From the centre to the inside of the walls behind the goals' ends, m.",
         f.half_length_m);
  metres("half_width_m", "From the centre to the inside of the side walls, m.", f.half_width_m);
  metres("line_m", "Width of the lines, m.", f.line_m);
  metres("wall_footprint_m", "Depth of the sloping wall on the ground, m.", f.wall_footprint_m);
  metres("wall_height_m", "Height of the sloping wall, m.", f.wall_height_m);
  metres("corner_m", "Legs of the corner triangles, m.", f.corner_m);
  metres("outer_wall_height_m", "Height of the outer wall, m.", f.outer_wall_height_m);
  metres("outer_wall_distance_m", "From the playing area's edge to the outer wall, m.",
         f.outer_wall_distance_m);
  metres("beacon_x_m", "The end beacons stand at +- this, m.", f.beacon_x_m);
  metres("beacon_y_m", "All beacons stand at +- this, m.", f.beacon_y_m);
  metres("beacon_diameter_m", "Diameter of a beacon, m.", f.beacon_diameter_m);
  metres("beacon_height_m", "Top of a beacon, m.", f.beacon_height_m);
  metres("beacon_band_m", "Height of each of its two coloured bands, m.", f.beacon_band_m);
  table.boolean({"skyblue_beacons_at_skyblue_goal",
                 "Sky-blue and pink beacons stand at the sky-blue goal's end (sources disagree)."},
                f.skyblue_beacons_at_skyblue_goal);
  metres("goal_width_m", "Inside width of the goals, m.", f.goal_width_m);
  metres("goal_depth_m", "Depth of the goals, m.", f.goal_depth_m);
  metres("goal_height_m", "Height of the goals, m.", f.goal_height_m);
  metres("goal_wall_m", "Thickness of the goals' walls, m.", f.goal_wall_m);
  metres("goal_area_width_m", "Width of the goal areas, m.", f.goal_area_width_m);
  metres("goal_area_depth_m", "Depth of the goal areas, m.", f.goal_area_depth_m);
  metres("centre_circle_m", "Diameter of the centre circle, m.", f.centre_circle_m);
  table.object({"colours", "Linear radiance of each colour, red, green, blue from 0 to 1."},
               [&](ConfigTable& colours) {
                 colours.numbers({"carpet", "The carpet."}, f.colours.carpet);
                 colours.numbers({"white", "Lines and walls."}, f.colours.white);
                 colours.numbers({"pink", "Beacons."}, f.colours.pink);
                 colours.numbers({"yellow", "A goal and beacons."}, f.colours.yellow);
                 colours.numbers({"skyblue", "A goal and beacons."}, f.colours.skyblue);
                 colours.numbers({"green", "The beacons in the middle."}, f.colours.green);
                 colours.numbers({"orange", "The ball."}, f.colours.orange);
               });
}

std::vector<Primitive> field_primitives(const FieldSpec& field, uint16_t first_object_id) {
  Builder build(first_object_id);
  add_carpet(build, field);
  add_lines(build, field);
  add_walls(build, field);
  for (const double x : {-1.0, 0.0, 1.0}) {
    for (const double y : {-1.0, 1.0})
      add_beacon(build, field, x * field.beacon_x_m, y * field.beacon_y_m);
  }
  for (const double side : {-1.0, 1.0}) add_goal(build, field, side);
  return build.take();
}

}  // namespace seam
