#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <csignal>

#include "render/assets/mesh_bytes.h"
#include "sim_core/base/files.h"
#include "sim_core/base/hash.h"
#include "sim_core/input/file_names.h"
#include "sim_core/input/shown_text.h"

namespace seam::render {
namespace {

namespace fs = std::filesystem;

constexpr uint64_t kMostFileBytes = uint64_t{512} << 20;
constexpr rlim_t kMostMemory = rlim_t{8} << 30;
constexpr rlim_t kMostSeconds = 60;

std::string packed(const ReadMesh& mesh) {
  ByteWriter out;
  out.add(mesh.error);
  out.add(mesh.vertices), out.add(mesh.indices), out.add(mesh.parts);
  out.add(uint64_t{mesh.pictures.size()});
  for (const PictureSource& picture : mesh.pictures) out.add(picture.name), out.add(picture.bytes);
  out.add(uint64_t{mesh.files.size()});
  for (const std::string& file : mesh.files) out.add(file);
  return out.bytes();
}

ReadMesh unpacked(const std::string& bytes) {
  ByteReader in(bytes);
  ReadMesh mesh;
  in.read(mesh.error);
  in.read(mesh.vertices), in.read(mesh.indices), in.read(mesh.parts);
  constexpr uint64_t kMostNames = 10'000;
  for (uint64_t i = 0, count = std::min(in.number(), kMostNames); i < count; ++i) {
    PictureSource& picture = mesh.pictures.emplace_back();
    in.read(picture.name), in.read(picture.bytes);
  }
  for (uint64_t i = 0, count = std::min(in.number(), kMostNames); i < count; ++i)
    in.read(mesh.files.emplace_back());
  return mesh;
}

// In the reading process.
[[noreturn]] void read_and_exit(const fs::path& folder, const std::string& name, int out) {
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
  const rlimit memory{kMostMemory, kMostMemory};
  setrlimit(RLIMIT_AS, &memory);
#endif
  const rlimit seconds{kMostSeconds, kMostSeconds}, core{0, 0};
  setrlimit(RLIMIT_CPU, &seconds);
  setrlimit(RLIMIT_CORE, &core);
  for (const int number : {SIGSEGV, SIGBUS, SIGFPE, SIGABRT, SIGILL}) std::signal(number, SIG_DFL);
  ReadMesh mesh;
  try {
    mesh = import_mesh(folder, name);
  } catch (const std::exception& error) {
    mesh = {};
    mesh.error = error.what();
  }
  const std::string bytes = packed(mesh);
  for (size_t at = 0; at < bytes.size();) {
    const ssize_t written = write(out, bytes.data() + at, bytes.size() - at);
    if (written <= 0) _exit(2);
    at += static_cast<size_t>(written);
  }
  _exit(0);
}

std::string all_of(int file) {
  std::string bytes;
  bytes.resize(static_cast<size_t>(std::max<off_t>(0, lseek(file, 0, SEEK_END))));
  lseek(file, 0, SEEK_SET);
  for (size_t at = 0; at < bytes.size();) {
    const ssize_t count = read(file, bytes.data() + at, bytes.size() - at);
    if (count <= 0) throw InputError("its reader ended early");
    at += static_cast<size_t>(count);
  }
  return bytes;
}

// The file as a process of its own reads it.
ReadMesh read_apart(const fs::path& folder, const std::string& name) {
  const int shared = memfd_create("seam-mesh", MFD_CLOEXEC);
  const pid_t reader = shared < 0 ? -1 : fork();
  if (reader == 0) read_and_exit(folder, name, shared);
  int status = 0;
  while (reader > 0 && waitpid(reader, &status, 0) < 0 && errno == EINTR) {
  }
  std::string bytes;
  if (reader > 0 && WIFEXITED(status) && WEXITSTATUS(status) == 0) bytes = all_of(shared);
  if (shared >= 0) close(shared);
  if (reader < 0) throw InputError("no process can be started to read it");
  if (WIFSIGNALED(status))
    throw InputError(
        WTERMSIG(status) == SIGXCPU || WTERMSIG(status) == SIGKILL
            ? fmt::format("not read within {} s, expected a smaller mesh", kMostSeconds)
            : "not a readable mesh: its reader broke down on it");
  ReadMesh mesh = unpacked(bytes);
  if (!mesh.error.empty()) throw InputError("not a readable mesh: " + shown(mesh.error));
  return mesh;
}

// A crooked reader must not lead us astray.
void check(const ReadMesh& mesh) {
  for (const uint32_t index : mesh.indices)
    if (index >= mesh.vertices.size()) throw InputError("a triangle without its vertex");
  for (const MeshPart& part : mesh.parts) {
    if (uint64_t{part.first} + part.count > mesh.indices.size() ||
        part.picture >= static_cast<int64_t>(mesh.pictures.size()))
      throw InputError("a part without its triangles");
  }
}

Picture picture_of(const PictureSource& source, const FileName& file, Hasher& hasher) {
  if (source.name.empty()) return decode_picture(source.bytes, "its picture");
  std::string name = source.name;
  std::replace(name.begin(), name.end(), '\\', '/');
  const std::string inside = (fs::path(file.name).parent_path() / name).lexically_normal().string();
  const std::string bytes = read_file(path_inside(file.folder, inside), kMostFileBytes);
  hasher.add(std::string_view(bytes));
  return decode_picture(bytes, inside);
}

Mesh mesh_of(const FileName& file, double scale) {
  const fs::path folder = fs::absolute(file.folder).lexically_normal();
  const fs::path path = path_inside(folder, file.name);
  if (!fs::is_regular_file(path)) throw InputError("no such file");
  if (fs::file_size(path) > kMostFileBytes)
    throw InputError(
        fmt::format("found {} bytes, expected at most {}", fs::file_size(path), kMostFileBytes));
  ReadMesh read = read_apart(folder, file.name);
  check(read);
  Hasher hasher;
  for (const std::string& name : read.files)
    hasher.add(std::string_view(read_file(path_inside(folder, name), kMostFileBytes)));
  Mesh mesh{.indices = std::move(read.indices), .parts = std::move(read.parts), .pictures = {}};
  mesh.vertices = std::move(read.vertices);
  for (MeshVertex& vertex : mesh.vertices) {
    double squared = 0;
    for (float& value : vertex.p) {
      value = static_cast<float>(scale * value);
      squared += static_cast<double>(value) * value;
    }
    mesh.radius_m = std::max(mesh.radius_m, std::sqrt(squared));
  }
  // In float, squares stay finite.
  if (!(mesh.radius_m > 0) || mesh.radius_m > 1e15)
    throw InputError(fmt::format("found a radius of {} m, expected more than 0 and at most 1e15",
                                 mesh.radius_m));
  mesh.radius_m *= 1 + 1e-6;
  for (const PictureSource& source : read.pictures)
    mesh.pictures.push_back(picture_of(source, file, hasher));
  mesh.fingerprint = to_hex(hasher.digest());
  return mesh;
}

void check_fingerprint(const FileName& file, const std::string& found) {
  if (!file.fingerprint.empty() && file.fingerprint != found)
    throw InputError(
        fmt::format("found the fingerprint {}, expected {}: it has changed since the log was "
                    "written",
                    found, file.fingerprint));
}

template <typename Read>
auto named(const FileName& file, const Read& read) {
  try {
    auto asset = read();
    check_fingerprint(file, asset.fingerprint);
    return asset;
  } catch (const InputError& error) {
    const std::string name = (fs::path(file.folder) / file.name).string(), why = error.what();
    throw InputError(why.starts_with(name) ? why : fmt::format("{}: {}", name, why));
  }
}

}  // namespace

Mesh read_mesh(const FileName& file, double scale) {
  return named(file, [&] { return mesh_of(file, scale); });
}

Texture read_texture(const FileName& file) {
  return named(file, [&] {
    const std::string bytes = read_file(path_inside(file.folder, file.name), kMostFileBytes);
    Hasher hasher;
    hasher.add(std::string_view(bytes));
    return Texture{decode_picture(bytes, "its picture"), to_hex(hasher.digest())};
  });
}

}  // namespace seam::render
