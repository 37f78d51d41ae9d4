// From a mesh's file to what is drawn, or from the cache.
#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <set>

#include "render/assets/mesh_bytes.h"
#include "render/assets/mesh_cache.h"
#include "render/assets/mesh_clusters.h"
#include "render/assets/stl_file.h"
#include "sim_core/base/files.h"
#include "sim_core/base/hash.h"
#include "sim_core/input/file_names.h"

namespace seam::render {
namespace {

namespace fs = std::filesystem;

constexpr uint64_t kMostFileBytes = uint64_t{256} << 20;
// Of what is computed from a file, and of the bytes in which it is kept: another number where
// either changes, so that older entries are not found.
constexpr std::string_view kCacheVersion = "seam-mesh/1";

// A file that the mesh's own file names, as it was when the mesh was made.
struct Dependency {
  std::string name;    // Relative to the folder of the mesh's file.
  std::string digest;  // Empty: it was not there.
};

// What a mesh is made of and what was made of it; all but pictures and fingerprint.
struct MadeMesh {
  Mesh mesh;
  std::vector<PictureSource> pictures;
  std::vector<Dependency> others;
};

// A crooked reader or a crooked cache must not lead us astray.
void check(const MadeMesh& made) {
  const Mesh& mesh = made.mesh;
  for (const uint32_t index : mesh.indices)
    if (index >= mesh.vertices.size()) throw InputError("a triangle without its vertex");
  for (const MeshPart& part : mesh.parts) {
    if (uint64_t{part.first} + part.count > mesh.indices.size() || part.count % 3 != 0 ||
        part.picture < -1 || part.picture >= static_cast<int64_t>(made.pictures.size()))
      throw InputError("a part without its triangles");
  }
}

void check(const PreparedMesh& prepared, const Mesh& mesh) {
  const auto fail = [] { throw InputError("a cluster without its triangles"); };
  if (prepared.clusters.size() != mesh.parts.size() || std::abs(prepared.turn) > 1) fail();
  for (const std::vector<MeshCluster>& clusters : prepared.clusters)
    for (const MeshCluster& cluster : clusters)
      if (uint64_t{cluster.first} + cluster.count > mesh.indices.size() || cluster.count % 3 != 0)
        fail();
}

std::string packed(const MadeMesh& made) {
  const Mesh& mesh = made.mesh;
  ByteWriter out;
  out.add(uint64_t{made.others.size()});
  for (const Dependency& other : made.others) out.add(other.name), out.add(other.digest);
  out.add(uint64_t{made.pictures.size()});
  for (const PictureSource& picture : made.pictures) out.add(picture.name), out.add(picture.bytes);
  out.add(mesh.vertices), out.add(mesh.indices), out.add(mesh.parts);
  out.add(std::bit_cast<uint64_t>(mesh.radius_m));
  out.add(static_cast<uint64_t>(mesh.prepared->turn + 1));
  for (const std::vector<MeshCluster>& clusters : mesh.prepared->clusters) out.add(clusters);
  return out.bytes();
}

// Throws InputError where the bytes are none of ours.
MadeMesh unpacked(std::string_view bytes) {
  ByteReader in(bytes);
  MadeMesh made;
  Mesh& mesh = made.mesh;
  for (uint64_t left = in.number(); left > 0; --left) {
    Dependency& other = made.others.emplace_back();
    in.read(other.name), in.read(other.digest);
  }
  for (uint64_t left = in.number(); left > 0; --left) {
    PictureSource& picture = made.pictures.emplace_back();
    in.read(picture.name), in.read(picture.bytes);
  }
  in.read(mesh.vertices), in.read(mesh.indices), in.read(mesh.parts);
  mesh.radius_m = std::bit_cast<double>(in.number());
  PreparedMesh prepared{.clusters = {}, .turn = static_cast<int>(in.number() & 3) - 1};
  for (size_t i = 0; i < mesh.parts.size(); ++i) in.read(prepared.clusters.emplace_back());
  check(made), check(prepared, mesh);
  mesh.prepared = std::move(prepared);
  return made;
}

void scale_vertices(double scale, Mesh& mesh) {
  for (MeshVertex& vertex : mesh.vertices) {
    double squared = 0;
    for (float& value : vertex.p) {
      value = static_cast<float>(scale * value);
      squared += static_cast<double>(value) * value;
    }
    mesh.radius_m = std::max(mesh.radius_m, std::sqrt(squared));
  }
}

void check_radius(const Mesh& mesh) {
  // In float, squares stay finite.
  if (!(mesh.radius_m > 0) || mesh.radius_m > 1e15)
    throw InputError(fmt::format("found a radius of {} m, expected more than 0 and at most 1e15",
                                 mesh.radius_m));
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
  } catch (const std::bad_alloc&) {
    throw InputError(
        fmt::format("{}: too little memory for it", (fs::path(file.folder) / file.name).string()));
  }
}

}  // namespace

std::string mesh_ending(const std::string& name) {
  std::string ending = fs::path(name).extension().string();
  std::transform(ending.begin(), ending.end(), ending.begin(),
                 [](unsigned char c) { return std::tolower(c); });
  constexpr std::array kKnown = {".gltf", ".glb", ".obj", ".stl", ".dae"};
  if (std::find(kKnown.begin(), kKnown.end(), ending) == kKnown.end())
    throw InputError(fmt::format(
        "found the ending '{}', expected that of a mesh: .gltf or .glb (glTF 2.0), .obj, .stl or "
        ".dae (COLLADA); convert it to one of them",
        ending));
  return ending;
}

class MeshMaker {
 public:
  MeshMaker(AssetFiles& files, const FileName& file, double scale)
      : files_(files), file_(file), scale_(scale) {
    if (!fs::is_regular_file(path_inside(folder_, file_.name))) throw InputError("no such file");
    ending_ = mesh_ending(file_.name);
    bytes_ = read(file_.name);
    if (bytes_.empty()) throw InputError("not a readable mesh: the file is empty");
  }

  Mesh make() {
    const MeshCache cache = MeshCache::of_environment();
    const std::string key = cache_key();
    std::optional<MadeMesh> made = cached(cache, key);
    if (!made) {
      made = make_anew();
      cache.store(key, packed(*made));
    }
    return finished(std::move(*made));
  }

 private:
  std::string read(const std::string& name) const {
    std::string bytes = read_file(path_inside(folder_, name), kMostFileBytes);
    files_.limits_.take_bytes(bytes.size());
    return bytes;
  }
  // Of a file that the mesh's names.
  std::string inside(const std::string& name) const {
    return (fs::path(file_.name).parent_path() / name).lexically_normal().string();
  }

  // Whether our own reader reads it.
  bool is_own() const { return ending_ == ".stl" && is_plain_stl(bytes_); }

  std::string cache_key() const {
    const std::string library = is_own() ? "own" : mesh_library_version();
    const std::string scale = fmt::format("{:x}", std::bit_cast<uint64_t>(scale_));
    const std::array<std::string_view, 5> parts = {kCacheVersion, ending_, library, scale, bytes_};
    return digest_of(parts);
  }

  // Whether all files that the mesh's names are as they were.
  bool are_same(const std::vector<Dependency>& others) {
    for (const Dependency& other : others) {
      const std::string name = inside(other.name);
      const bool is_there =
          why_not_inside(folder_, name).empty() && fs::is_regular_file(folder_ / name);
      if (is_there != !other.digest.empty()) return false;
      if (is_there && note_other(other.name) != other.digest) return false;
    }
    return true;
  }
  // Its digest. Fingerprints are of all files together.
  std::string note_other(const std::string& name) {
    const std::string bytes = read(inside(name));
    hasher_.add(std::string_view(bytes));
    const std::array<std::string_view, 1> parts = {bytes};
    return digest_of(parts);
  }
  void begin_fingerprint() {
    hasher_ = Hasher();
    hasher_.add(std::string_view(bytes_));
  }

  std::optional<MadeMesh> cached(const MeshCache& cache, const std::string& key) {
    const std::optional<std::string> content = cache.find(key);
    if (!content) return std::nullopt;
    begin_fingerprint();
    try {
      MadeMesh made = unpacked(*content);
      check_radius(made.mesh);
      if (are_same(made.others)) return made;
    } catch (const InputError&) {
      // Made anew; faults of the files are reported then.
    }
    return std::nullopt;
  }

  MadeMesh make_anew() {
    begin_fingerprint();
    ReadMesh read = is_own() ? read_plain_stl(bytes_)
                             : import_mesh_apart(folder_, file_.name, bytes_, files_.limits_);
    MadeMesh made;
    made.mesh.indices = std::move(read.indices), made.mesh.parts = std::move(read.parts);
    made.mesh.vertices = std::move(read.vertices);
    made.pictures = std::move(read.pictures);
    check(made);
    const fs::path beside = fs::path(file_.name).parent_path();
    const std::string own = fs::path(file_.name).lexically_normal().string();
    for (const std::string& name : read.files) {
      const std::string relative = fs::path(name).lexically_relative(beside).string();
      if (name != own) made.others.push_back({relative, note_other(relative)});
    }
    for (const std::string& name : read.missed)
      made.others.push_back({fs::path(name).lexically_relative(beside).string(), ""});
    scale_vertices(scale_, made.mesh);
    check_radius(made.mesh);
    made.mesh.radius_m *= 1 + 1e-6;
    prepare_mesh(made.mesh);
    return made;
  }

  Mesh finished(MadeMesh made) {
    Mesh& mesh = made.mesh;
    files_.limits_.take_triangles(mesh.indices.size() / 3);
    std::set<std::string> files = {fs::path(file_.name).lexically_normal().string()};
    for (const Dependency& other : made.others)
      if (!other.digest.empty()) files.insert(inside(other.name));
    for (PictureSource& source : made.pictures) {
      std::replace(source.name.begin(), source.name.end(), '\\', '/');
      if (source.name.empty()) {
        mesh.pictures.push_back(std::make_shared<const Picture>(
            decode_picture(source.bytes, "its picture", files_.limits_)));
        continue;
      }
      mesh.pictures.push_back(named_picture(inside(source.name)));
      files.insert(inside(source.name));
    }
    mesh.files.assign(files.begin(), files.end());
    mesh.fingerprint = to_hex(hasher_.digest());
    return std::move(mesh);
  }
  std::shared_ptr<const Picture> named_picture(const std::string& name) {
    const fs::path path = path_inside(folder_, name);
    const std::string canonical = fs::weakly_canonical(path).string();
    if (!hashed_.insert(canonical).second) return files_.pictures_.at(canonical);
    const std::string bytes = read(name);
    hasher_.add(std::string_view(bytes));
    return files_.picture(canonical, bytes, name);
  }

  AssetFiles& files_;
  const FileName& file_;
  const double scale_;
  const fs::path folder_ = fs::absolute(file_.folder).lexically_normal();
  std::string ending_, bytes_;
  Hasher hasher_;
  std::set<std::string> hashed_;  // Pictures.
};

std::shared_ptr<const Picture> AssetFiles::picture(const std::string& canonical,
                                                   const std::string& bytes,
                                                   const std::string& name) {
  std::shared_ptr<const Picture>& picture = pictures_[canonical];
  if (!picture) picture = std::make_shared<const Picture>(decode_picture(bytes, name, limits_));
  return picture;
}

Mesh AssetFiles::mesh(const FileName& file, double scale) {
  return named(file, [&] { return MeshMaker(*this, file, scale).make(); });
}

Texture AssetFiles::texture(const FileName& file) {
  return named(file, [&] {
    const fs::path path = path_inside(file.folder, file.name);
    const std::string bytes = read_file(path, kMostFileBytes);
    limits_.take_bytes(bytes.size());
    Hasher hasher;
    hasher.add(std::string_view(bytes));
    return Texture{picture(fs::weakly_canonical(path).string(), bytes, "its picture"),
                   to_hex(hasher.digest())};
  });
}

bool reads_assets() {
  return true;
}

}  // namespace seam::render
