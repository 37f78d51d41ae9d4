// `seam import images`: pictures of a calibration target, in which `seam-pictures` finds its
// points.
#include <fmt/ranges.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <map>

#include "app/import/draft/points_draft.h"
#include "app/import/kinds/kinds.h"
#include "app/import/pictures/finder.h"
#include "app/import/pictures/picture_sources.h"
#include "app/import/pictures/picture_times.h"
#include "app/import/pictures/rig_views.h"
#include "app/import/pictures/scatter.h"
#include "measurement/kinds/points/data/points_noise.h"
#include "measurement/numerics/robust.h"
#include "sim_core/base/error.h"

namespace seam::app {
namespace {

constexpr size_t kFewestCorners = 6;  // That say anything of a view.

// Pictures that say nothing, by why.
class LeftOut {
 public:
  void add(const std::string& name, const std::string& why) {
    const size_t colon = why.find(": ");
    std::string& list = named_[why.substr(0, colon)];
    size_t& count = counts_[why.substr(0, colon)];
    if (colon != std::string::npos) ++details_[why.substr(0, colon)][why.substr(colon + 2)];
    if (++count <= 4)
      list += (list.empty() ? "" : ", ") + name +
              (colon == std::string::npos ? "" : " (" + why.substr(colon + 2) + ")");
    ++all_;
  }
  size_t all() const { return all_; }
  // What many show in place of what was asked for, where the first few do not say it.
  std::string commonest(const std::string& why) const {
    const auto found = details_.find(why);
    if (found == details_.end() || found->second.size() < 2) return "";
    const auto most =
        std::max_element(found->second.begin(), found->second.end(),
                         [](const auto& a, const auto& b) { return a.second < b.second; });
    return most->second < 3
               ? ""
               : fmt::format("; most often {}, in {} pictures", most->first, most->second);
  }
  std::vector<std::string> sentences(size_t pictures) const {
    std::vector<std::string> result;
    for (const auto& [why, list] : named_) {
      const size_t count = counts_.at(why);
      result.push_back(fmt::format("{} of {} pictures left out, {}: {}{}{}", count, pictures, why,
                                   list, count > 4 ? fmt::format(" and {} more", count - 4) : "",
                                   commonest(why)));
    }
    return result;
  }

 private:
  std::map<std::string, std::string> named_;
  std::map<std::string, size_t> counts_;
  std::map<std::string, std::map<std::string, size_t>> details_;
  size_t all_ = 0;
};

// The size that most of the pictures with a target have.
std::pair<int, int> usual_size(const std::vector<PictureAnswer>& answers) {
  std::map<std::pair<int, int>, size_t> counts;
  for (const PictureAnswer& answer : answers) {
    if (answer.without.empty()) ++counts[{answer.width_px, answer.height_px}];
  }
  std::pair<int, int> usual{0, 0};
  size_t most = 0;
  for (const auto& [size, count] : counts) {
    if (count > most) usual = size, most = count;
  }
  return usual;
}

// Why a picture with a target is not taken all the same; empty where it is.
std::string fault_of(const PictureAnswer& answer, std::pair<int, int> size, double usual_edge_px) {
  constexpr double kWide_px = 4;
  if (!answer.without.empty()) return answer.without;
  if (std::pair(answer.width_px, answer.height_px) != size)
    return fmt::format("of another size: {} x {} px", answer.width_px, answer.height_px);
  if (answer.edge_px > std::max(kWide_px, 2.5 * usual_edge_px))
    return fmt::format("blurred: edges of {:.1f} px", answer.edge_px);
  if (answer.points.size() < kFewestCorners)
    return fmt::format("part of the target: {} corners", answer.points.size());
  return "";
}

void tell_progress(size_t done, size_t all) {
  if (isatty(STDERR_FILENO) != 0) {
    std::fprintf(stderr, "\r%zu of %zu pictures%s", done, all, done == all ? "\n" : "");
  } else if (done % 200 == 0 && all > 200) {
    std::fprintf(stderr, "%zu of %zu pictures\n", done, all);
  }
}

std::vector<SeenView> views_of(const CameraPictures& camera,
                               const std::vector<PictureAnswer>& answers, const TargetSpec& target,
                               SetDraft& draft, LeftOut& left_out) {
  std::vector<double> edges;
  for (const PictureAnswer& answer : answers) {
    if (answer.edge_px > 0) edges.push_back(answer.edge_px);
  }
  const auto size = usual_size(answers);
  const double usual_edge_px = measurement::median_of(edges);
  std::vector<SeenView> views;
  for (size_t i = 0; i < answers.size(); ++i) {
    const std::string name = camera.pictures[i].filename().string();
    if (const std::string fault = fault_of(answers[i], size, usual_edge_px); !fault.empty()) {
      left_out.add(camera.said + name, fault);
      continue;
    }
    SeenView view{.name = name};
    for (const FoundPoint& found : answers[i].points)
      view.corners.push_back({.point = found.point,
                              .p_W = target.points[found.point],
                              .u_px = found.u_px,
                              .v_px = found.v_px});
    view.time_ns = static_cast<int64_t>(i);  // Its picture, until times are known.
    views.push_back(std::move(view));
  }
  if (views.empty()) return views;
  if (draft.camera.width_px > 0 && std::pair(draft.camera.width_px, draft.camera.height_px) != size)
    throw InputError(fmt::format(
        "the pictures of camera '{}' are {} x {} px, those of another one {} x {}: expected one "
        "size, which a set has for all of its cameras",
        camera.name, size.first, size.second, draft.camera.width_px, draft.camera.height_px));
  draft.camera.width_px = size.first, draft.camera.height_px = size.second;
  if (usual_edge_px > 0)
    draft.did(
        fmt::format("{}edges of the target are {:.1f} px wide, 10 to 90 %, in the middle one "
                    "of the pictures",
                    camera.said, usual_edge_px));
  return views;
}

// Leaves out views that scatter far more than others.
void leave_out_disorder(const std::string& said, std::vector<SeenView>& views, LeftOut& left_out) {
  constexpr double kMost_px = 0.3, kMostOver = 6;
  const Scatter scatter = scatter_of(views);
  std::vector<SeenView> kept;
  for (size_t v = 0; v < views.size(); ++v) {
    if (scatter.view_px[v] > std::max(kMost_px, kMostOver * scatter.all_px)) {
      left_out.add(
          said + views[v].name,
          fmt::format("corners in disorder: they scatter by {:.2f} px", scatter.view_px[v]));
    } else {
      kept.push_back(std::move(views[v]));
    }
  }
  views = std::move(kept);
}

// Whether the set's own estimate separates noise from what the target is off its plan: then none
// is stated.
bool tell_their_noise(const std::vector<CameraViews>& cameras) {
  size_t usable = 0;
  for (const CameraViews& camera : cameras) {
    usable += static_cast<size_t>(std::count_if(
        camera.views.begin(), camera.views.end(),
        [](const SeenView& view) { return view.corners.size() >= measurement::kPointsTellNoise; }));
  }
  return usable >= measurement::kViewsTellDisplacements;
}

// Says what corners scatter by, and gives it to each corner of its view where `stated`.
void tell_scatter(const std::string& said, bool stated, std::vector<SeenView>& views,
                  SetDraft& draft) {
  const Scatter scatter = scatter_of(views);
  if (scatter.all_px == 0) return;
  for (size_t v = 0; v < views.size() && stated; ++v) {
    for (SeenCorner& corner : views[v].corners)
      corner.sigma_px = std::max(1e-4, scatter.view_px[v]);
  }
  draft.did(fmt::format("{}the corners scatter by {:.3f} px about a smooth map of each view{}",
                        said, scatter.all_px, stated ? ": sigma_px, by view" : ""));
}

// Replaces the views' places by their times, in whose order they then stand; whether times are
// known.
bool put_in_time(std::vector<SeenView>& views, const CameraPictures& camera,
                 const PictureTimes& times, const std::vector<PictureAnswer>& answers,
                 SetDraft& draft) {
  const auto picture = [](const SeenView& view) { return static_cast<size_t>(view.time_ns); };
  const bool exif =
      !times.known() && std::all_of(views.begin(), views.end(), [&](const auto& view) {
        return answers[picture(view)].time_ns.has_value();
      });
  if (!times.known() && !exif) return false;
  std::vector<SeenView> timed = views;
  for (SeenView& view : timed)
    view.time_ns =
        exif ? *answers[picture(view)].time_ns : times.of(camera.pictures[picture(view)]);
  std::stable_sort(timed.begin(), timed.end(),
                   [](const SeenView& a, const SeenView& b) { return a.time_ns < b.time_ns; });
  const auto same = std::adjacent_find(
      timed.begin(), timed.end(),
      [](const SeenView& a, const SeenView& b) { return a.time_ns == b.time_ns; });
  if (same != timed.end() && !exif)
    throw InputError(fmt::format("{} and {} have the same time by {}: of two cameras?", same->name,
                                 std::next(same)->name, times.how()));
  if (same != timed.end()) {
    draft.could_not_know("the order of pictures in one second of their EXIF data: no times");
    return false;
  }
  draft.did(fmt::format("{}times are those of {}", camera.said,
                        exif ? "the pictures' EXIF data" : times.how()));
  views = std::move(timed);
  return true;
}

void tell_ambiguity(const TargetSpec& target, SetDraft& draft) {
  const bool turns = target.pattern == "circles" ||
                     (target.pattern == "chessboard" && (target.columns + target.rows) % 2 == 0);
  if (turns)
    draft.could_not_know(
        "which end of the target is up: it looks the same turned round, so that displacements of "
        "its points are not separable from views of both kinds");
}

// What was found in all pictures.
struct Found {
  std::vector<CameraViews> cameras;
  bool times_known = true;
  LeftOut left_out;
  size_t pictures = 0;
};

Found find_in(const Sources& sources, const TargetSpec& target, const ImportRequest& request,
              SetDraft& draft) {
  Found found;
  for (const CameraPictures& camera : sources.cameras) {
    const PictureTimes times =
        camera.of_bag.files.empty()
            ? PictureTimes(camera.pictures, sources.times ? &*sources.times : nullptr, request)
            : PictureTimes("the stamps of " + camera.of_bag.topic, camera.of_bag.stamps_ns);
    const size_t count = camera.pictures.size();
    const auto answers =
        find_targets(camera.pictures, target, [&](size_t done) { tell_progress(done, count); });
    std::vector<SeenView> views = views_of(camera, answers, target, draft, found.left_out);
    if (!put_in_time(views, camera, times, answers, draft)) found.times_known = false;
    leave_out_disorder(camera.said, views, found.left_out);
    found.pictures += count;
    found.cameras.push_back({camera.name, std::move(views)});
  }
  const bool stated = !tell_their_noise(found.cameras);
  for (size_t c = 0; c < found.cameras.size(); ++c)
    tell_scatter(sources.cameras[c].said, stated, found.cameras[c].views, draft);
  return found;
}

// The calibration beside the pictures of a bag, where it is of their size.
const PlainCamera* calibration_of(const Sources& sources, SetDraft& draft) {
  if (sources.cameras.size() > 1 || !sources.cameras.front().of_bag.camera) return nullptr;
  const PlainCamera& camera = *sources.cameras.front().of_bag.camera;
  if (camera.width_px == draft.camera.width_px && camera.height_px == draft.camera.height_px)
    return &camera;
  draft.warn(fmt::format("{} is of {} x {} px, the pictures are not: left out", camera.name,
                         camera.width_px, camera.height_px));
  return nullptr;
}

}  // namespace

void import_images(const ImportRequest& request, SetDraft& draft) {
  const Sources sources = sources_of(request, draft);
  const TargetSpec target = sources.target ? *sources.target : stated_target(request);
  Found found = find_in(sources, target, request, draft);
  std::string all;
  for (const std::string& sentence : found.left_out.sentences(found.pictures)) {
    draft.warn(sentence);
    all += "\n  " + sentence;
  }
  size_t taken = 0;
  for (const CameraViews& camera : found.cameras) {
    taken += camera.views.size();
    if (camera.views.empty())
      throw InputError(
          fmt::format("no picture{} shows the target, {} of {} x {}:{}",
                      found.cameras.size() > 1 ? " of camera '" + camera.name + "'" : "",
                      target.pattern, target.columns, target.rows, all));
  }
  draft.did(fmt::format("{} of {} pictures show the target, {} of {} x {}", taken, found.pictures,
                        target.pattern, target.columns, target.rows));
  tell_ambiguity(target, draft);
  const std::vector<SeenView> views =
      found.cameras.size() > 1
          ? views_of_rig(std::move(found.cameras),
                         found.times_known ? SameFrame::time : SameFrame::picture_name, draft)
          : std::move(found.cameras.front().views);
  draft_views(views, found.times_known, calibration_of(sources, draft),
              request.sources.front().string(), draft);
}

}  // namespace seam::app
