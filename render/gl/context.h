// One off-screen OpenGL 3.3 core context: its programs, its target, and how a strip's page is
// drawn.
#pragma once

#include <array>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <tuple>
#include <vector>

#include "render/gl/gather_pass.h"
#include "render/gl/mesh_drawer.h"
#include "render/gl/offscreen/offscreen.h"

namespace seam::render::gl {

// One shape at one instant, as the vertex shader takes it (shaders.h).
struct ShapeInstance {
  float place[4];
  float R_OV_and_origin[3][4];
  float size_and_ambient[4];
  float light_and_depth[4];
  float look[4];
  float ray[4];
};

// A flat face of one colour at one instant: a rectangle, or one of a box's sides. It is drawn as
// the triangles that it is, so that fragments fall only where it can be seen.
struct FaceInstance {
  float centre[4];   // In the view; then the band's first row on the page.
  float along_a[4];  // From the centre to one side, then the row after the band's last.
  float along_b[4];  // Then a depth that nothing of it comes below in the band.
  float plane[4];    // Its product with (x, y, 1) is 1 / depth; then the factor on that.
  float look[4];     // Light; the identity.
  float ray[4];      // As ShapeInstance::ray.
};

// Shapes of one kind and texture; drawn together.
struct ShapeBatch {
  int kind = 0;          // As seam::Shape counts.
  uint32_t texture = 0;  // As Primitive::asset; 0: none.
  bool operator<(const ShapeBatch& other) const {
    return kind != other.kind ? kind < other.kind : texture < other.texture;
  }
};

// All that stands on a page.
struct PageScene {
  std::vector<FaceInstance> faces;
  std::map<ShapeBatch, std::vector<ShapeInstance>> shapes;
  std::vector<MeshInstance> meshes;
};

// What a page's target is cleared to and how its fragments are written.
struct PageLook {
  Writes writes = Writes::colour;
  std::array<float, 4> background{};
  float shear = 0;  // StripScale::shear.
};

class Context {
 public:
  // What is given outlives the context.
  Context(const OffscreenGl& gl, const Assets& assets);
  Context(const Context&) = delete;
  Context& operator=(const Context&) = delete;

  void make_current() { context_->make_current(); }
  void release() { context_->release(); }

  // A page of the strip: `width` x `height` texels, row by row, left in `pixels`; four floats each,
  // or one where places in a palette are written.
  void begin_page(int width, int height, const PageLook& look);
  void draw(const PageScene& scene, const PageLook& look);
  void end_page(std::vector<float>& pixels);
  // In place of end_page: the page as it lies there, and what sums its texels there.
  GLuint page() const { return page_form_ == GL_RED ? indices_.colour : texels_.colour; }
  GatherPass& gather_pass();

  std::string version() const;
  std::string renderer() const;

 private:
  struct Program {
    GLuint id = 0;
    GLint target = -1, picture = -1;
  };
  // Buffers from which instances of `inputs` vectors of four floats are drawn.
  struct Instances {
    GLuint array = 0, buffer = 0;
  };
  Instances make_instances(int inputs) const;
  void draw_instances(const Instances& buffers, const void* instances, size_t bytes,
                      size_t count) const;
  void use(const Program& program, const PageLook& look) const;
  const Program& shape_program(const ShapeBatch& batch, Writes writes);
  void draw_faces(const std::vector<FaceInstance>& faces, const PageLook& look);
  Program link(const std::string& vertex, const std::string& fragment,
               const std::vector<const char*>& inputs) const;
  GLuint compile(GLenum kind, const std::string& text) const;
  struct Target {
    GLuint frame = 0, colour = 0, depth = 0;
    int width = 0, height = 0;
  };
  void make_target(Target& target, GLenum format, int width, int height) const;

  const Api& gl_;
  std::unique_ptr<OffscreenContext> context_;
  std::unique_ptr<MeshDrawer> meshes_;
  std::unique_ptr<GatherPass> gather_pass_;
  std::map<std::tuple<int, bool, Writes>, Program> shape_programs_;
  Instances shapes_, faces_;
  std::map<Writes, Program> face_programs_;
  Target texels_, indices_;               // Of four floats, and of one.
  int page_width_ = 0, page_height_ = 0;  // Of the page in one of them.
  GLenum page_form_ = GL_RGBA;
};

// The contexts of one process's frames: as many as frames are made at once, of the copies of the
// driver in turn.
class ContextPool {
 public:
  // All of it outlives the pool.
  ContextPool(std::vector<const OffscreenGl*> copies, const Assets& assets)
      : copies_(std::move(copies)), assets_(assets) {}

  // A context that is current on this thread until the lease ends.
  class Lease {
   public:
    explicit Lease(ContextPool& pool);
    ~Lease();
    Lease(const Lease&) = delete;
    Lease& operator=(const Lease&) = delete;
    Context& operator*() const { return *context_; }
    Context* operator->() const { return context_.get(); }

   private:
    ContextPool& pool_;
    std::unique_ptr<Context> context_;
  };

 private:
  const std::vector<const OffscreenGl*> copies_;
  const Assets& assets_;
  std::mutex mutex_;
  std::vector<std::unique_ptr<Context>> free_;
  size_t made_ = 0;
};

}  // namespace seam::render::gl
