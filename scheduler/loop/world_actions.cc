#include "scheduler/loop/world_actions.h"

namespace seam::scheduler {

void act_on_world(World& world, size_t robot, const Decision& decision, SimTime time) {
  world.apply(robot, decision.command, time);
  for (const std::string& message : decision.messages) world.send_radio(robot, message, time);
}

void act_on_world(World& world, const SupervisorAction& action) {
  switch (action.kind) {
    case SupervisorAction::Kind::place_ball:
      world.place_ball(action.position_m.x, action.position_m.y, action.velocity_m_s.x,
                       action.velocity_m_s.y);
      break;
    case SupervisorAction::Kind::place_robot:
      world.place_robot(static_cast<size_t>(action.robot),
                        {action.position_m.x, action.position_m.y, action.heading_rad});
      break;
    case SupervisorAction::Kind::set_game_state:
      world.set_play_state(static_cast<PlayState>(action.game_state));
      break;
  }
}

EventKind kind_of(const WorldEvent& event) {
  switch (event.source) {
    case WorldEvent::Source::referee:
      return EventKind::referee;
    case WorldEvent::Source::radio:
      return EventKind::radio;
    case WorldEvent::Source::world:
      break;
  }
  return EventKind::world;
}

}  // namespace seam::scheduler
