#include "render/gl/context.h"

#include <algorithm>
#include <cstddef>
#include <memory>

#include "render/gl/shaders.h"
#include "sim_core/base/error.h"

namespace seam::render::gl {
namespace {

const char* shape_text(int kind) {
  constexpr const char* kTexts[] = {kRectangle, kSphere, kCylinder, kCapsule, kBox};
  return kTexts[kind];
}

}  // namespace

Context::Context(const OffscreenGl& gl, const Assets& assets)
    : gl_(gl.api()), context_(gl.make_context()) {
  make_current();
  shapes_ = make_instances(sizeof(ShapeInstance) / 16);
  faces_ = make_instances(sizeof(FaceInstance) / 16);
  for (Target* target : {&texels_, &indices_}) {
    gl_.glGenFramebuffers(1, &target->frame);
    target->colour = gl_.make_texture();
    gl_.glGenRenderbuffers(1, &target->depth);
  }
  meshes_ = std::make_unique<MeshDrawer>(
      gl, assets,
      [this](const std::string& vertex, const std::string& fragment,
             const std::vector<const char*>& inputs) { return link(vertex, fragment, inputs).id; });
}

Context::Instances Context::make_instances(int inputs) const {
  Instances made;
  gl_.glGenVertexArrays(1, &made.array);
  gl_.glBindVertexArray(made.array);
  gl_.glGenBuffers(1, &made.buffer);
  gl_.glBindBuffer(GL_ARRAY_BUFFER, made.buffer);
  for (int input = 0; input < inputs; ++input) {
    const auto place = static_cast<GLuint>(input);
    gl_.glEnableVertexAttribArray(place);
    gl_.glVertexAttribPointer(place, 4, GL_FLOAT, GL_FALSE, 16 * inputs,
                              reinterpret_cast<const void*>(size_t{16} * place));
    gl_.glVertexAttribDivisor(place, 1);
  }
  return made;
}

void Context::draw_instances(const Instances& buffers, const void* instances, size_t bytes,
                             size_t count) const {
  gl_.glBindVertexArray(buffers.array);
  gl_.glBindBuffer(GL_ARRAY_BUFFER, buffers.buffer);
  gl_.glBufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(bytes), instances, GL_STREAM_DRAW);
  gl_.glDrawArraysInstanced(GL_TRIANGLE_STRIP, 0, 4, static_cast<GLsizei>(count));
}

std::string Context::version() const {
  return reinterpret_cast<const char*>(gl_.glGetString(GL_VERSION));
}
std::string Context::renderer() const {
  return reinterpret_cast<const char*>(gl_.glGetString(GL_RENDERER));
}

GLuint Context::compile(GLenum kind, const std::string& text) const {
  const GLuint shader = gl_.glCreateShader(kind);
  const char* source = text.c_str();
  gl_.glShaderSource(shader, 1, &source, nullptr);
  gl_.glCompileShader(shader);
  GLint well = 0;
  gl_.glGetShaderiv(shader, GL_COMPILE_STATUS, &well);
  if (!well) {
    std::array<char, 4096> why{};
    gl_.glGetShaderInfoLog(shader, why.size(), nullptr, why.data());
    SEAM_CHECK(well, "shader: {}", why.data());
  }
  return shader;
}

Context::Program Context::link(const std::string& vertex, const std::string& fragment,
                               const std::vector<const char*>& inputs) const {
  Program program{.id = gl_.glCreateProgram()};
  const GLuint shaders[2] = {compile(GL_VERTEX_SHADER, vertex),
                             compile(GL_FRAGMENT_SHADER, fragment)};
  for (const GLuint shader : shaders) gl_.glAttachShader(program.id, shader);
  for (size_t i = 0; i < inputs.size(); ++i)
    gl_.glBindAttribLocation(program.id, static_cast<GLuint>(i), inputs[i]);
  gl_.glLinkProgram(program.id);
  for (const GLuint shader : shaders) gl_.glDeleteShader(shader);
  GLint well = 0;
  gl_.glGetProgramiv(program.id, GL_LINK_STATUS, &well);
  if (!well) {
    std::array<char, 4096> why{};
    gl_.glGetProgramInfoLog(program.id, why.size(), nullptr, why.data());
    SEAM_CHECK(well, "program: {}", why.data());
  }
  program.target = gl_.glGetUniformLocation(program.id, "target");
  program.picture = gl_.glGetUniformLocation(program.id, "picture");
  return program;
}

const Context::Program& Context::shape_program(const ShapeBatch& batch, Writes writes) {
  Program& program = shape_programs_[{batch.kind, batch.texture != 0, writes}];
  if (program.id == 0) {
    const bool box = shape_text(batch.kind) == kBox;
    const char* look = batch.texture == 0 ? kPlain : box ? kTexturedBox : kTexturedRectangle;
    program = link(kVersion + std::string(kShapeVertex),
                   program_head(writes) + kShapeFragmentHead + shape_text(batch.kind) + look +
                       kShapeFragmentTail,
                   {"place", "row_x", "row_y", "row_z", "size", "light", "look", "ray"});
  }
  return program;
}

void Context::make_target(Target& target, GLenum format, int width, int height) const {
  if (width <= target.width && height <= target.height) return;
  target.width = std::max(width, target.width), target.height = std::max(height, target.height);
  gl_.glBindTexture(GL_TEXTURE_2D, target.colour);
  gl_.glTexImage2D(GL_TEXTURE_2D, 0, static_cast<GLint>(format), target.width, target.height, 0,
                   format == GL_R32F ? GL_RED : GL_RGBA, GL_FLOAT, nullptr);
  gl_.glBindRenderbuffer(GL_RENDERBUFFER, target.depth);
  gl_.glRenderbufferStorage(GL_RENDERBUFFER, GL_DEPTH_COMPONENT32F, target.width, target.height);
  gl_.glBindFramebuffer(GL_FRAMEBUFFER, target.frame);
  gl_.glFramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, target.colour, 0);
  gl_.glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_RENDERBUFFER, target.depth);
  gl_.check_framebuffer(target.width, target.height);
}

void Context::begin_page(int width, int height, const PageLook& look) {
  const bool index = look.writes == Writes::index;
  Target& target = index ? indices_ : texels_;
  make_target(target, index ? GL_R32F : GL_RGBA32F, width, height);
  page_width_ = width, page_height_ = height;
  page_form_ = index ? GL_RED : GL_RGBA;
  gl_.glBindFramebuffer(GL_FRAMEBUFFER, target.frame);
  gl_.glViewport(0, 0, width, height);
  gl_.glEnable(GL_SCISSOR_TEST);
  gl_.glScissor(0, 0, width, height);
  gl_.glEnable(GL_DEPTH_TEST);
  gl_.glDepthFunc(GL_GREATER);
  gl_.glClearColor(look.background[0], look.background[1], look.background[2], look.background[3]);
  gl_.glClearDepth(0);
  gl_.glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
}

void Context::use(const Program& program, const PageLook& look) const {
  gl_.glUseProgram(program.id);
  gl_.glUniform4f(program.target, 2.0f / static_cast<float>(page_width_),
                  2.0f / static_cast<float>(page_height_), look.shear, 0);
}

void Context::draw_faces(const std::vector<FaceInstance>& faces, const PageLook& look) {
  if (faces.empty()) return;
  Program& program = face_programs_[look.writes];
  if (program.id == 0) {
    program =
        link(program_head(look.writes) + kFaceVertex, program_head(look.writes) + kFaceFragment,
             {"centre", "along_a", "along_b", "plane", "look", "ray"});
  }
  use(program, look);
  gl_.glEnable(GL_CLIP_DISTANCE0);
  gl_.glEnable(GL_CLIP_DISTANCE1);
  draw_instances(faces_, faces.data(), faces.size() * sizeof(FaceInstance), faces.size());
  gl_.glDisable(GL_CLIP_DISTANCE0);
  gl_.glDisable(GL_CLIP_DISTANCE1);
}

void Context::draw(const PageScene& scene, const PageLook& look) {
  draw_faces(scene.faces, look);
  for (const auto& [batch, instances] : scene.shapes) {
    if (instances.empty()) continue;
    const Program& program = shape_program(batch, look.writes);
    use(program, look);
    if (batch.texture != 0) {
      gl_.glUniform1i(program.picture, 0);
      meshes_->bind_texture(batch.texture - 1);
    }
    draw_instances(shapes_, instances.data(), instances.size() * sizeof(ShapeInstance),
                   instances.size());
  }
  meshes_->draw(scene.meshes, page_width_, page_height_, look.shear, look.writes);
}

void Context::end_page(std::vector<float>& pixels) {
  gl_.read(page_width_, page_height_, page_form_, pixels);
}

GatherPass& Context::gather_pass() {
  if (!gather_pass_) {
    gather_pass_ = std::make_unique<GatherPass>(
        gl_, [this](const std::string& vertex, const std::string& fragment) {
          return link(kVersion + vertex, kVersion + fragment, {}).id;
        });
  }
  return *gather_pass_;
}

ContextPool::Lease::Lease(ContextPool& pool) : pool_(pool) {
  {
    const std::lock_guard lock(pool.mutex_);
    if (pool.free_.empty()) {
      const OffscreenGl& gl = *pool.copies_[pool.made_++ % pool.copies_.size()];
      context_ = std::make_unique<Context>(gl, pool.assets_);
      return;
    }
    context_ = std::move(pool.free_.back());
    pool.free_.pop_back();
  }
  context_->make_current();
}

ContextPool::Lease::~Lease() {
  context_->release();
  const std::lock_guard lock(pool_.mutex_);
  pool_.free_.push_back(std::move(context_));
}

}  // namespace seam::render::gl
