// `seam import images`: pictures of a calibration target, in which `seam-pictures` finds its
// points.
#include <fmt/ranges.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cstdio>
#include <map>
#include <set>

#include "app/import/draft/points_draft.h"
#include "app/import/draft/target.h"
#include "app/import/files/storage.h"
#include "app/import/files/text_table.h"
#include "app/import/kinds/kinds.h"
#include "app/import/pictures/bag_pictures.h"
#include "app/import/pictures/finder.h"
#include "app/import/pictures/picture_times.h"
#include "app/import/pictures/scatter.h"
#include "app/scratch_folder.h"
#include "measurement/numerics/robust.h"
#include "sim_core/base/error.h"

namespace seam::app {
namespace {

namespace fs = std::filesystem;

constexpr size_t kMostPictures = 100'000;
constexpr size_t kFewestCorners = 6;  // That say anything of a view.

struct Sources {
  std::vector<fs::path> pictures;
  std::optional<TargetSpec> target;
  std::optional<TextTable> times;
  // Of pictures in a bag: where they are meanwhile, and by whose stamps they are timed.
  std::unique_ptr<ScratchFolder> unpacked;
  BagPictures of_bag;
};

std::string lower_extension(const fs::path& path) {
  std::string extension = path.extension().string();
  for (char& c : extension) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return extension;
}

bool is_picture(const fs::path& path) {
  static const std::vector<std::string> kExtensions = {".png", ".jpg", ".jpeg", ".tif", ".tiff",
                                                       ".bmp", ".pgm", ".ppm",  ".pnm", ".webp"};
  return std::find(kExtensions.begin(), kExtensions.end(), lower_extension(path)) !=
         kExtensions.end();
}

// What a picture's path says of its camera: cam0, left, right; empty where it says none.
std::string camera_in(const fs::path& picture) {
  for (std::string text :
       {picture.filename().string(), picture.parent_path().filename().string()}) {
    for (char& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    const size_t cam = text.find("cam");
    size_t end = cam == std::string::npos ? text.size() : cam + 3;
    while (end < text.size() && std::isdigit(static_cast<unsigned char>(text[end])) != 0) ++end;
    if (cam != std::string::npos && end > cam + 3) return text.substr(cam, end - cam);
    for (const char* side : {"left", "right"}) {
      if (text.find(side) != std::string::npos) return side;
    }
  }
  return "";
}

// A set has one camera: of pictures of several, those of the one that was asked for, else of the
// first.
void choose_camera(std::vector<fs::path>& pictures, const std::string& wanted, SetDraft& draft) {
  std::set<std::string> cameras;
  for (const fs::path& picture : pictures) cameras.insert(camera_in(picture));
  const bool several = cameras.size() > 1 && !cameras.contains("");
  if (wanted.empty() && !several) return;
  const std::string camera = wanted.empty() ? *cameras.begin() : wanted;
  const std::string first = pictures.front().string();
  std::erase_if(pictures, [&](const fs::path& picture) {
    if (wanted.empty()) return camera_in(picture) != camera;
    return picture.filename().string().find(wanted) == std::string::npos &&
           picture.parent_path().filename().string().find(wanted) == std::string::npos;
  });
  if (pictures.empty())
    throw InputError(fmt::format("{}: --camera {}: no picture's name holds it", first, wanted));
  if (several)
    draft.did(fmt::format("of the cameras {}, by the pictures' names, {} (--camera)",
                          fmt::join(cameras, ", "), camera));
}

Sources sources_of(const ImportRequest& request, SetDraft& draft) {
  Sources found;
  const auto take = [&](const fs::path& path) {
    if (path.string().find('\n') != std::string::npos)
      throw InputError(fmt::format("{}: a picture's name of one line is expected", path.string()));
    found.pictures.push_back(path);
  };
  for (const fs::path& source : request.sources) {
    if (!fs::exists(source)) throw InputError(fmt::format("{}: no such file", source.string()));
    if (fs::is_directory(source)) {
      for (const auto& entry : fs::directory_iterator(source)) {
        if (entry.is_regular_file() && is_picture(entry.path())) take(entry.path());
      }
      continue;
    }
    const std::string extension = lower_extension(source);
    if (!fs::is_regular_file(source)) {
      throw InputError(fmt::format("{}: is no file, expected a picture", source.string()));
    } else if (extension == ".yaml" || extension == ".yml") {
      const ConfigNode root = read_storage(source);
      if (!root.is_map() || !root.has("target_type")) root.fail("expected a target (target_type)");
      found.target = read_target(root, request);
    } else if (extension == ".csv" || extension == ".txt") {
      if (found.times) throw UsageError("images: expected one table of times");
      found.times = TextTable::read(source);
    } else if (extension == ".mcap" || extension == ".bag") {
      if (found.unpacked) throw UsageError("images: expected one bag");
      found.unpacked = std::make_unique<ScratchFolder>("pictures");
      found.of_bag = unpack_pictures(source, request.camera, found.unpacked->path(), draft);
      found.pictures.insert(found.pictures.end(), found.of_bag.files.begin(),
                            found.of_bag.files.end());
    } else {
      take(source);
    }
  }
  if (found.pictures.empty())
    throw InputError(fmt::format("{}: found no picture", request.sources.front().string()));
  if (!found.unpacked) choose_camera(found.pictures, request.camera, draft);
  if (found.pictures.size() > kMostPictures)
    throw InputError(fmt::format("found {} pictures, expected at most {}", found.pictures.size(),
                                 kMostPictures));
  return found;
}

// Pictures that say nothing, by why.
class LeftOut {
 public:
  void add(const std::string& name, const std::string& why) {
    const size_t colon = why.find(": ");
    std::string& list = named_[why.substr(0, colon)];
    size_t& count = counts_[why.substr(0, colon)];
    if (++count <= 4)
      list += (list.empty() ? "" : ", ") + name +
              (colon == std::string::npos ? "" : " (" + why.substr(colon + 2) + ")");
    ++all_;
  }
  size_t all() const { return all_; }
  std::vector<std::string> sentences(size_t pictures) const {
    std::vector<std::string> result;
    for (const auto& [why, list] : named_) {
      const size_t count = counts_.at(why);
      result.push_back(fmt::format("{} of {} pictures left out, {}: {}{}", count, pictures, why,
                                   list, count > 4 ? fmt::format(" and {} more", count - 4) : ""));
    }
    return result;
  }

 private:
  std::map<std::string, std::string> named_;
  std::map<std::string, size_t> counts_;
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

std::vector<SeenView> views_of(const Sources& sources, const std::vector<PictureAnswer>& answers,
                               const TargetSpec& target, SetDraft& draft, LeftOut& left_out) {
  std::vector<double> edges;
  for (const PictureAnswer& answer : answers) {
    if (answer.edge_px > 0) edges.push_back(answer.edge_px);
  }
  const auto size = usual_size(answers);
  const double usual_edge_px = measurement::median_of(edges);
  std::vector<SeenView> views;
  for (size_t i = 0; i < answers.size(); ++i) {
    const std::string name = sources.pictures[i].filename().string();
    if (const std::string fault = fault_of(answers[i], size, usual_edge_px); !fault.empty()) {
      left_out.add(name, fault);
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
  draft.camera.width_px = size.first, draft.camera.height_px = size.second;
  if (usual_edge_px > 0)
    draft.did(
        fmt::format("edges of the target are {:.1f} px wide, 10 to 90 %, in the middle one "
                    "of the pictures",
                    usual_edge_px));
  return views;
}

// Gives each corner the scatter of its view, and leaves out views that scatter far more than
// others.
void measure_scatter(std::vector<SeenView>& views, SetDraft& draft, LeftOut& left_out) {
  constexpr double kMost_px = 0.3, kMostOver = 6;
  const double usual = scatter_of(views).all_px;
  if (usual == 0) return;
  std::vector<SeenView> kept;
  const Scatter before = scatter_of(views);
  for (size_t v = 0; v < views.size(); ++v) {
    if (before.view_px[v] > std::max(kMost_px, kMostOver * usual)) {
      left_out.add(views[v].name, fmt::format("corners in disorder: they scatter by {:.2f} px",
                                              before.view_px[v]));
    } else {
      kept.push_back(std::move(views[v]));
    }
  }
  views = std::move(kept);
  const Scatter scatter = scatter_of(views);
  for (size_t v = 0; v < views.size(); ++v) {
    for (SeenCorner& corner : views[v].corners)
      corner.sigma_px = std::max(1e-4, scatter.view_px[v]);
  }
  draft.did(fmt::format(
      "the corners scatter by {:.3f} px about a smooth map of each view: sigma_px, by view",
      scatter.all_px));
}

// Replaces the views' places by their times, in whose order they then stand; whether times are
// known.
bool put_in_time(std::vector<SeenView>& views, const Sources& sources, const PictureTimes& times,
                 const std::vector<PictureAnswer>& answers, SetDraft& draft) {
  const auto picture = [](const SeenView& view) { return static_cast<size_t>(view.time_ns); };
  const bool exif = !times.told() && std::all_of(views.begin(), views.end(), [&](const auto& view) {
    return answers[picture(view)].time_ns.has_value();
  });
  if (!times.told() && !exif) return false;
  std::vector<SeenView> timed = views;
  for (SeenView& view : timed)
    view.time_ns =
        exif ? *answers[picture(view)].time_ns : times.of(sources.pictures[picture(view)]);
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
  draft.did(fmt::format("times are those of {}", exif ? "the pictures' EXIF data" : times.how()));
  views = std::move(timed);
  return true;
}

void tell_ambiguity(const TargetSpec& target, SetDraft& draft) {
  const bool turns = target.pattern == "circles" ||
                     (target.pattern == "chessboard" && (target.columns + target.rows) % 2 == 0);
  if (turns)
    draft.could_not_know(
        "which end of the target is up: it looks the same turned round, so that displacements of "
        "its points cannot be told from views of both kinds");
}

}  // namespace

void import_images(const ImportRequest& request, SetDraft& draft) {
  Sources sources = sources_of(request, draft);
  sort_by_number(sources.pictures);
  const TargetSpec target = sources.target ? *sources.target : stated_target(request);
  const PictureTimes times =
      sources.of_bag.files.empty()
          ? PictureTimes(sources.pictures, sources.times ? &*sources.times : nullptr, request)
          : PictureTimes("the stamps of " + sources.of_bag.topic, sources.of_bag.stamps_ns);
  const size_t count = sources.pictures.size();
  const auto answers =
      find_targets(sources.pictures, target, [&](size_t done) { tell_progress(done, count); });
  LeftOut left_out;
  std::vector<SeenView> views = views_of(sources, answers, target, draft, left_out);
  const bool times_known = put_in_time(views, sources, times, answers, draft);
  measure_scatter(views, draft, left_out);
  std::string all;
  for (const std::string& sentence : left_out.sentences(count)) {
    draft.warn(sentence);
    all += "\n  " + sentence;
  }
  if (views.empty())
    throw InputError(fmt::format("no picture shows the target, {} of {} x {}:{}", target.pattern,
                                 target.columns, target.rows, all));
  draft.did(fmt::format("{} of {} pictures show the target, {} of {} x {}", views.size(), count,
                        target.pattern, target.columns, target.rows));
  tell_ambiguity(target, draft);
  const PlainCamera* camera = sources.of_bag.camera ? &*sources.of_bag.camera : nullptr;
  if (camera != nullptr &&
      (camera->width_px != draft.camera.width_px || camera->height_px != draft.camera.height_px)) {
    draft.warn(fmt::format("{} is of {} x {} px, the pictures are not: left out", camera->name,
                           camera->width_px, camera->height_px));
    camera = nullptr;
  }
  draft_views(views, times_known, camera, request.sources.front().string(), draft);
}

}  // namespace seam::app
