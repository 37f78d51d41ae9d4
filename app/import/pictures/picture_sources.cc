#include "app/import/pictures/picture_sources.h"

#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>
#include <set>

#include "app/import/files/storage.h"
#include "app/import/pictures/picture_times.h"
#include "app/import/pictures/rig_views.h"
#include "sim_core/base/error.h"

namespace seam::app {
namespace {

namespace fs = std::filesystem;

constexpr size_t kMostPictures = 100'000;

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

bool is_of(const fs::path& picture, const std::string& camera) {
  return picture.filename().string().find(camera) != std::string::npos ||
         picture.parent_path().filename().string().find(camera) != std::string::npos;
}

// Pictures to the cameras that were asked for; where none was, those of the first.
void choose_cameras(const std::vector<fs::path>& pictures, std::vector<CameraPictures>& wanted,
                    SetDraft& draft) {
  std::set<std::string> cameras;
  for (const fs::path& picture : pictures) cameras.insert(camera_in(picture));
  const bool several = cameras.size() > 1 && !cameras.contains("");
  const bool asked = !wanted.front().name.empty();
  const std::string camera = !asked && several ? *cameras.begin() : wanted.front().name;
  for (const fs::path& picture : pictures) {
    const std::string* taken = nullptr;
    for (CameraPictures& one : wanted) {
      const bool its = asked ? is_of(picture, one.name) : !several || camera_in(picture) == camera;
      if (!its) continue;
      if (taken != nullptr)
        throw InputError(fmt::format("{}: --camera {},{}: its name holds both", picture.string(),
                                     *taken, one.name));
      taken = &one.name;
      one.pictures.push_back(picture);
    }
  }
  for (const CameraPictures& one : wanted) {
    if (one.pictures.empty())
      throw InputError(fmt::format("{}: --camera {}: no picture's name holds it",
                                   pictures.front().string(), one.name));
  }
  if (several && wanted.size() == 1)
    draft.did(
        fmt::format("of the cameras {0}, by the pictures' names, {1} (--camera; --camera "
                    "{2} takes them as one rig)",
                    fmt::join(cameras, ", "), camera, fmt::join(cameras, ",")));
}

// Pictures of a bag, a folder for each camera.
void unpack(const fs::path& bag, Sources& found, SetDraft& draft) {
  if (found.unpacked) throw UsageError("images: expected one bag");
  found.unpacked = std::make_unique<ScratchFolder>("pictures");
  for (CameraPictures& camera : found.cameras) {
    const fs::path folder =
        found.unpacked->path() / fmt::format("{}", &camera - found.cameras.data());
    fs::create_directory(folder);
    camera.of_bag = unpack_pictures(bag, camera.name, folder, draft);
    camera.pictures = camera.of_bag.files;
  }
}

}  // namespace

Sources sources_of(const ImportRequest& request, SetDraft& draft) {
  Sources found;
  for (const std::string& name : cameras_in(request.camera))
    found.cameras.push_back({.name = name});
  std::vector<fs::path> pictures;
  const auto take = [&](const fs::path& path) {
    if (path.string().find('\n') != std::string::npos)
      throw InputError(fmt::format("{}: a picture's name of one line is expected", path.string()));
    pictures.push_back(path);
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
      unpack(source, found, draft);
    } else {
      take(source);
    }
  }
  if (found.unpacked && !pictures.empty())
    throw UsageError("images: expected a bag or pictures, not both");
  if (!found.unpacked && !pictures.empty()) choose_cameras(pictures, found.cameras, draft);
  size_t count = 0;
  for (CameraPictures& camera : found.cameras) {
    if (camera.pictures.empty())
      throw InputError(fmt::format("{}: found no picture", request.sources.front().string()));
    if (found.cameras.size() > 1) camera.said = camera.name + ": ";
    sort_by_number(camera.pictures);
    count += camera.pictures.size();
  }
  if (count > kMostPictures)
    throw InputError(fmt::format("found {} pictures, expected at most {}", count, kMostPictures));
  return found;
}

}  // namespace seam::app
