// Meshes and textures in one context.
#pragma once

#include <array>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "render/assets/assets.h"
#include "render/gl/offscreen/offscreen.h"
#include "render/gl/shaders.h"

namespace seam::render::gl {

// One mesh in one band.
struct MeshInstance {
  uint32_t mesh = 0;            // Into Assets::meshes.
  std::array<float, 9> R_VO{};  // To the strip's view, column-major.
  std::array<float, 3> p_VO{};
  std::array<float, 4> light_V{};  // Towards the light, times its strength; and the ambient light.
  std::array<float, 3> rgb{};      // A factor on the mesh's colours.
  std::array<float, 4> ray{};      // As ShapeInstance::ray.
  int first_row = 0, rows = 0;     // Of the page: the band.
  int turn = 0;  // 1, -1: only triangles that run counter-clockwise or clockwise are seen.
  // Of each part the runs of indices that the band can see: how many, and where.
  struct Run {
    uint32_t part, first, count;
    float identity;
  };
  std::vector<Run> runs;
};

// The scene's meshes with their triangles in clusters; made once for all contexts.
struct ClusteredMesh {
  struct Part {
    std::vector<MeshCluster> clusters;
    std::optional<std::array<float, 3>> rgb;  // Where it has one colour all over.
  };
  std::vector<Part> parts;
  int turn = 0;  // As turn_seen_from_outside.
  bool has_one_colour_each() const;
};
// Puts the meshes' indices in the clusters' order.
std::vector<ClusteredMesh> cluster_meshes(Assets& assets);

class MeshDrawer {
 public:
  // Makes a program of shaders; the inputs are the vertex shader's, in the order of their places.
  using Linker = std::function<GLuint(const std::string& vertex, const std::string& fragment,
                                      const std::vector<const char*>& inputs)>;
  // Needs a current context. What is given outlives the drawer; meshes are in their clusters'
  // order.
  MeshDrawer(const OffscreenGl& gl, const Assets& assets, Linker link);

  // Of the scene's textures (from 0 on), for shapes.
  void bind_texture(uint32_t texture) const;
  void draw(const std::vector<MeshInstance>& instances, int width, int height, float shear,
            Writes writes);

 private:
  // What parts of one program have in common.
  struct Form {
    bool textured, flat;
    auto operator<=>(const Form&) const = default;
  };
  struct Loaded {
    GLuint vertices = 0;
    bool has_looks = false;
    struct Part {
      Form form;
      GLuint picture;  // 0: none.
    };
    std::vector<Part> parts;
  };
  struct Program {
    GLuint id = 0;
    GLint target = -1, R_VO = -1, p_VO = -1, light = -1, look = -1, ray = -1, picture = -1;
  };
  const Program& program(Writes writes, Form form);
  void draw_runs(const std::vector<MeshInstance::Run>& runs, size_t begin, size_t end);
  void draw_instance(const Program& at, const MeshInstance& instance, Form form, int width);
  GLuint upload(const Picture& picture, GLint wrap) const;
  // An input of the vertex shader.
  struct Input {
    GLuint place;
    GLint floats;
  };
  void set_inputs(const std::vector<float>& values, std::span<const Input> inputs) const;
  // Places alone; the rest, which takes more than twice as much, where a frame needs it.
  // `pictures`: those that are there, which meshes share.
  Loaded upload(const Mesh& mesh, std::map<const Picture*, GLuint>& pictures) const;
  void upload_looks(size_t place);

  const Api& gl_;
  const bool fills_piecewise_;
  const Assets& assets_;
  std::vector<Loaded> meshes_;
  std::vector<GLuint> textures_;
  Linker link_;
  std::map<std::pair<Writes, Form>, Program> programs_;
  int64_t waiting_ = 0;  // Indices drawn since pixels were filled last.
  // Of one call.
  std::vector<GLsizei> counts_;
  std::vector<const void*> places_;
};

}  // namespace seam::render::gl
