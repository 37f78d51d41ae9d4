#include "render/renderer.h"

#include <algorithm>
#include <map>
#include <mutex>

#include "effects/catalogue_help.h"
#include "effects/questions.h"
#include "effects/stages/geometry.h"
#include "effects/stages/optics.h"
#include "effects/stages/sensor/sensor.h"
#include "render/cast/light_integrator.h"
#include "render/cast/ray_store.h"
#include "render/colour/colour_space.h"
#include "render/filter/camera_filter.h"
#include "render/filter/optics_filter.h"
#include "render/gl/device.h"
#include "render/ground_truth.h"
#include "sim_core/base/error.h"
#include "sim_core/base/hash.h"

namespace seam::render {
namespace {

using effects::GainField;

// "effects.radial_distortion {kappa: 3}": the keys of a model file that an error of its geometry is
// about. Every lens can be inverted but for these.
std::string geometry_keys(const effects::Model& model) {
  std::string keys;
  for (const effects::ModelEffect& effect : model.effects()) {
    if (effect.definition->stage != effects::Stage::geometry ||
        effect.definition->base == effects::Base::projection)
      continue;
    std::string values;
    // Of many values those that are neutral are not named.
    const bool many = effects::has_many_values(*effect.definition);
    for (size_t i = 0; i < effect.parameters.size(); ++i) {
      const effects::Parameter& parameter = effect.definition->parameters[i];
      const double value = effect.parameters[i].value;
      if (many && value == parameter.neutral) continue;
      values += fmt::format("{}{}: {}", values.empty() ? "" : ", ", parameter.name, value);
    }
    keys += fmt::format("{}effects.{} {{{}}}", keys.empty() ? "" : ", ", effect.definition->name,
                        values);
  }
  return keys.empty() ? "effects." + effects::base_name(effects::Base::projection) : keys;
}

uint64_t fingerprint_of(const Frame& frame) {
  Hasher hasher;
  hasher.add(static_cast<int64_t>(frame.width_px));
  hasher.add(static_cast<int64_t>(frame.height_px));
  hasher.add(frame.stamp.ns());
  for (const RowWindow& row : frame.rows) hasher.add(row.start.ns()), hasher.add(row.end.ns());
  hasher.add_bytes(frame.rgb);
  return hasher.digest();
}

}  // namespace

struct Renderer::Impl {
  effects::Model model;
  RendererOptions options;
  int width_px, height_px;
  effects::Projection projection;
  effects::Optics optics;
  GainField gain_field;
  effects::SensorChain sensor;
  CameraFilter filter;
  bool moving_lens;  // The geometry depends on time: tables are made for each frame.
  std::shared_ptr<const CameraRays> rays;
  mutable std::mutex patterns_mutex;
  mutable std::map<std::pair<uint64_t, uint64_t>, std::unique_ptr<effects::FixedPattern>> patterns;

  Impl(const effects::Model& whole, int width, int height, const RendererOptions& o)
      : model(effects::without_points_own(whole)),
        options(o),
        width_px(width),
        height_px(height),
        projection(model, width, height),
        optics(effects::optics_of(model)),
        gain_field(model, effects::Stage::radiometry, width, height),
        sensor(effects::sensor_of(model)),
        filter(model, width, height),
        moving_lens(geometry_varies_with_time(projection)),
        rays(find_rays()) {}

  std::string subject() const {
    return fmt::format("model '{}': {}", model.name(), geometry_keys(model));
  }

  std::shared_ptr<const CameraRays> find_rays() const {
    const auto make = [&] {
      return make_camera_rays(projection, subject(), filter.border_px(), 0);
    };
    if (!options.ray_store) return std::make_shared<const CameraRays>(make());
    return options.ray_store->get(fmt::format("{}border {}", projection.key(), filter.border_px()),
                                  make);
  }

  double seconds(SimTime time) const { return (time - options.reference).s(); }

  // OpenGL takes its samples everywhere, the ray caster many at edges alone. A lens that blurs by
  // sigma averages those of 4 pi sigma^2 pixels, so that fewer a pixel give the same image.
  RendererOptions drawn_options() const {
    constexpr double kBlurs_px = 0.7;  // The samples of 6 pixels.
    RendererOptions drawn = options;
    if (optics.blur_sigma_px >= kBlurs_px)
      drawn.edge_samples_per_pixel = drawn.edge_samples_per_pixel * 5 / 8;
    return drawn;
  }

  // Light on an ideal lens's image, border included.
  LinearImage bordered_scene(const FrameJob& job) const {
    CameraRays own;
    if (moving_lens) {
      own = make_camera_rays(projection, subject(), filter.border_px(),
                             seconds(job.schedule.rows[height_px / 2].start));
    }
    const CameraRays& used = moving_lens ? own : *rays;
    LinearImage image{.width_px = used.columns(), .height_px = used.rows()};
    for (auto& plane : image.planes)
      plane.resize(static_cast<size_t>(image.width_px) * image.height_px);
    if (options.opengl)
      options.opengl->integrate_light(job, used, drawn_options(), image);
    else
      integrate_light(plan_sampling(job, used, options), used, job, options, image);
    return image;
  }

  std::vector<float> lamp_factors(const FrameJob& job) const {
    std::vector<float> factors;
    for (const RowWindow& row : job.schedule.rows) {
      const effects::LightWindow window{seconds(row.start), (row.end - row.start).s()};
      factors.push_back(static_cast<float>(effects::lamp_brightness(model, window)));
    }
    return factors;
  }

  const effects::FixedPattern& pattern_of(RandomStream camera) const {
    const std::lock_guard lock(patterns_mutex);
    auto& pattern = patterns[{camera.seed, camera.stream}];
    if (!pattern) {
      pattern = std::make_unique<effects::FixedPattern>(
          effects::fixed_pattern(sensor, width_px, height_px, 3, camera));
    }
    return *pattern;
  }

  effects::SensorExposure exposure_of(const FrameJob& job) const {
    const RowWindow& row = job.schedule.rows[0];
    return {
        .exposure_s = (row.end - row.start).s(), .t_s = seconds(job.stamp), .numbers_only = true};
  }

  // Light on the sensor, interleaved.
  std::vector<float> illumination(const FrameJob& job) const {
    std::vector<float> light;
    filter.apply(bordered_scene(job), row_motion(job, *rays, optics.blur_sigma_px),
                 lamp_factors(job), light);
    return light;
  }

  // The same in separate passes; calls see(name, image) after each.
  template <typename See>
  void see_optics(const FrameJob& job, See&& see) const {
    const LinearImage bordered = bordered_scene(job);
    LinearImage image = without_border(bordered, filter.border_px());
    see("scene", image);
    if (filter.border_px() > 0) {
      image = filter.blurred(bordered, row_motion(job, *rays, optics.blur_sigma_px));
      see("blur", image);
    }
    if (effects::lamps_flicker(model)) {
      scale_rows(image, lamp_factors(job));
      see("flicker", image);
    }
    if (!gain_field.uniform()) {
      std::array<std::vector<float>, 3> gain;
      for (size_t i = 0; i < filter.gain().size(); ++i) gain[i % 3].push_back(filter.gain()[i]);
      apply_gain(image, gain);
      see("vignetting", image);
    }
    if (optics.glare_fraction > 0) {
      add_glare(image, optics.glare_fraction);
      see("glare", image);
    }
    if (!filter.own_light().empty()) {
      add_own_light(image, filter.own_light());
      see("own light", image);
    }
  }

  std::vector<uint8_t> expose(const FrameJob& job, const std::vector<float>& light) const {
    std::vector<uint8_t> rgb(light.size());
    effects::expose_bytes(
        sensor, pattern_of(job.camera_noise), [&](size_t first, size_t) { return &light[first]; },
        exposure_of(job), job.frame_noise, rgb);
    return rgb;
  }
};

void develop(Frame& frame) {
  frame.ycrcb.resize(frame.rgb.size());
  rgb_to_ycrcb(frame.rgb, frame.ycrcb);
  frame.fingerprint = fingerprint_of(frame);
}

Renderer::Renderer(const effects::Model& model, int width_px, int height_px,
                   const RendererOptions& options) {
  if (width_px < 1 || height_px < 1 || width_px > 8192 || height_px > 8192) {
    throw InputError(fmt::format("model '{}': found an image of {}x{} pixels, expected 1 to 8192",
                                 model.name(), width_px, height_px));
  }
  impl_ = std::make_unique<Impl>(model, width_px, height_px, options);
}

Renderer::~Renderer() = default;
Renderer::Renderer(Renderer&&) noexcept = default;
Renderer& Renderer::operator=(Renderer&&) noexcept = default;

int Renderer::width_px() const {
  return impl_->width_px;
}
int Renderer::height_px() const {
  return impl_->height_px;
}
const effects::Model& Renderer::model() const {
  return impl_->model;
}

LinearImage Renderer::render_scene(const FrameJob& job) const {
  return without_border(impl_->bordered_scene(job), impl_->filter.border_px());
}

LinearImage Renderer::render_linear(const FrameJob& job) const {
  const std::vector<float> light = impl_->illumination(job);
  LinearImage image{.width_px = impl_->width_px, .height_px = impl_->height_px};
  for (int c = 0; c < 3; ++c) {
    image.planes[c].resize(light.size() / 3);
    for (size_t i = 0; i < image.planes[c].size(); ++i) image.planes[c][i] = light[3 * i + c];
  }
  return image;
}

Frame Renderer::render(const FrameJob& job) const {
  Frame frame{.robot = job.robot,
              .frame_index = job.frame_index,
              .stamp = job.stamp,
              .width_px = impl_->width_px,
              .height_px = impl_->height_px,
              .rows = job.schedule.rows};
  frame.rgb = impl_->expose(job, impl_->illumination(job));
  develop(frame);
  return frame;
}

GroundTruth Renderer::ground_truth(const FrameJob& job) const {
  return make_ground_truth(job, *impl_->rays, impl_->projection, impl_->options.opengl);
}

std::vector<StageImage> Renderer::stages(const FrameJob& job) const {
  std::vector<StageImage> stages;
  impl_->see_optics(job, [&](const char* name, const LinearImage& image) {
    stages.push_back({name, image});
  });
  const auto bytes_stage = [&](const char* name, const std::vector<uint8_t>& bytes) {
    StageImage stage{name, {.width_px = impl_->width_px, .height_px = impl_->height_px}};
    for (size_t i = 0; i < bytes.size(); ++i) {
      stage.image.planes[i % 3].push_back(static_cast<float>(bytes[i]) / 255.0f);
    }
    stages.push_back(std::move(stage));
  };
  const std::vector<uint8_t> rgb = impl_->expose(job, impl_->illumination(job));
  bytes_stage("sensor", rgb);
  std::vector<uint8_t> ycrcb(rgb.size());
  rgb_to_ycrcb(rgb, ycrcb);
  bytes_stage("ycrcb", ycrcb);
  return stages;
}

}  // namespace seam::render
