#include "sim_core/body/robot_body.h"

#include <algorithm>

#include "sim_core/body/urdf.h"

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
const std::vector<std::string> kShapeNames = {"rectangle", "sphere", "cylinder",
                                              "capsule",   "box",    "mesh"};
constexpr Range kMetres{0, 2};
constexpr Range kAngle{-7, 7};
constexpr size_t kMaxParts = 512;
constexpr size_t kMaxLinks = 256;

void describe_part(ConfigTable& table, const std::vector<std::string>& links, BodyPart& part) {
  const bool all = table.names_alternatives();
  const ConfigKey link{"link", "The link that the part is fixed to.", true};
  std::string any;
  if (all)
    table.text(link, any);
  else
    table.choice(link, part.link, links);
  table.choice_of({"shape", "Its shape.", true}, part.shape, kShapeNames);
  table.vec3(
      {"centre_m",
       "Where it is in the link's frame; a capsule or cylinder starts here and extends along z."},
      part.centre_m);
  table.vec3({"rotate_rad", "How it is turned in the link: Rz(z) Ry(y) Rx(x)."}, part.rotate_rad);
  const bool is_mesh = part.shape == Shape::mesh;
  if (all || !is_mesh) {
    table.vec3(
        {"size_m", "Box: edges. Sphere: radius first. Capsule, cylinder: radius, 0, height.", !all},
        part.size_m);
  }
  if (all || is_mesh) {
    table.file_name(
        {"file", "Of a mesh: a glTF, OBJ, STL or COLLADA file in this file's folder.", !all},
        part.mesh);
    table.number({"scale", "Of a mesh: metres for a unit of its file."}, part.scale, {1e-6, 1e6});
  }
  table.choice_of({"paint", "body: the robot's own colour; team: its uniform; own: the part's."},
                  part.paint, {"body", "team", "own"});
  if (all || part.paint == Paint::own)
    table.numbers({"rgb", "The part's own colour, linear 0 to 1; of a mesh a factor."}, part.rgb);
}

// A file that another program made, and what it does not say.
void describe_urdf(ConfigTable& table, RobotBody& body) {
  FileName urdf;
  std::map<std::string, std::string> packages;
  table.file_name({"urdf", "A URDF file in this file's folder, in place of all below."}, urdf);
  if (table.names_alternatives() || !urdf.name.empty()) {
    table.texts_by_name(
        {"packages", "Folders in this file's folder by the names of package:// addresses."},
        packages);
  }
  if (!urdf.name.empty()) body = body_from_urdf(urdf, packages);
}

void describe_camera_place(ConfigTable& table, KinematicTree& tree) {
  table.text({"link", "The link that holds it; the first where not given."}, tree.camera_link);
  table.vec3({"translate_m", "Where it is in that link's frame, m."}, tree.camera_translate_m);
  table.vec3(
      {"rotate_rad", "How it is turned there, Rz(z) Ry(y) Rx(x): it looks along x, z is up."},
      tree.camera_rotate_rad);
  table.boolean({"sees_own_link", "Whether its own link's parts are in its pictures."},
                tree.sees_own_link);
}

// What a robot of any build has beside its parts.
void describe_tree(ConfigTable& table, RobotBody& body) {
  KinematicTree& tree = body.tree;
  if (!tree.present() && table.writes()) return;
  table.list(
      {"links", "Of a robot of any build: its links, each after the one that it hangs on."},
      tree.links.size(), kMaxLinks,
      [&](size_t count) {
        body = RobotBody{};  // Nothing of another robot's stays.
        tree.links.resize(count);
      },
      [&](ConfigTable& t, size_t i) { describe(t, tree.links[i]); });
  if (!tree.present() && !table.names_alternatives()) return;
  table.object({"camera", "Of a robot of any build: where its camera is."},
               [&](ConfigTable& t) { describe_camera_place(t, tree); });
  table.boolean({"moves", "Of a robot of any build: whether walk commands move its base."},
                body.moves);
  table.number({"base_height_m", "Of a robot of any build: its first link over the ground, m."},
               body.base_height_m, {-10, 10});
  const auto wrong = tree.connect();
  table.require(!wrong, "links", wrong.value_or(""));
  for (size_t j = 0; j < tree.joint_count(); ++j) body.joints[j] = tree.joint(j).limits;
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

const std::string& shape_name(Shape shape) {
  return kShapeNames.at(static_cast<size_t>(shape));
}

const KickSpec& RobotBody::kick(Kick kick) const {
  static const KickSpec kNone;
  const auto index = static_cast<size_t>(kick);
  return index >= 1 && index <= kicks.size() ? kicks[index - 1] : kNone;
}

std::string RobotBody::joint_name(size_t joint) const {
  return tree.present() ? tree.joint(joint).joint : std::string(kJointNames[joint]);
}

namespace {

void describe_ers210(ConfigTable& table, RobotBody& body) {
  table.object({"head", "The head's chain: tilt, pan, roll, camera."}, [&](ConfigTable& head) {
    head.vec3({"tilt_axis_m", "Where the tilt axis is in the body's frame, m."}, body.tilt_axis_m);
    head.number({"roll_height_m", "From the pan axis' foot up to the roll centre, m."},
                body.roll_height_m, kMetres);
    head.number({"camera_forward_m", "From the roll centre forward to the camera, m."},
                body.camera_forward_m, kMetres);
  });
  table.object({"legs", "The legs' sizes."}, [&](ConfigTable& legs) { describe_legs(legs, body); });
  const bool required = !table.names_alternatives();
  table.object(
      {"joints", "Range and top speed of each joint.", required}, [&](ConfigTable& joints) {
        for (int j = 0; j < kJoints; ++j) {
          joints.object({kJointNames[static_cast<size_t>(j)].data(), "Range and top speed.", true},
                        [&](ConfigTable& joint) {
                          describe_joint(joint, body.joints[static_cast<size_t>(j)]);
                        });
        }
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
}

void describe_walk(ConfigTable& table, RobotBody& body) {
  table.object({"gait", "The trot."}, [&](ConfigTable& gait) { describe_gait(gait, body.gait); });
  table.object({"footprint", "The box that collides with others, m."}, [&](ConfigTable& box) {
    box.number({"length_m", "Along the body."}, body.footprint_length_m, {0.01, 2});
    box.number({"width_m", "Across the body."}, body.footprint_width_m, {0.01, 2});
    box.number({"x_m", "Its centre, forward of the body's origin."}, body.footprint_x_m, {-1, 1});
  });
}

void describe_looks(ConfigTable& table, RobotBody& body) {
  table.numbers({"body_rgb", "The robot's own colour, linear 0 to 1."}, body.body_rgb);
  table.numbers({"red_rgb", "The red uniform, linear 0 to 1."}, body.red_rgb);
  table.numbers({"blue_rgb", "The dark blue uniform, linear 0 to 1."}, body.blue_rgb);
  std::vector<std::string> links = kLinkNames;
  if (body.tree.present()) {
    links.clear();
    for (const TreeLink& link : body.tree.links) links.push_back(link.name);
  }
  table.list(
      {"parts", "What it looks like."}, body.parts.size(), kMaxParts,
      [&](size_t count) { body.parts.resize(count); },
      [&](ConfigTable& part, size_t i) { describe_part(part, links, body.parts[i]); });
}

}  // namespace

void describe(ConfigTable& table, RobotBody& body) {
  table.format("seam-robot/1");
  describe_urdf(table, body);
  describe_tree(table, body);
  table.text({"name", "What kind of robot it is."}, body.name);
  table.number({"mass_kg", "Mass, kg."}, body.mass_kg, {0.01, 1000});
  if (!body.tree.present()) describe_ers210(table, body);
  describe_walk(table, body);
  describe_looks(table, body);
}

}  // namespace seam
