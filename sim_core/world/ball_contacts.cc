// Who touches the ball: the last one is part of the state, and contacts are events.
#include <algorithm>

#include "sim_core/base/error.h"
#include "sim_core/world/world_impl.h"

namespace seam {
namespace {

// A contact ends when its robot has not touched the ball for so long: a ball that is pushed leaves
// the paws for moments.
constexpr SimDuration kContactGap = SimDuration::from_ns(200'000'000);

}  // namespace

void World::Impl::note_touches() {
  for (const BallContact& contact : physics.ball_contacts()) {
    const auto robot = static_cast<int64_t>(contact.robot);
    if (robot == last_touch) continue;
    last_touch = robot;
    events.push_back({end, kOldTouch, static_cast<int>(robot), ""});
  }
  note_contacts();
}

void World::Impl::note_contacts() {
  touches.resize(robots.size());
  for (const BallContact& contact : physics.ball_contacts()) {
    std::optional<BallTouch>& touch = touches[contact.robot];
    if (!touch) {
      touch = {end, end};
      events.push_back({end, kContact, static_cast<int>(contact.robot), ""});
    }
    touch->last = end;
  }
  for (size_t i = 0; i < touches.size(); ++i) {
    if (!touches[i] || end - touches[i]->last < kContactGap) continue;
    events.push_back(
        {end, kContactEnd, static_cast<int>(i),
         fmt::format("from {:.3f} s to {:.3f} s", touches[i]->begin.s(), touches[i]->last.s())});
    touches[i].reset();
  }
}

}  // namespace seam
