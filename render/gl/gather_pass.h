// Looking up samples where the page lies: a graphics processor sums each pixel's texels itself, so
// that an image of sums is read back and not the page, which is some thirty times as large. The
// sums are gather_light's, of one flat view.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "render/gl/film_strip.h"
#include "render/gl/offscreen/api.h"

namespace seam::render::gl {

class GatherPass {
 public:
  // Makes a program of shaders without inputs, whose version it states. Needs a current context, as
  // all functions do; `gl` outlives the pass.
  using Linker = std::function<GLuint(const std::string& vertex, const std::string& fragment)>;
  GatherPass(const Api& gl, const Linker& link);

  // Whether textures can hold what it needs of these rays: of perspective ones, not of huge images.
  bool holds(const CameraRays& rays) const;
  // A new frame, dark so far.
  void begin(const CameraRays& rays);
  // Adds the light of a page, whose texels are this texture: as gather_light has it.
  void add(GLuint texels, const Page& page, const StripScale& scale,
           const std::vector<Colour>* palette, const RowSchedule& schedule, const CameraRays& rays);
  // Reads the frame; the image is as large as the table of rays.
  void end(LinearImage& image);

 private:
  void upload(GLuint texture, int width, int height, const float* rgba) const;
  void upload_rays(const CameraRays& rays);
  static int height_of(const CameraRays& rays) {
    return 2 * rays.rows() * static_cast<int>(rays.tables.size());
  }
  // Of each row the bands in which it collects light. Returns the most of one row.
  int upload_bands(const Page& page, const RowSchedule& schedule, const CameraRays& rays);

  const Api& gl_;
  GLuint program_ = 0, no_inputs_ = 0, frame_ = 0;
  GLint grid_ = -1, count_ = -1, form_ = -1;
  GLuint sums_ = 0, rays_ = 0, bands_ = 0, palette_ = 0;
  int columns_ = 0, rows_ = 0;
  int most_texels_ = 0;               // Along a texture's side.
  std::shared_ptr<const bool> held_;  // CameraRays::identity of those that lie there.
  std::vector<float> floats_;         // Of one call.
};

}  // namespace seam::render::gl
