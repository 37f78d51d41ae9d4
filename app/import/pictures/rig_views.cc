#include "app/import/pictures/rig_views.h"

#include <fmt/ranges.h>

#include <algorithm>
#include <limits>
#include <map>
#include <set>

#include "app/import/pictures/picture_times.h"
#include "sim_core/base/error.h"

namespace seam::app {
namespace {

using Frame = std::vector<SeenView>;

// Of one camera, the shortest time from one view to the next.
int64_t shortest_gap_ns(const std::vector<CameraViews>& cameras) {
  int64_t least = std::numeric_limits<int64_t>::max();
  for (const CameraViews& camera : cameras) {
    for (size_t i = 1; i < camera.views.size(); ++i)
      least = std::min(least, camera.views[i].time_ns - camera.views[i - 1].time_ns);
  }
  return least;
}

bool holds(const Frame& frame, const std::string& camera) {
  return std::any_of(frame.begin(), frame.end(),
                     [&](const SeenView& view) { return view.camera == camera; });
}

std::vector<Frame> frames_by_time(std::vector<SeenView> views, int64_t gap_ns, SetDraft& draft) {
  std::stable_sort(views.begin(), views.end(),
                   [](const SeenView& a, const SeenView& b) { return a.time_ns < b.time_ns; });
  std::vector<Frame> frames;
  int64_t most_ns = 0;
  for (SeenView& view : views) {
    // Nearer to this frame's time than to that of the next.
    const bool joins = !frames.empty() && !holds(frames.back(), view.camera) &&
                       view.time_ns - frames.back().front().time_ns < gap_ns / 2;
    if (joins)
      most_ns = std::max(most_ns, view.time_ns - frames.back().front().time_ns);
    else
      frames.emplace_back();
    frames.back().push_back(std::move(view));
  }
  if (most_ns > 0)
    draft.did(fmt::format("the stamps of one frame are up to {:.3g} ms apart", 1e-6 * most_ns));
  return frames;
}

// The picture's name without the camera's.
std::string instant_of(const SeenView& view) {
  std::string name = view.name;
  const size_t at = name.find(view.camera);
  if (at != std::string::npos) name.erase(at, view.camera.size());
  return name;
}

std::vector<Frame> frames_by_name(std::vector<SeenView> views, SameFrame by) {
  std::map<std::string, Frame> by_instant;
  std::vector<std::filesystem::path> order;
  for (SeenView& view : views) {
    const std::string instant = by == SameFrame::name ? view.name : instant_of(view);
    Frame& frame = by_instant[instant];
    if (frame.empty()) order.emplace_back(instant);
    if (holds(frame, view.camera))
      throw InputError(fmt::format("two pictures of camera '{}' are called '{}' but for its name",
                                   view.camera, instant));
    frame.push_back(std::move(view));
  }
  sort_by_number(order);
  std::vector<Frame> frames;
  for (const auto& instant : order) {
    frames.push_back(std::move(by_instant[instant.string()]));
    for (SeenView& view : frames.back()) view.name = instant.string();
  }
  return frames;
}

void check_shared(const std::vector<CameraViews>& cameras, const std::vector<Frame>& frames,
                  SetDraft& draft) {
  std::map<std::string, size_t> shared;
  size_t together = 0;
  for (const Frame& frame : frames) {
    together += frame.size() > 1 ? 1 : 0;
    for (const SeenView& view : frame) shared[view.camera] += frame.size() > 1 ? 1 : 0;
  }
  for (const CameraViews& camera : cameras) {
    if (shared[camera.name] == 0)
      throw InputError(fmt::format(
          "camera '{}' saw the target in no frame together with another camera, expected the "
          "same time, or the same name but for the camera's",
          camera.name));
  }
  draft.did(fmt::format("{} frames, {} of them seen by several cameras", frames.size(), together));
}

}  // namespace

std::vector<std::string> cameras_in(const std::string& words) {
  std::vector<std::string> names;
  for (size_t from = 0; from <= words.size();) {
    const size_t comma = std::min(words.find(',', from), words.size());
    names.push_back(words.substr(from, comma - from));
    from = comma + 1;
  }
  const std::set<std::string> distinct(names.begin(), names.end());
  if (names.size() > 1 && (distinct.size() < names.size() || distinct.contains("")))
    throw UsageError(fmt::format("--camera {}: expected names, each once, as left,right", words));
  return names;
}

std::vector<SeenView> views_of_rig(std::vector<CameraViews> cameras, SameFrame by,
                                   SetDraft& draft) {
  const int64_t gap_ns = shortest_gap_ns(cameras);
  std::vector<SeenView> all;
  for (CameraViews& camera : cameras) {
    for (SeenView& view : camera.views) {
      view.camera = camera.name;
      all.push_back(std::move(view));
    }
  }
  const std::vector<Frame> frames = by == SameFrame::time
                                        ? frames_by_time(std::move(all), gap_ns, draft)
                                        : frames_by_name(std::move(all), by);
  check_shared(cameras, frames, draft);
  std::vector<SeenView> views;
  for (const Frame& frame : frames) {
    for (SeenView view : frame) {
      view.name = frame.front().name;
      views.push_back(std::move(view));
    }
  }
  return views;
}

}  // namespace seam::app
