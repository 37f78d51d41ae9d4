#include "render/gl/mesh_drawer.h"

#include <cstddef>

namespace seam::render::gl {
namespace {

constexpr const char* kVertex = R"(#version 330 core
in vec3 position;
in vec3 normal;
in vec2 at;
in vec3 colour;
uniform vec4 target;  // 2 / width, 2 / height; the stagger.
uniform mat3 R_VO;
uniform vec3 p_VO;
uniform vec4 ray;  // What to add to a texel's place, and what a texel is on the plane z = 1.
out vec3 f_normal;
out vec2 f_at;
out vec3 f_colour;
const float kNear = 1e-3;
void main() {
  vec3 p = R_VO * position + p_VO;
  vec2 grid = p.xy / ray.zw;
  vec2 place = vec2(grid.x + target.z * grid.y, grid.y) - ray.xy * p.z;
  gl_Position = vec4(place * target.xy - p.z, p.z - 2.0 * kNear, p.z);
  f_normal = R_VO * normal;
  f_at = at;
  f_colour = colour;
}
)";

// Seen from both sides, as rectangles are: the normal is the one that looks at the camera.
constexpr const char* kFragment = R"(#version 330 core
in vec3 f_normal;
in vec2 f_at;
in vec3 f_colour;
uniform int truth;
uniform int textured;
uniform vec4 light;
uniform vec4 look;
uniform vec4 ray;
uniform vec4 target;
uniform sampler2D picture;
out vec4 seen;
const float kNear = 1e-3;
void main() {
  vec2 grid = gl_FragCoord.xy + ray.xy;
  vec3 v = vec3(vec2(grid.x - target.z * grid.y, grid.y) * ray.zw, 1.0);
  vec3 n = normalize(f_normal);
  if (dot(n, v) > 0.0) n = -n;
  vec3 base = f_colour * look.rgb;
  if (textured == 1) base *= texture(picture, f_at).rgb;
  gl_FragDepth = min(kNear * gl_FragCoord.w, 1.0);
  float factor = light.w + max(dot(n, light.xyz), 0.0);
  seen = truth == 1 ? vec4(look.w, 1.0 / gl_FragCoord.w, 0.0, 1.0) : vec4(base * factor, 1.0);
}
)";

}  // namespace

const std::vector<const char*>& MeshDrawer::inputs() {
  static const std::vector<const char*> names = {"position", "normal", "at", "colour"};
  return names;
}
const char* MeshDrawer::vertex_text() {
  return kVertex;
}
const char* MeshDrawer::fragment_text() {
  return kFragment;
}

std::vector<ClusteredMesh> cluster_meshes(const Assets& assets) {
  std::vector<ClusteredMesh> meshes;
  for (const Mesh& mesh : assets.meshes) {
    ClusteredMesh& clustered = meshes.emplace_back(ClusteredMesh{mesh.indices, {}});
    for (const MeshPart& part : mesh.parts)
      clustered.parts.push_back(make_clusters(mesh, part, clustered.indices));
  }
  return meshes;
}

MeshDrawer::MeshDrawer(const Api& gl, const Assets& assets,
                       const std::vector<ClusteredMesh>& clustered)
    : gl_(gl) {
  for (const Texture& texture : assets.textures)
    textures_.push_back(upload(texture.picture, GL_CLAMP_TO_EDGE));
  for (size_t i = 0; i < assets.meshes.size(); ++i)
    meshes_.push_back(upload(assets.meshes[i], clustered[i].indices));
}

void MeshDrawer::set_program(GLuint program) {
  program_ = program;
  const auto find = [&](const char* name) { return gl_.glGetUniformLocation(program, name); };
  at_ = {find("target"), find("truth"), find("R_VO"),    find("p_VO"),    find("light"),
         find("look"),   find("ray"),   find("picture"), find("textured")};
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

MeshDrawer::Loaded MeshDrawer::upload(const Mesh& mesh,
                                      const std::vector<uint32_t>& indices) const {
  Loaded loaded;
  gl_.glGenVertexArrays(1, &loaded.vertices);
  gl_.glBindVertexArray(loaded.vertices);
  GLuint buffers[2];
  gl_.glGenBuffers(2, buffers);
  gl_.glBindBuffer(GL_ARRAY_BUFFER, buffers[0]);
  gl_.glBufferData(GL_ARRAY_BUFFER,
                   static_cast<GLsizeiptr>(mesh.vertices.size() * sizeof(MeshVertex)),
                   mesh.vertices.data(), GL_STATIC_DRAW);
  gl_.glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, buffers[1]);
  gl_.glBufferData(GL_ELEMENT_ARRAY_BUFFER, static_cast<GLsizeiptr>(indices.size() * 4),
                   indices.data(), GL_STATIC_DRAW);
  const std::pair<GLint, size_t> inputs[] = {{3, offsetof(MeshVertex, p)},
                                             {3, offsetof(MeshVertex, n)},
                                             {2, offsetof(MeshVertex, uv)},
                                             {3, offsetof(MeshVertex, rgb)}};
  for (GLuint i = 0; i < 4; ++i) {
    gl_.glEnableVertexAttribArray(i);
    gl_.glVertexAttribPointer(i, inputs[i].first, GL_FLOAT, GL_FALSE, sizeof(MeshVertex),
                              reinterpret_cast<const void*>(inputs[i].second));
  }
  std::vector<GLuint> pictures;
  for (const Picture& picture : mesh.pictures) pictures.push_back(upload(picture, GL_REPEAT));
  for (const MeshPart& part : mesh.parts)
    loaded.pictures.push_back(part.picture < 0 ? 0 : pictures[part.picture]);
  return loaded;
}

void MeshDrawer::bind_texture(uint32_t texture) const {
  gl_.glActiveTexture(GL_TEXTURE0);
  gl_.glBindTexture(GL_TEXTURE_2D, textures_.at(texture));
}

void MeshDrawer::draw(const std::vector<MeshInstance>& instances, int width, int height,
                      float shear, bool truth) const {
  if (instances.empty()) return;
  gl_.glUseProgram(program_);
  gl_.glUniform4f(at_.target, 2.0f / static_cast<float>(width), 2.0f / static_cast<float>(height),
                  shear, 0);
  gl_.glUniform1i(at_.truth, truth ? 1 : 0);
  gl_.glUniform1i(at_.picture, 0);
  gl_.glActiveTexture(GL_TEXTURE0);
  for (const MeshInstance& instance : instances) {
    const Loaded& loaded = meshes_[instance.mesh];
    gl_.glScissor(0, instance.first_row, width, instance.rows);
    gl_.glUniformMatrix3fv(at_.R_VO, 1, GL_FALSE, instance.R_VO.data());
    gl_.glUniform3f(at_.p_VO, instance.p_VO[0], instance.p_VO[1], instance.p_VO[2]);
    const auto& light = instance.light_V;
    gl_.glUniform4f(at_.light, light[0], light[1], light[2], light[3]);
    const auto& look = instance.look;
    gl_.glUniform4f(at_.look, look[0], look[1], look[2], look[3]);
    const auto& ray = instance.ray;
    gl_.glUniform4f(at_.ray, ray[0], ray[1], ray[2], ray[3]);
    gl_.glBindVertexArray(loaded.vertices);
    for (size_t i = 0; i < instance.runs.size(); ++i) {
      const MeshInstance::Run& run = instance.runs[i];
      if (i == 0 || run.part != instance.runs[i - 1].part) {
        const GLuint picture = loaded.pictures[run.part];
        gl_.glUniform1i(at_.textured, picture != 0 ? 1 : 0);
        if (picture != 0) gl_.glBindTexture(GL_TEXTURE_2D, picture);
      }
      gl_.glDrawElements(GL_TRIANGLES, static_cast<GLsizei>(run.count), GL_UNSIGNED_INT,
                         reinterpret_cast<const void*>(size_t{4} * run.first));
    }
  }
  gl_.glScissor(0, 0, width, height);
}

}  // namespace seam::render::gl
