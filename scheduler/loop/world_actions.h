// What decisions and the supervisor do to the world: the same in a live run and in a re-run.
#pragma once

#include "scheduler/loop/exchange.h"
#include "sim_core/world/world.h"

namespace seam::scheduler {

// The command, and the messages over the radio.
void act_on_world(World& world, size_t robot, const Decision& decision, SimTime time);
void act_on_world(World& world, const SupervisorAction& action);

EventKind kind_of(const WorldEvent& event);

}  // namespace seam::scheduler
