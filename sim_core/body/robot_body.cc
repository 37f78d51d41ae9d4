#include "sim_core/body/robot_body.h"

namespace seam {
namespace {

const std::vector<std::string> kLinkNames = {"body",
                                             "neck",
                                             "head",
                                             "left_front_upper",
                                             "left_front_lower",
                                             "right_front_upper",
                                             "right_front_lower",
                                             "left_hind_upper",
                                             "left_hind_lower",
                                             "right_hind_upper",
                                             "right_hind_lower"};
const std::vector<std::string> kShapeNames = {"rectangle", "sphere", "cylinder", "capsule", "box"};
constexpr Range kMetres{0, 2};
constexpr Range kAngle{-7, 7};
constexpr size_t kMaxParts = 64;

void describe_part(ConfigTable& table, BodyPart& part) {
  table.choice_of({"link", "The link that the part is fixed to.", true}, part.link, kLinkNames);
  table.choice_of({"shape", "Its shape.", true}, part.shape, kShapeNames);
  table.vec3(
      {"centre_m",
       "Where it is in the link's frame; a capsule or cylinder starts here and extends along z."},
      part.centre_m);
  table.vec3({"rotate_rad", "How it is turned in the link: Rz(z) Ry(y) Rx(x)."}, part.rotate_rad);
  table.vec3(
      {"size_m", "Box: edges. Sphere: radius first. Capsule, cylinder: radius, 0, height.", true},
      part.size_m);
  table.choice_of({"paint", "body: the robot's own colour; team: its uniform."}, part.paint,
                  {"body", "team"});
}

void describe_joint(ConfigTable& table, JointLimits& joint) {
  table.number({"min_rad", "Lowest angle, rad.", true}, joint.min_rad, kAngle);
  table.number({"max_rad", "Highest angle, rad.", true}, joint.max_rad, kAngle);
  table.number({"speed_radps", "Top speed, rad/s.", true}, joint.speed_radps, {1e-3, 100});
  table.require(joint.min_rad < joint.max_rad, "max_rad", "expected more than min_rad");
}

void describe_gait(ConfigTable& table, Gait& gait) {
  table.number({"step_s", "Duration of a whole stride, s."}, gait.step_s, {0.1, 5});
  table.number({"max_vx_mps", "Top speed forwards, m/s."}, gait.max_vx_mps, {0, 5});
  table.number({"max_vy_mps", "Top speed sideways, m/s."}, gait.max_vy_mps, {0, 5});
  table.number({"max_omega_radps", "Top turning speed, rad/s."}, gait.max_omega_radps, {0, 20});
  table.number({"stance_rotator_rad", "Rotators when standing."}, gait.stance_rotator_rad, kAngle);
  table.number({"stance_elevator_rad", "Elevators when standing."}, gait.stance_elevator_rad,
               kAngle);
  table.number({"stance_knee_rad", "Knees when standing."}, gait.stance_knee_rad, kAngle);
  table.number({"lift_knee_rad", "Extra bend of the knee in mid-swing."}, gait.lift_knee_rad,
               {0, 3});
  table.number({"settle_s", "Time constant with which strides grow and fade, s."}, gait.settle_s,
               {0.001, 5});
}

void describe_reach(ConfigTable& table, Reach& reach) {
  const Range range{-1, 1};
  table.number({"min_x_m", "Hindmost, m.", true}, reach.min_x_m, range);
  table.number({"max_x_m", "Foremost, m.", true}, reach.max_x_m, range);
  table.number({"min_y_m", "Rightmost, m.", true}, reach.min_y_m, range);
  table.number({"max_y_m", "Leftmost, m.", true}, reach.max_y_m, range);
}

void describe_motion(ConfigTable& table, KickMotion& motion) {
  std::vector<std::string> names(kJointNames.begin(), kJointNames.end());
  table.number({"at_s", "After the kick's start, s.", true}, motion.at_s, {0, 10});
  table.choice({"joint", "Which joint.", true}, motion.joint, names);
  table.number({"angle_rad", "Where it goes, rad.", true}, motion.angle_rad, kAngle);
}

void describe_kick(ConfigTable& table, KickSpec& kick) {
  table.number({"duration_s", "How long the robot stands still for it, s.", true}, kick.duration_s,
               {0.001, 10});
  table.number({"impact_s", "When the ball is hit, s.", true}, kick.impact_s, {0, 10});
  table.object({"reach", "Where the ball's centre must be then, in the body's frame.", true},
               [&](ConfigTable& t) { describe_reach(t, kick.reach); });
  table.number({"speed_mps", "What the ball gets, m/s.", true}, kick.speed_mps, {0, 20});
  table.number({"direction_rad", "From straight ahead, counter-clockwise, rad."},
               kick.direction_rad, kAngle);
  table.number({"speed_sigma", "Spread of the speed, relative."}, kick.speed_sigma, {0, 1});
  table.number({"direction_sigma_rad", "Spread of the direction, rad."}, kick.direction_sigma_rad,
               {0, 3});
  table.list(
      {"motion", "What the joints do, in order of time."}, kick.motion.size(), 100,
      [&](size_t count) { kick.motion.resize(count); },
      [&](ConfigTable& t, size_t i) { describe_motion(t, kick.motion[i]); });
}

void describe_legs(ConfigTable& table, RobotBody& body) {
  table.number({"shoulder_x_m", "Shoulders at +- this along the body, m."}, body.shoulder_x_m,
               kMetres);
  table.number({"shoulder_y_m", "Shoulders at +- this across the body, m."}, body.shoulder_y_m,
               kMetres);
  table.number({"upper_m", "Shoulder to knee, m."}, body.upper_leg_m, kMetres);
  table.number({"upper_offset_m", "Knee forward of the upper leg's line, m."},
               body.upper_leg_offset_m, kMetres);
  table.number({"lower_front_m", "Knee to paw in front, m."}, body.lower_front_m, kMetres);
  table.number({"lower_hind_m", "Knee to paw behind, m."}, body.lower_hind_m, kMetres);
  table.number({"paw_radius_m", "Radius of a paw, m."}, body.paw_radius_m, kMetres);
}

}  // namespace

const KickSpec& RobotBody::kick(Kick kick) const {
  static const KickSpec kNone;
  const auto index = static_cast<size_t>(kick);
  return index >= 1 && index <= kicks.size() ? kicks[index - 1] : kNone;
}

void describe(ConfigTable& table, RobotBody& body) {
  table.format("seam-robot/1");
  table.text({"name", "What kind of robot it is."}, body.name);
  table.number({"mass_kg", "Mass, kg."}, body.mass_kg, {0.01, 1000});
  table.object({"head", "The head's chain: tilt, pan, roll, camera."}, [&](ConfigTable& head) {
    head.vec3({"tilt_axis_m", "Where the tilt axis is in the body's frame, m."}, body.tilt_axis_m);
    head.number({"roll_height_m", "From the pan axis' foot up to the roll centre, m."},
                body.roll_height_m, kMetres);
    head.number({"camera_forward_m", "From the roll centre forward to the camera, m."},
                body.camera_forward_m, kMetres);
  });
  table.object({"legs", "The legs' sizes."}, [&](ConfigTable& legs) { describe_legs(legs, body); });
  table.object({"joints", "Range and top speed of each joint.", true}, [&](ConfigTable& joints) {
    for (int j = 0; j < kJoints; ++j) {
      joints.object(
          {kJointNames[static_cast<size_t>(j)].data(), "Range and top speed.", true},
          [&](ConfigTable& joint) { describe_joint(joint, body.joints[static_cast<size_t>(j)]); });
    }
  });
  table.object({"gait", "The trot."}, [&](ConfigTable& gait) { describe_gait(gait, body.gait); });
  table.object({"footprint", "The box that collides with others, m."}, [&](ConfigTable& box) {
    box.number({"length_m", "Along the body."}, body.footprint_length_m, {0.01, 2});
    box.number({"width_m", "Across the body."}, body.footprint_width_m, {0.01, 2});
    box.number({"x_m", "Its centre, forward of the body's origin."}, body.footprint_x_m, {-1, 1});
  });
  table.object({"kicks", "Kicks by name."}, [&](ConfigTable& kicks) {
    for (size_t i = 0; i < body.kicks.size(); ++i) {
      const std::string name = to_string(static_cast<Kick>(i + 1));
      kicks.object({name.c_str(), "A kick."},
                   [&](ConfigTable& t) { describe_kick(t, body.kicks[i]); });
    }
  });
  table.object({"grab", "Where a ball can be grabbed."},
               [&](ConfigTable& t) { describe_reach(t, body.grab); });
  table.number({"hold_x_m", "Where a held ball's centre is, forward of the body's origin, m."},
               body.hold_x_m, {-1, 1});
  table.numbers({"body_rgb", "The robot's own colour, linear 0 to 1."}, body.body_rgb);
  table.numbers({"red_rgb", "The red uniform, linear 0 to 1."}, body.red_rgb);
  table.numbers({"blue_rgb", "The dark blue uniform, linear 0 to 1."}, body.blue_rgb);
  table.list(
      {"parts", "What it looks like."}, body.parts.size(), kMaxParts,
      [&](size_t count) { body.parts.resize(count); },
      [&](ConfigTable& part, size_t i) { describe_part(part, body.parts[i]); });
}

}  // namespace seam
