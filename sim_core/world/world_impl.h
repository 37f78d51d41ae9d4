// The inside of World: world.cc moves it, world_scene.cc shows it.
#pragma once

#include <optional>
#include <vector>

#include "sim_core/world/ball_play.h"
#include "sim_core/world/physics.h"
#include "sim_core/world/robot.h"
#include "sim_core/world/robot_figure.h"
#include "sim_core/world/world.h"

namespace seam {

class World::Impl {
 public:
  Impl(const Scenario& scenario, const RobotPartsFactory& parts);
  Impl(const Impl&) = delete;

  // Of the current interval, 0 to 1.
  double fraction(SimTime time) const;
  Vec3 ball_at(SimTime time) const;

  void step();
  void place_robot(size_t robot, const Pose2& pose, bool on_field);
  void place_ball(double x_m, double y_m, double vx_mps, double vy_mps);
  // Lets the sensors of a robot sample all that is due after `since` and up to `time`.
  void sample(SensorSuite& suite, size_t robot, SimTime time, SimTime since) const;
  // Ticks up to and including start() have been sampled; none before the first step.
  SimTime sampled_until() const { return end == start ? SimTime::from_ns(-1) : start; }
  std::vector<Pose2> places(SimTime time) const;

  void make_scenery();
  void add_objects(SimTime time, std::vector<Primitive>& out) const;
  void add_ball(SimTime time, std::vector<Primitive>& out) const;
  Posture posture_of(size_t robot, SimTime time) const;
  bool behind(const Pose& X_WL, size_t robot, SimTime time) const;

  // Calls `section(name, visit)` for each part of the state, in the stated order.
  template <class Section>
  void for_each_section(Section section) {
    section("clock", [&](StateVisitor& v) {
      v.field("start", start);
      v.field("end", end);
    });
    section("ball", [&](StateVisitor& v) { visit_ball(v); });
    section("ball_play", [&](StateVisitor& v) { ball_play.visit(v); });
    section("referee", [&](StateVisitor& v) { referee.visit(v); });
    section("radio", [&](StateVisitor& v) { radio.visit(v); });
    for (size_t i = 0; i < robots.size(); ++i) {
      section("robot/" + robots[i].spec().id, [&](StateVisitor& v) {
        bodies.robots[i].visit(v);
        robots[i].visit(v);
      });
      section("sensors/" + robots[i].spec().id, [&](StateVisitor& v) { sensors[i].visit(v); });
    }
  }

  Scenario scenario;
  SimTime start, end;
  std::vector<Robot> robots;
  std::vector<SensorSuite> sensors;
  std::optional<size_t> sensed;  // The only robot whose sensors are read; empty: all are.
  bool is_sensed(size_t robot) const { return !sensed || *sensed == robot; }
  SimDuration longest_turn;       // Between a robot's observations, at most.
  PhysicsState bodies;            // At `end`.
  std::vector<Vec3> ball_points;  // At the ends of the interval's physics steps.
  int64_t last_touch = -1;        // Robot that touched the ball last.
  // Of each robot with the ball, for events; the world does not move by it. Nothing: no contact.
  struct BallTouch {
    SimTime begin, last;
  };
  std::vector<std::optional<BallTouch>> touches;
  Physics physics;
  BallPlay ball_play;
  Referee referee;
  Radio radio;
  std::vector<Primitive> scenery;  // The field, and objects up to the first that moves.
  struct MovingPart {
    Primitive at_zero;
    Vec3 velocity_mps;
  };
  std::vector<MovingPart> objects;       // The scenario's, from the first that moves on.
  std::vector<RobotFigure> figures;      // Of each robot as others see it,
  std::vector<RobotFigure> own_figures;  // and as its own camera does.
  std::vector<WorldEvent> events;

 private:
  void visit_ball(StateVisitor& visitor);
  void follow_referee();
  void drive_robots(int64_t substep, SimTime time, SimDuration h);
  void find_limbs();
  void move_limbs(SimTime time, SimDuration h);
  void note_touches();
  void note_contacts();
};

}  // namespace seam
