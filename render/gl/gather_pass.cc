#include "render/gl/gather_pass.h"

#include <algorithm>

#include "render/gl/shaders.h"

namespace seam::render::gl {
namespace {

constexpr int kPaletteWidth = 1024;

}  // namespace

GatherPass::GatherPass(const Api& gl, const Linker& link)
    : gl_(gl), program_(link(kGatherVertex, kGatherFragment)) {
  gl_.glGenVertexArrays(1, &no_inputs_);
  gl_.glGenFramebuffers(1, &frame_);
  for (GLuint* texture : {&sums_, &rays_, &bands_, &palette_}) *texture = gl_.make_texture();
  gl_.glUseProgram(program_);
  const auto find = [&](const char* name) { return gl_.glGetUniformLocation(program_, name); };
  grid_ = find("grid"), count_ = find("count"), form_ = find("form");
  gl_.glGetIntegerv(GL_MAX_TEXTURE_SIZE, &most_texels_);
  int unit = 0;
  for (const char* name : {"rays", "bands", "texels", "palette"})
    gl_.glUniform1i(find(name), unit++);
}

void GatherPass::upload(GLuint texture, int width, int height, const float* rgba) const {
  gl_.glBindTexture(GL_TEXTURE_2D, texture);
  gl_.glTexImage2D(GL_TEXTURE_2D, 0, GL_RGBA32F, width, height, 0, GL_RGBA, GL_FLOAT, rgba);
}

void GatherPass::upload_rays(const CameraRays& rays) {
  const size_t count = rays.at(rays.rows());
  floats_.clear(), floats_.reserve(8 * count * rays.tables.size());
  for (const RayTable& table : rays.tables) {
    for (size_t i = 0; i < count; ++i) {
      for (const auto* slopes : {&table.base, &table.along_u})
        floats_.insert(floats_.end(), {(*slopes)[0][i], (*slopes)[1][i]});
    }
    for (size_t i = 0; i < count; ++i)
      floats_.insert(floats_.end(), {table.along_v[0][i], table.along_v[1][i], 0, 0});
  }
  upload(rays_, rays.columns(), height_of(rays), floats_.data());
  held_ = rays.identity;
}

int GatherPass::upload_bands(const Page& page, const RowSchedule& schedule,
                             const CameraRays& rays) {
  const auto see = [&](const auto& found) {
    for (const Band& band : page.bands) {
      for (int row = band.rows.first; row <= band.rows.last; ++row) {
        const double weight = weight_of(band, row, schedule, rays);
        if (weight != 0) found(band, row, weight);
      }
    }
  };
  std::vector<int> held(rays.rows());
  see([&](const Band&, int row, double) { ++held[row]; });
  const int most = std::max(1, *std::max_element(held.begin(), held.end()));
  floats_.assign(static_cast<size_t>(8) * most * rays.rows(), 0.0f);
  std::fill(held.begin(), held.end(), 0);
  see([&](const Band& band, int row, double weight) {
    float* const at = &floats_[8 * (static_cast<size_t>(row) * most + held[row]++)];
    at[0] = band.shift_u - static_cast<float>(band.first_x);
    at[1] = band.shift_v - static_cast<float>(band.first_y);
    at[2] = static_cast<float>(band.page_y), at[3] = static_cast<float>(band.height - 1);
    at[4] = static_cast<float>(weight);
  });
  upload(bands_, 2 * most, rays.rows(), floats_.data());
  return most;
}

bool GatherPass::holds(const CameraRays& rays) const {
  return rays.perspective && std::max(rays.columns(), height_of(rays)) <= most_texels_;
}

void GatherPass::begin(const CameraRays& rays) {
  if (rays.identity != held_) upload_rays(rays);
  gl_.glBindFramebuffer(GL_FRAMEBUFFER, frame_);
  if (columns_ != rays.columns() || rows_ != rays.rows()) {
    columns_ = rays.columns(), rows_ = rays.rows();
    upload(sums_, columns_, rows_, nullptr);
    gl_.glFramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, sums_, 0);
    gl_.check_framebuffer(columns_, rows_);
  }
  gl_.glDisable(GL_SCISSOR_TEST);
  gl_.glClearColor(0, 0, 0, 0);
  gl_.glClear(GL_COLOR_BUFFER_BIT);
}

void GatherPass::add(GLuint texels, const Page& page, const StripScale& scale,
                     const std::vector<Colour>* palette, const RowSchedule& schedule,
                     const CameraRays& rays) {
  const int bands = upload_bands(page, schedule, rays);
  if (palette) {
    const int height = static_cast<int>(palette->size()) / kPaletteWidth + 1;
    floats_.assign(static_cast<size_t>(4) * kPaletteWidth * height, 0.0f);
    for (size_t i = 0; i < palette->size(); ++i) std::copy_n((*palette)[i].rgb, 3, &floats_[4 * i]);
    upload(palette_, kPaletteWidth, height, floats_.data());
  }
  gl_.glUseProgram(program_);
  gl_.glUniform4f(grid_, scale.u_per_unit, scale.shear * scale.v_per_unit, scale.v_per_unit,
                  static_cast<float>(page.width));
  gl_.glUniform4f(count_, static_cast<float>(scale.across), static_cast<float>(scale.down),
                  static_cast<float>(bands), static_cast<float>(rays.tables.size()));
  gl_.glUniform4f(form_, static_cast<float>(rays.rows()), palette ? kPaletteWidth : 0, 0, 0);
  GLenum unit = GL_TEXTURE0;
  for (const GLuint texture : {rays_, bands_, texels, palette_}) {
    gl_.glActiveTexture(unit++);
    gl_.glBindTexture(GL_TEXTURE_2D, texture);
  }
  gl_.glActiveTexture(GL_TEXTURE0);
  gl_.glBindFramebuffer(GL_FRAMEBUFFER, frame_);
  gl_.glViewport(0, 0, columns_, rows_);
  gl_.glDisable(GL_SCISSOR_TEST);
  gl_.glDisable(GL_DEPTH_TEST);
  // What other pages gave stays: an image's light may lie on several.
  gl_.glEnable(GL_BLEND);
  gl_.glBlendFunc(GL_ONE, GL_ONE);
  gl_.glBindVertexArray(no_inputs_);
  gl_.glDrawArraysInstanced(GL_TRIANGLES, 0, 3, 1);
  gl_.glDisable(GL_BLEND);
}

void GatherPass::end(LinearImage& image) {
  gl_.glBindFramebuffer(GL_FRAMEBUFFER, frame_);
  gl_.read(columns_, rows_, GL_RGBA, floats_);
  const size_t pixels = floats_.size() / 4;
  for (size_t c = 0; c < 3; ++c) {
    for (size_t i = 0; i < pixels; ++i) image.planes[c][i] = floats_[4 * i + c];
  }
}

}  // namespace seam::render::gl
