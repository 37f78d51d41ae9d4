// Assimp's formats as plain triangles. Runs in the process that read_mesh starts.
#include <assimp/cfileio.h>
#include <assimp/cimport.h>
#include <assimp/material.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <assimp/version.h>
#include <dlfcn.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>

#include "render/assets/gltf_limits.h"
#include "render/assets/mesh_bytes.h"
#include "sim_core/input/file_names.h"

namespace seam::render {
namespace {

namespace fs = std::filesystem;

constexpr const char* kLibrary = "libassimp.so.5";

struct Library {
  void* handle = dlopen(kLibrary, RTLD_NOW | RTLD_LOCAL);
  template <typename Function>
  Function* find(const char* name) const {
    auto* const function = reinterpret_cast<Function*>(handle ? dlsym(handle, name) : nullptr);
    if (!function)
      throw InputError(
          fmt::format("{} cannot be loaded; install Debian's libassimp5 for meshes", kLibrary));
    return function;
  }
};

// ---- The files that Assimp opens: those of the folder alone ----

struct Folder {
  fs::path root;
  std::string name;          // Of the mesh's file,
  const std::string& bytes;  // which was read by whoever looked at it first.
  std::vector<std::string> opened, missed;
};

Folder& folder_of(aiFileIO* io) {
  return *reinterpret_cast<Folder*>(io->UserData);
}
std::FILE* stream_of(aiFile* file) {
  return reinterpret_cast<std::FILE*>(file->UserData);
}
size_t read_some(aiFile* file, char* out, size_t size, size_t count) {
  return std::fread(out, size, count, stream_of(file));
}
size_t write_nothing(aiFile*, const char*, size_t, size_t) {
  return 0;
}
size_t tell(aiFile* file) {
  return static_cast<size_t>(std::ftell(stream_of(file)));
}
size_t size_of(aiFile* file) {
  const long here = std::ftell(stream_of(file));
  std::fseek(stream_of(file), 0, SEEK_END);
  const long size = std::ftell(stream_of(file));
  std::fseek(stream_of(file), here, SEEK_SET);
  return static_cast<size_t>(size);
}
aiReturn seek(aiFile* file, size_t offset, aiOrigin origin) {
  const int from = origin == aiOrigin_SET ? SEEK_SET : origin == aiOrigin_CUR ? SEEK_CUR : SEEK_END;
  return std::fseek(stream_of(file), static_cast<long>(offset), from) == 0 ? aiReturn_SUCCESS
                                                                           : aiReturn_FAILURE;
}
void flush_nothing(aiFile*) {}

std::FILE* open_bytes(const std::string& bytes) {
  return fmemopen(const_cast<char*>(bytes.data()), bytes.size(), "rb");
}

aiFile* open_inside(aiFileIO* io, const char* name, const char* mode) {
  Folder& folder = folder_of(io);
  const std::string inside =
      fs::path(name).lexically_normal().lexically_relative(folder.root).string();
  if (mode[0] != 'r' || !why_not_inside(folder.root, inside).empty()) return nullptr;
  std::FILE* const stream = inside == folder.name ? open_bytes(folder.bytes)
                            : fs::is_regular_file(folder.root / inside)
                                ? std::fopen((folder.root / inside).c_str(), "rb")
                                : nullptr;
  std::vector<std::string>& asked = stream ? folder.opened : folder.missed;
  if (std::find(asked.begin(), asked.end(), inside) == asked.end()) asked.push_back(inside);
  if (!stream) return nullptr;
  return new aiFile{read_some,
                    write_nothing,
                    tell,
                    size_of,
                    seek,
                    flush_nothing,
                    reinterpret_cast<char*>(stream)};
}
void close_file(aiFileIO*, aiFile* file) {
  std::fclose(stream_of(file));
  delete file;
}

// ---- Materials ----

class Materials {
 public:
  Materials(const Library& library, const aiScene& scene, ReadMesh& out)
      : colour_(library.find<decltype(aiGetMaterialColor)>("aiGetMaterialColor")),
        texture_(library.find<decltype(aiGetMaterialTexture)>("aiGetMaterialTexture")),
        text_(library.find<decltype(aiGetMaterialString)>("aiGetMaterialString")),
        scene_(scene),
        out_(out) {}

  // What a file says nothing of is white.
  aiColor4D colour(unsigned index) const {
    const aiMaterial* const material = scene_.mMaterials[index];
    aiString name;
    aiColor4D colour(1, 1, 1, 1);
    if (text_(material, AI_MATKEY_NAME, &name) == aiReturn_SUCCESS &&
        std::string(name.C_Str()) == AI_DEFAULT_MATERIAL_NAME)
      return colour;
    if (picture(index) >= 0 && is_collada_) return colour;
    colour_(material, AI_MATKEY_COLOR_DIFFUSE, &colour);
    return colour;
  }

  int32_t picture(unsigned index) const {
    for (const aiTextureType kind : {aiTextureType_BASE_COLOR, aiTextureType_DIFFUSE}) {
      aiString path;
      if (texture_(scene_.mMaterials[index], kind, 0, &path, nullptr, nullptr, nullptr, nullptr,
                   nullptr, nullptr) == aiReturn_SUCCESS)
        return picture_named(path.C_Str());
    }
    return -1;
  }

  void set_collada() { is_collada_ = true; }

 private:
  int32_t picture_named(const std::string& name) const {
    const auto known = known_.find(name);
    if (known != known_.end()) return known->second;
    PictureSource source{name, {}};
    if (name.size() > 1 && name[0] == '*') {
      const unsigned place = static_cast<unsigned>(std::strtoul(name.c_str() + 1, nullptr, 10));
      if (place >= scene_.mNumTextures || scene_.mTextures[place]->mHeight != 0)
        throw InputError(fmt::format("its picture {} is none", name));
      const aiTexture& inside = *scene_.mTextures[place];
      source = {"", std::string(reinterpret_cast<const char*>(inside.pcData), inside.mWidth)};
    }
    out_.pictures.push_back(source);
    return known_[name] = static_cast<int32_t>(out_.pictures.size()) - 1;
  }

  decltype(aiGetMaterialColor)* colour_;
  decltype(aiGetMaterialTexture)* texture_;
  decltype(aiGetMaterialString)* text_;
  const aiScene& scene_;
  ReadMesh& out_;
  bool is_collada_ = false;
  mutable std::map<std::string, int32_t> known_;
};

// ---- Triangles ----

bool finite(const aiVector3D& v) {
  return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

// The files' up is y where they say that there is one; ours is z.
void put(const aiVector3D& v, bool y_is_up, float* out) {
  out[0] = v.x, out[1] = y_is_up ? -v.z : v.y, out[2] = y_is_up ? v.y : v.z;
}

MeshVertex vertex_of(const aiMesh& mesh, unsigned i, const aiColor4D& colour, bool y_is_up) {
  if (!finite(mesh.mVertices[i]))
    throw InputError(fmt::format("vertex {} is not finite, expected numbers", i));
  MeshVertex vertex{};
  put(mesh.mVertices[i], y_is_up, vertex.p);
  aiVector3D normal = mesh.mNormals ? mesh.mNormals[i] : aiVector3D(0, 0, 0);
  const float length = normal.Length();
  // Zero is no normal: the face's own is taken, or upwards where others have one.
  normal = finite(normal) && length > 1e-12f ? normal / length : aiVector3D(0, 0, 0);
  put(normal, y_is_up, vertex.n);
  if (mesh.mTextureCoords[0]) {
    vertex.uv[0] = mesh.mTextureCoords[0][i].x, vertex.uv[1] = mesh.mTextureCoords[0][i].y;
    for (float& value : vertex.uv) value = std::isfinite(value) ? value : 0.0f;
  }
  const aiColor4D own = mesh.mColors[0] ? mesh.mColors[0][i] : aiColor4D(1, 1, 1, 1);
  for (unsigned c = 0; c < 3; ++c) {
    const float light = own[c] * colour[c];
    vertex.rgb[c] = std::isfinite(light) ? std::clamp(light, 0.0f, 1e6f) : 1.0f;
  }
  return vertex;
}

void add_part(const aiMesh& mesh, const Materials& materials, bool y_is_up, ReadMesh& out) {
  MeshPart part{.first = static_cast<uint32_t>(out.indices.size()),
                .picture = mesh.mTextureCoords[0] ? materials.picture(mesh.mMaterialIndex) : -1};
  const auto base = static_cast<uint32_t>(out.vertices.size());
  const aiColor4D colour = materials.colour(mesh.mMaterialIndex);
  for (unsigned i = 0; i < mesh.mNumVertices; ++i)
    out.vertices.push_back(vertex_of(mesh, i, colour, y_is_up));
  for (unsigned f = 0; f < mesh.mNumFaces; ++f) {
    const aiFace& face = mesh.mFaces[f];
    if (face.mNumIndices != 3) continue;
    for (unsigned k = 0; k < 3; ++k) {
      if (face.mIndices[k] >= mesh.mNumVertices)
        throw InputError(
            fmt::format("face {} names vertex {} of {}", f, face.mIndices[k], mesh.mNumVertices));
      out.indices.push_back(base + face.mIndices[k]);
    }
  }
  part.count = static_cast<uint32_t>(out.indices.size()) - part.first;
  if (part.count > 0) out.parts.push_back(part);
}

// ---- What is left of a file's scene before it is checked ----

// Readers leave points and lines among triangles, and their faces with names of vertices that are
// not there.
void keep_triangles(aiMesh& mesh) {
  unsigned kept = 0;
  mesh.mPrimitiveTypes &= static_cast<unsigned>(aiPrimitiveType_NGONEncodingFlag);
  for (unsigned f = 0; f < mesh.mNumFaces; ++f) {
    aiFace& face = mesh.mFaces[f];
    if (face.mNumIndices < 3) continue;
    for (unsigned k = 0; k < face.mNumIndices; ++k) {
      if (face.mIndices[k] >= mesh.mNumVertices)
        throw InputError(
            fmt::format("face {} names vertex {} of {}", f, face.mIndices[k], mesh.mNumVertices));
    }
    mesh.mPrimitiveTypes |=
        face.mNumIndices == 3 ? aiPrimitiveType_TRIANGLE : aiPrimitiveType_POLYGON;
    std::swap(mesh.mFaces[kept].mNumIndices, face.mNumIndices);
    std::swap(mesh.mFaces[kept].mIndices, face.mIndices);
    ++kept;
  }
  mesh.mNumFaces = kept;
  mesh.mNumBones = 0, mesh.mBones = nullptr;
  mesh.mNumAnimMeshes = 0, mesh.mAnimMeshes = nullptr;
}

constexpr unsigned kGone = ~0u;

// `places`: of each mesh among those that are left.
void rename_meshes(aiNode* root, const std::vector<unsigned>& places) {
  for (std::vector<aiNode*> nodes{root}; !nodes.empty();) {
    aiNode& node = *nodes.back();
    nodes.pop_back();
    unsigned kept = 0;
    for (unsigned i = 0; i < node.mNumMeshes; ++i) {
      const unsigned mesh = node.mMeshes[i];
      if (mesh < places.size() && places[mesh] != kGone) node.mMeshes[kept++] = places[mesh];
    }
    node.mNumMeshes = kept;
    if (kept == 0) node.mMeshes = nullptr;
    nodes.insert(nodes.end(), node.mChildren, node.mChildren + node.mNumChildren);
  }
}

// Cameras, lamps and motion are no part of a mesh: whatever is wrong with them does not matter.
// What is taken out is not freed: the process ends soon.
void keep_meshes(aiScene& scene) {
  scene.mNumCameras = 0, scene.mCameras = nullptr;
  scene.mNumLights = 0, scene.mLights = nullptr;
  scene.mNumAnimations = 0, scene.mAnimations = nullptr;
  std::vector<unsigned> places;
  unsigned kept = 0;
  for (unsigned m = 0; m < scene.mNumMeshes; ++m) {
    aiMesh* const mesh = scene.mMeshes[m];
    keep_triangles(*mesh);
    places.push_back(mesh->mNumFaces > 0 ? kept : kGone);
    if (mesh->mNumFaces > 0) scene.mMeshes[kept++] = mesh;
  }
  scene.mNumMeshes = kept;
  if (kept == 0) throw InputError("found no triangles");
  if (scene.mRootNode) rename_meshes(scene.mRootNode, places);
}

// A library's reason in words that its users know.
std::string reason_of(const std::string& raw, const std::string& ending) {
  if (raw.find("alloc") != std::string::npos)
    return "it needs more memory than meshes may take, expected a smaller one";
  std::string reason = fmt::format(
      "its content is no {} that can be read, expected one that is whole: export it again",
      ending.substr(1));
  const bool is_plain = raw.find("ai") == std::string::npos &&
                        raw.find("::") == std::string::npos &&
                        raw.find("No suitable reader") == std::string::npos;
  return is_plain && !raw.empty() ? fmt::format("{} ({})", reason, raw) : reason;
}

const aiScene& scene_of(const Library& library, Folder& inside, const std::string& ending) {
  constexpr unsigned kSteps = aiProcess_Triangulate | aiProcess_SortByPType | aiProcess_GenNormals |
                              aiProcess_PreTransformVertices | aiProcess_JoinIdenticalVertices |
                              aiProcess_ValidateDataStructure | aiProcess_FlipUVs |
                              aiProcess_GenUVCoords;
  aiFileIO io{open_inside, close_file, reinterpret_cast<char*>(&inside)};
  const aiScene* scene = library.find<decltype(aiImportFileExWithProperties)>(
      "aiImportFileExWithProperties")((inside.root / inside.name).c_str(), 0, &io, nullptr);
  if (scene) {
    keep_meshes(*const_cast<aiScene*>(scene));
    scene = library.find<decltype(aiApplyPostProcessing)>("aiApplyPostProcessing")(scene, kSteps);
  }
  if (!scene)
    throw InputError(
        reason_of(library.find<decltype(aiGetErrorString)>("aiGetErrorString")(), ending));
  return *scene;
}

}  // namespace

std::string mesh_library_version() {
  const Library library;
  return fmt::format("{}.{}.{}.{}",
                     library.find<decltype(aiGetVersionMajor)>("aiGetVersionMajor")(),
                     library.find<decltype(aiGetVersionMinor)>("aiGetVersionMinor")(),
                     library.find<decltype(aiGetVersionPatch)>("aiGetVersionPatch")(),
                     library.find<decltype(aiGetVersionRevision)>("aiGetVersionRevision")());
}

ReadMesh import_mesh(const fs::path& folder, const std::string& name, const std::string& bytes) {
  const Library library;
  const std::string ending = mesh_ending(name);
  if (ending == ".gltf" || ending == ".glb") check_gltf(bytes);
  Folder inside{
      folder.lexically_normal(), fs::path(name).lexically_normal().string(), bytes, {}, {}};
  const aiScene& scene = scene_of(library, inside, ending);
  ReadMesh out;
  const bool y_is_up = ending == ".gltf" || ending == ".glb" || ending == ".dae";
  Materials materials(library, scene, out);
  if (ending == ".dae") materials.set_collada();
  size_t triangles = 0, vertices = 0;
  for (unsigned m = 0; m < scene.mNumMeshes; ++m)
    triangles += scene.mMeshes[m]->mNumFaces, vertices += scene.mMeshes[m]->mNumVertices;
  if (triangles > kMostTriangles)
    throw InputError(
        fmt::format("found {} triangles, expected at most {}", triangles, kMostTriangles));
  if (vertices > kMostVertices)
    throw InputError(
        fmt::format("found {} vertices, expected at most {}: join those that are equal", vertices,
                    kMostVertices));
  for (unsigned m = 0; m < scene.mNumMeshes; ++m)
    add_part(*scene.mMeshes[m], materials, y_is_up, out);
  if (out.indices.empty()) throw InputError("found no triangles");
  join_flat_faces(out);
  out.files = inside.opened;
  out.missed = inside.missed;
  return out;
}

}  // namespace seam::render
