#include "render/gl/mesh_drawer.h"

#include <algorithm>
#include <iterator>
#include <numeric>

#include "render/assets/mesh_clusters.h"

namespace seam::render::gl {
namespace {

constexpr const char* kVertex = R"(
in vec3 position;
in vec3 normal;
in vec2 at;
in vec3 colour;
uniform vec4 target;  // 2 / width, 2 / height; the stagger.
uniform mat3 R_VO;
uniform vec3 p_VO;
uniform vec4 ray;  // What to add to a texel's place, and what a texel is on the plane z = 1.
#if defined(LIGHT) && defined(FLAT)
out vec3 f_place;
#elif defined(LIGHT)
out vec3 f_normal;
#endif
#ifdef TEXTURED
out vec2 f_at;
#endif
#if defined(LIGHT) || defined(COLOUR)
out vec3 f_colour;
#endif
const float kNear = 1e-3;
void main() {
  vec3 p = R_VO * position + p_VO;
  vec2 grid = p.xy / ray.zw;
  vec2 place = vec2(grid.x + target.z * grid.y, grid.y) - ray.xy * p.z;
  gl_Position = vec4(place * target.xy - p.z, p.z - 2.0 * kNear, p.z);
#if defined(LIGHT) && defined(FLAT)
  f_place = p;
#elif defined(LIGHT)
  f_normal = R_VO * normal;
#endif
#ifdef TEXTURED
  f_at = at;
#endif
#if defined(LIGHT) || defined(COLOUR)
  f_colour = colour;
#endif
}
)";

// Seen from both sides, as rectangles are: the normal is the one that looks at the camera.
constexpr const char* kFragment = R"(
#if defined(LIGHT) && defined(FLAT)
in vec3 f_place;
#elif defined(LIGHT)
in vec3 f_normal;
#endif
#ifdef TEXTURED
in vec2 f_at;
#endif
#if defined(LIGHT) || defined(COLOUR)
in vec3 f_colour;
#endif
uniform vec4 light;
uniform vec4 look;
uniform vec4 ray;
uniform vec4 target;
uniform sampler2D picture;
out vec4 seen;
const float kNear = 1e-3;
void main() {
  gl_FragDepth = min(kNear * gl_FragCoord.w, 1.0);
#if defined(TRUTH)
  seen = vec4(look.w, 1.0 / gl_FragCoord.w, 0.0, 1.0);
#elif defined(INDEX)
  seen = vec4(look.w);
#else
  vec3 base = f_colour * look.rgb;
#ifdef TEXTURED
  base *= texture(picture, f_at).rgb;
#endif
#ifdef LIGHT
  vec2 grid = gl_FragCoord.xy + ray.xy;
  vec3 v = vec3(vec2(grid.x - target.z * grid.y, grid.y) * ray.zw, 1.0);
#ifdef FLAT
  vec3 n = normalize(cross(dFdx(f_place), dFdy(f_place)));
#else
  vec3 n = normalize(f_normal);
#endif
  if (dot(n, v) > 0.0) n = -n;
  base *= light.w + max(dot(n, light.xyz), 0.0);
#endif
  seen = vec4(base, 1.0);
#endif
}
)";

// Indices drawn before their pixels are filled. Mesa keeps all triangles of a page until then, each
// for every tile that it meets; filled piece by piece they stay in the cache.
constexpr int64_t kMostWaiting = 6'000;

std::optional<std::array<float, 3>> one_colour(const Mesh& mesh, const MeshPart& part) {
  if (part.picture >= 0 || part.count == 0) return std::nullopt;
  const auto rgb_of = [&](uint32_t i) {
    const float* const rgb = mesh.vertices[mesh.indices[part.first + i]].rgb;
    return std::array<float, 3>{rgb[0], rgb[1], rgb[2]};
  };
  for (uint32_t i = 1; i < part.count; ++i) {
    if (rgb_of(i) != rgb_of(0)) return std::nullopt;
  }
  return rgb_of(0);
}

}  // namespace

bool ClusteredMesh::has_one_colour_each() const {
  return std::all_of(parts.begin(), parts.end(), [](const Part& part) { return !!part.rgb; });
}

std::vector<ClusteredMesh> cluster_meshes(Assets& assets) {
  std::vector<ClusteredMesh> meshes;
  for (Mesh& mesh : assets.meshes) {
    ClusteredMesh& clustered = meshes.emplace_back();
    prepare_mesh(mesh);
    clustered.turn = mesh.prepared->turn;
    for (size_t i = 0; i < mesh.parts.size(); ++i)
      clustered.parts.push_back({mesh.prepared->clusters[i], one_colour(mesh, mesh.parts[i])});
  }
  return meshes;
}

MeshDrawer::MeshDrawer(const OffscreenGl& gl, const Assets& assets, Linker link)
    : gl_(gl.api()), fills_piecewise_(gl.on_processor()), assets_(assets), link_(std::move(link)) {
  for (const Texture& texture : assets.textures)
    textures_.push_back(upload(*texture.picture, GL_CLAMP_TO_EDGE));
  std::map<const Picture*, GLuint> pictures;
  for (const Mesh& mesh : assets.meshes) meshes_.push_back(upload(mesh, pictures));
}

const MeshDrawer::Program& MeshDrawer::program(Writes writes, Form form) {
  Program& made = programs_[{writes, form}];
  if (made.id != 0) return made;
  const std::string head = program_head(writes) + (form.textured ? "#define TEXTURED\n" : "") +
                           (form.flat ? "#define FLAT\n" : "");
  made.id = link_(head + kVertex, head + kFragment, {"position", "normal", "at", "colour"});
  const auto find = [&](const char* name) { return gl_.glGetUniformLocation(made.id, name); };
  made.target = find("target"), made.R_VO = find("R_VO"), made.p_VO = find("p_VO");
  made.light = find("light"), made.look = find("look"), made.ray = find("ray");
  made.picture = find("picture");
  return made;
}

GLuint MeshDrawer::upload(const Picture& picture, GLint wrap) const {
  GLuint texture = 0;
  gl_.glGenTextures(1, &texture);
  gl_.glBindTexture(GL_TEXTURE_2D, texture);
  gl_.glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
  gl_.glTexImage2D(GL_TEXTURE_2D, 0, GL_SRGB8, picture.width_px, picture.height_px, 0, GL_RGB,
                   GL_UNSIGNED_BYTE, picture.rgb.data());
  gl_.glGenerateMipmap(GL_TEXTURE_2D);
  gl_.glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR_MIPMAP_LINEAR);
  gl_.glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
  gl_.glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, wrap);
  gl_.glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, wrap);
  return texture;
}

void MeshDrawer::set_inputs(const std::vector<float>& values, std::span<const Input> inputs) const {
  GLsizei floats = 0;
  for (const Input& input : inputs) floats += input.floats;
  GLuint buffer = 0;
  gl_.glGenBuffers(1, &buffer);
  gl_.glBindBuffer(GL_ARRAY_BUFFER, buffer);
  gl_.glBufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(4 * values.size()), values.data(),
                   GL_STATIC_DRAW);
  size_t at = 0;
  for (const Input& input : inputs) {
    gl_.glEnableVertexAttribArray(input.place);
    gl_.glVertexAttribPointer(input.place, input.floats, GL_FLOAT, GL_FALSE, 4 * floats,
                              reinterpret_cast<const void*>(at));
    at += size_t{4} * static_cast<size_t>(input.floats);
  }
}

MeshDrawer::Loaded MeshDrawer::upload(const Mesh& mesh,
                                      std::map<const Picture*, GLuint>& pictures) const {
  Loaded loaded;
  gl_.glGenVertexArrays(1, &loaded.vertices);
  gl_.glBindVertexArray(loaded.vertices);
  std::vector<float> places;
  places.reserve(3 * mesh.vertices.size());
  for (const MeshVertex& vertex : mesh.vertices)
    places.insert(places.end(), std::begin(vertex.p), std::end(vertex.p));
  constexpr Input kPlaces[] = {{0, 3}};
  set_inputs(places, kPlaces);
  GLuint indices = 0;
  gl_.glGenBuffers(1, &indices);
  gl_.glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, indices);
  gl_.glBufferData(GL_ELEMENT_ARRAY_BUFFER, static_cast<GLsizeiptr>(mesh.indices.size() * 4),
                   mesh.indices.data(), GL_STATIC_DRAW);
  for (const auto& picture : mesh.pictures) {
    GLuint& texture = pictures[picture.get()];
    if (texture == 0) texture = upload(*picture, GL_REPEAT);
  }
  for (const MeshPart& part : mesh.parts)
    loaded.parts.push_back({{.textured = part.picture >= 0, .flat = part.flat != 0},
                            part.picture < 0 ? 0 : pictures[mesh.pictures[part.picture].get()]});
  return loaded;
}

// Frames that hold places in a palette, and the truth, need none of it.
void MeshDrawer::upload_looks(size_t place) {
  Loaded& loaded = meshes_[place];
  if (loaded.has_looks) return;
  loaded.has_looks = true;
  const std::vector<MeshVertex>& vertices = assets_.meshes[place].vertices;
  std::vector<float> looks;
  looks.reserve(8 * vertices.size());
  for (const MeshVertex& vertex : vertices) {
    looks.insert(looks.end(), std::begin(vertex.n), std::end(vertex.n));
    looks.insert(looks.end(), std::begin(vertex.uv), std::end(vertex.uv));
    looks.insert(looks.end(), std::begin(vertex.rgb), std::end(vertex.rgb));
  }
  gl_.glBindVertexArray(loaded.vertices);
  constexpr Input kLooks[] = {{1, 3}, {2, 2}, {3, 3}};
  set_inputs(looks, kLooks);
}

void MeshDrawer::bind_texture(uint32_t texture) const {
  gl_.glActiveTexture(GL_TEXTURE0);
  gl_.glBindTexture(GL_TEXTURE_2D, textures_.at(texture));
}

void MeshDrawer::draw_runs(const std::vector<MeshInstance::Run>& runs, size_t begin, size_t end) {
  counts_.clear(), places_.clear();
  for (size_t i = begin; i < end; ++i) {
    counts_.push_back(static_cast<GLsizei>(runs[i].count));
    places_.push_back(reinterpret_cast<const void*>(size_t{4} * runs[i].first));
  }
  gl_.glMultiDrawElements(GL_TRIANGLES, counts_.data(), GL_UNSIGNED_INT, places_.data(),
                          static_cast<GLsizei>(counts_.size()));
  if (!fills_piecewise_) return;
  const auto drawn = std::accumulate(counts_.begin(), counts_.end(), int64_t{0});
  if ((waiting_ += drawn) < kMostWaiting) return;
  gl_.glFlush();
  waiting_ = 0;
}

void MeshDrawer::draw_instance(const Program& at, const MeshInstance& instance, Form form,
                               int width) {
  const Loaded& loaded = meshes_[instance.mesh];
  gl_.glScissor(0, instance.first_row, width, instance.rows);
  gl_.glUniformMatrix3fv(at.R_VO, 1, GL_FALSE, instance.R_VO.data());
  gl_.glUniform3f(at.p_VO, instance.p_VO[0], instance.p_VO[1], instance.p_VO[2]);
  const auto& light = instance.light_V;
  gl_.glUniform4f(at.light, light[0], light[1], light[2], light[3]);
  const auto& ray = instance.ray;
  gl_.glUniform4f(at.ray, ray[0], ray[1], ray[2], ray[3]);
  gl_.glBindVertexArray(loaded.vertices);
  if (instance.turn == 0) {
    gl_.glDisable(GL_CULL_FACE);
  } else {
    gl_.glEnable(GL_CULL_FACE);
    // The image's rows run down, those of the target up.
    gl_.glFrontFace(instance.turn > 0 ? GL_CW : GL_CCW);
  }
  const std::vector<MeshInstance::Run>& runs = instance.runs;
  for (size_t begin = 0, end = 0; begin < runs.size(); begin = end) {
    for (int64_t held = 0; end < runs.size() && runs[end].part == runs[begin].part; ++end) {
      if ((held += runs[end].count) > kMostWaiting && end > begin) break;
    }
    const Loaded::Part& part = loaded.parts[runs[begin].part];
    if (part.form != form) continue;
    if (form.textured) gl_.glBindTexture(GL_TEXTURE_2D, part.picture);
    gl_.glUniform4f(at.look, instance.rgb[0], instance.rgb[1], instance.rgb[2],
                    runs[begin].identity);
    draw_runs(runs, begin, end);
  }
}

void MeshDrawer::draw(const std::vector<MeshInstance>& instances, int width, int height,
                      float shear, Writes writes) {
  if (writes == Writes::light || writes == Writes::colour) {
    for (const MeshInstance& instance : instances) upload_looks(instance.mesh);
  }
  for (const Form form : {Form{false, false}, {false, true}, {true, false}, {true, true}}) {
    const auto has_some = [&](const MeshInstance& instance) {
      const auto& parts = meshes_[instance.mesh].parts;
      return std::any_of(parts.begin(), parts.end(),
                         [&](const Loaded::Part& part) { return part.form == form; });
    };
    if (std::none_of(instances.begin(), instances.end(), has_some)) continue;
    const Program& at = program(writes, form);
    gl_.glUseProgram(at.id);
    gl_.glUniform4f(at.target, 2.0f / static_cast<float>(width), 2.0f / static_cast<float>(height),
                    shear, 0);
    gl_.glUniform1i(at.picture, 0);
    gl_.glActiveTexture(GL_TEXTURE0);
    for (const MeshInstance& instance : instances) {
      if (has_some(instance)) draw_instance(at, instance, form, width);
    }
  }
  gl_.glDisable(GL_CULL_FACE);
  gl_.glScissor(0, 0, width, height);
}

}  // namespace seam::render::gl
