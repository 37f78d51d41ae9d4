#include "render/gl/device.h"

#include <cmath>
#include <functional>

#include "render/gl/context.h"
#include "render/gl/film_strip.h"
#include "render/gl/instances.h"
#include "sim_core/base/error.h"

namespace seam::render {

namespace {

// Mesa draws and reads a page while it is still in the processor's caches; a graphics processor is
// waited for at each.
gl::PageLimits page_limits(const gl::OffscreenGl& opengl) {
  return {.page_texels = opengl.on_processor() ? 1 << 18 : 1 << 22};
}

// Texels of a pixel at one instant. In their lattice no two see an upright or a level edge at the
// same place, so half as many see as much as samples that stand in squares.
gl::StripScale texels_of_a_pixel(const RendererOptions& options, int instants_a_row) {
  const int samples = std::max(options.edge_samples_per_pixel, options.samples_per_pixel);
  const int wanted =
      std::max(1, static_cast<int>(std::ceil(0.6 * samples / std::max(instants_a_row, 1))));
  const int across = std::max(1, static_cast<int>(std::sqrt(0.5 * wanted)));
  return {.across = across, .down = (wanted + across - 1) / across};
}

Colour colour_of(const Rgb& rgb) {
  return {{static_cast<float>(rgb[0]), static_cast<float>(rgb[1]), static_cast<float>(rgb[2]), 0}};
}

// Whether each surface looks the same all over.
bool has_one_colour_each(const FrameJob& job, const std::vector<gl::ClusteredMesh>& meshes) {
  if (job.lighting.lambert) return false;
  for (const SceneInstant& instant : job.instants) {
    for (const Primitive& primitive : instant.primitives) {
      if (primitive.asset == 0) continue;
      if (primitive.shape != Shape::mesh || !meshes.at(primitive.asset - 1).has_one_colour_each())
        return false;
    }
  }
  return true;
}

}  // namespace

struct GlDevice::Impl {
  Impl(Assets given, const std::string& source, Gathering gathering)
      : assets(std::move(given)),
        opengl(gl::offscreen_gl(source)),
        gathers_in_shaders(gathering == Gathering::by_driver ? !opengl.on_processor()
                                                             : gathering == Gathering::in_shaders) {
  }

  Assets assets;
  const gl::OffscreenGl& opengl;
  const bool gathers_in_shaders;
  const gl::PageLimits limits = page_limits(opengl);
  const std::vector<gl::ClusteredMesh> meshes = gl::cluster_meshes(assets);
  gl::ContextPool contexts{gl::copies_of(opengl), assets};
  std::string version, renderer;

  using SeePage = std::function<void(const gl::Page&, const gl::StripScale&, const gl::StripView&)>;
  // Draws every page of the instants' strips and shows each.
  void draw_pages(gl::Context& context, const FrameJob& job, const CameraRays& rays,
                  const SampledInstants& instants, gl::StripScale samples, gl::PageLook look,
                  gl::Palette* palette, const SeePage& see);
};

GlDevice::GlDevice(Assets assets, const std::string& source, Gathering gathering)
    : impl_(std::make_unique<Impl>(std::move(assets), source, gathering)) {
  const gl::ContextPool::Lease context(impl_->contexts);
  impl_->version = context->version();
  impl_->renderer = context->renderer();
}
GlDevice::~GlDevice() = default;

const std::string& GlDevice::version() const {
  return impl_->version;
}
const std::string& GlDevice::renderer() const {
  return impl_->renderer;
}

bool opengl_is_here(const std::string& source) {
  try {
    gl::offscreen_gl(source);
    return true;
  } catch (const InputError&) {
    return false;
  }
}

std::string GlDevice::source() const {
  return impl_->opengl.source();
}

const Assets& GlDevice::assets() const {
  return impl_->assets;
}

void GlDevice::Impl::draw_pages(gl::Context& context, const FrameJob& job, const CameraRays& rays,
                                const SampledInstants& instants, gl::StripScale samples,
                                gl::PageLook look, gl::Palette* palette, const SeePage& see) {
  const gl::PaintLayers layers(job.instants.front());
  PreparedInstant prepared;
  for (const gl::StripView& view : gl::views_of(rays)) {
    const gl::StripPlan plan = gl::plan_strip(instants, rays, view, samples, limits);
    look.shear = plan.scale.shear;
    for (const gl::Page& page : plan.pages) {
      gl::PageScene on_page;
      context.begin_page(page.width, page.height, look);
      for (const gl::Band& band : page.bands) {
        instants.with_scene(band.instant, [&](const SceneInstant& scene) {
          prepare(scene, job, rays, band.rows, prepared);
          const gl::BandPlace place{band, page, plan.scale, view};
          gl::add_shapes(prepared, scene, layers, place, rays, job.lighting.lambert, palette,
                         on_page);
          gl::add_meshes(scene, meshes, place, rays, job.lighting, palette, on_page);
        });
      }
      context.draw(on_page, look);
      see(page, plan.scale, view);
    }
  }
}

void GlDevice::integrate_light(const FrameJob& given, const CameraRays& rays,
                               const RendererOptions& options, LinearImage& image) const {
  const FrameJob job = with_all_primitives(given);
  const SampledInstants instants(job, rays, options);
  for (auto& plane : image.planes) std::fill(plane.begin(), plane.end(), 0.0f);
  gl::PageLook look;
  gl::Palette palette(colour_of(job.background));
  const bool indexed = has_one_colour_each(job, impl_->meshes);
  look.writes = indexed                ? gl::Writes::index
                : job.lighting.lambert ? gl::Writes::light
                                       : gl::Writes::colour;
  for (int c = 0; c < 3 && !indexed; ++c)
    look.background[c] = static_cast<float>(job.background[c]);
  const gl::StripScale samples = texels_of_a_pixel(options, instants.fewest_a_row());
  gl::Palette* const places = indexed ? &palette : nullptr;
  const auto colours = [&] { return indexed ? &palette.colours() : nullptr; };
  const gl::ContextPool::Lease context(impl_->contexts);
  if (impl_->gathers_in_shaders && context->gather_pass().holds(rays)) {
    gl::GatherPass& sums = context->gather_pass();
    sums.begin(rays);
    impl_->draw_pages(*context, job, rays, instants, samples, look, places,
                      [&](const gl::Page& page, const gl::StripScale& scale, const gl::StripView&) {
                        sums.add(context->page(), page, scale, colours(), instants.schedule(),
                                 rays);
                      });
    sums.end(image);
    return;
  }
  std::vector<float> texels;
  impl_->draw_pages(
      *context, job, rays, instants, samples, look, places,
      [&](const gl::Page& page, const gl::StripScale& scale, const gl::StripView& view) {
        context->end_page(texels);
        gl::gather_light(page, scale, texels, colours(), view, instants.schedule(), rays,
                         options.threads, image);
      });
}

GlDevice::Centres GlDevice::see_centres(const FrameJob& given, const CameraRays& rays) const {
  const FrameJob job = with_all_primitives(given);
  // The texel that holds a centre is at most this part of a pixel away from it.
  constexpr int kSamples = 8;
  const SampledInstants instants(job, rays, {});
  const size_t pixels = static_cast<size_t>(rays.width_px) * rays.height_px;
  Centres seen{std::vector<int32_t>(pixels, -1), std::vector<float>(pixels)};
  const gl::ContextPool::Lease context(impl_->contexts);
  std::vector<float> texels;
  impl_->draw_pages(
      *context, job, rays, instants, {.across = kSamples, .down = kSamples},
      {.writes = gl::Writes::truth}, nullptr,
      [&](const gl::Page& page, const gl::StripScale& scale, const gl::StripView& view) {
        context->end_page(texels);
        gl::find_centres(page, scale, texels, view, instants.schedule(), rays, seen.source,
                         seen.depth);
      });
  return seen;
}

}  // namespace seam::render
