#include "app/bundle/unpacked.h"

#include <fcntl.h>
#include <unistd.h>

#include <cstdio>
#include <memory>

#include "app/bundle/archive.h"
#include "app/bundle/sha256.h"
#include "sim_core/base/error.h"
#include "sim_core/input/file_names.h"
#include "sim_core/input/shown_text.h"

namespace seam::app {
namespace {

namespace fs = std::filesystem;

// A new file of this user alone; it writes nowhere else, whatever is there.
void unpack_file(ArchiveReader& archive, const BundleFile& file, const fs::path& place,
                 const std::string& where) {
  fs::create_directories(place.parent_path());
  const int descriptor = ::open(place.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC,
                                file.program ? 0700 : 0600);
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> out(
      descriptor < 0 ? nullptr : ::fdopen(descriptor, "wb"), &std::fclose);
  if (!out) throw InputError(fmt::format("{}: cannot be written", place.string()));
  Sha256 sum;
  bool written = true;
  archive.content([&](std::string_view piece) {
    sum.add(piece);
    written = written && std::fwrite(piece.data(), 1, piece.size(), out.get()) == piece.size();
  });
  if (!written || std::fflush(out.get()) != 0)
    throw InputError(fmt::format("{}: cannot be written: is the disk full?", place.string()));
  if (const std::string found = sum.digest(); found != file.sha256)
    throw InputError(fmt::format("{}: {}: found the SHA-256 {}, expected {}: damaged or changed",
                                 where, file.name, found, shown(file.sha256)));
}

BundleManifest read_manifest(ArchiveReader& archive, const std::string& where) {
  const auto first = archive.next();
  if (!first || first->name != kManifestName || first->bytes > kMostManifestBytes)
    throw InputError(
        fmt::format("{}: it does not begin with {}, expected a bundle", where, kManifestName));
  std::string text;
  archive.content([&](std::string_view piece) { text += piece; });
  return BundleManifest::from_text(text, where);
}

}  // namespace

bool is_bundle(const fs::path& file) {
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> in(
      fs::is_regular_file(file) ? std::fopen(file.c_str(), "rb") : nullptr, &std::fclose);
  unsigned char magic[2] = {};
  return in && std::fread(magic, 1, 2, in.get()) == 2 && magic[0] == 0x1f && magic[1] == 0x8b;
}

UnpackedBundle::UnpackedBundle(const fs::path& file) : folder_("bundle") {
  const std::string where = file.string();
  ArchiveReader archive(file);
  manifest_ = read_manifest(archive, where);
  for (const BundleFile& expected : manifest_.files) {
    const auto entry = archive.next();
    if (!entry || entry->name != expected.name || entry->bytes != expected.bytes)
      throw InputError(fmt::format("{}: found {}, expected {} with {} bytes as its manifest says",
                                   where, entry ? "'" + shown(entry->name) + "'" : "its end",
                                   shown(expected.name), expected.bytes));
    unpack_file(archive, expected, place(expected.name), where);
  }
  if (const auto more = archive.next())
    throw InputError(
        fmt::format("{}: found '{}', which its manifest does not have", where, shown(more->name)));
  fs::create_directories(work());
  fs::create_directories(scratch());
}

fs::path UnpackedBundle::place(const std::string& name) const {
  return path_inside(folder_.path() / "unpacked", name);
}

void UnpackedBundle::move_here(Scenario& scenario) const {
  const auto move = [&](FileName& file) {
    if (file.name.empty()) return;
    const auto found = manifest_.folders.find(file.folder);
    if (found == manifest_.folders.end())
      throw InputError(fmt::format("'{}' in {} is not in the bundle: make it again",
                                   shown(file.name), shown(file.folder)));
    file.folder = place(found->second).string();
  };
  for (ObjectSpec& object : scenario.objects) {
    move(object.mesh);
    move(object.texture);
  }
  for (RobotSpec& robot : scenario.robots) {
    for (BodyPart& part : robot.body.parts) move(part.mesh);
    for (std::string& word : robot.behaviour.command)
      if (const auto found = manifest_.words.find(word); found != manifest_.words.end())
        word = found->second;
  }
}

WorkingFolder::WorkingFolder(const fs::path& folder) : before_(fs::current_path()) {
  fs::current_path(folder);
}

WorkingFolder::~WorkingFolder() {
  std::error_code ignored;
  fs::current_path(before_, ignored);
}

}  // namespace seam::app
