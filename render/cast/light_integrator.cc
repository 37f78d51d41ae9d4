#include "render/cast/light_integrator.h"

#include <algorithm>
#include <cmath>

#include "effects/stages/row_schedule.h"
#include "render/cast/parallel.h"
#include "sim_core/base/error.h"

namespace seam::render {
namespace {

// A frame never gets more instants a row than this by motion alone.
constexpr int kMaxRefinedInstants = 512;

int divide_up(int a, int b) {
  return (a + b - 1) / b;
}

int fewest_instants(const RowSchedule& schedule) {
  size_t fewest = schedule.weights[0].size();
  for (const auto& weights : schedule.weights) fewest = std::min(fewest, weights.size());
  return static_cast<int>(fewest);
}

// How many instants a row needs so that nothing moves further than allowed between two.
int instants_wanted(const FrameJob& job, const CameraRays& rays, const RendererOptions& options) {
  const int given = fewest_instants(job.schedule);
  const SimDuration exposure = job.schedule.rows[0].end - job.schedule.rows[0].start;
  if (given < 2 || job.instants.size() < 2 || exposure.ns() == 0) return given;
  double fastest_px = 0;  // In the time between two instants of a row.
  const double step_ns = static_cast<double>(exposure.ns()) / given;
  for (size_t k = 0; k + 1 < job.instants.size(); ++k) {
    const double span_ns =
        static_cast<double>((job.instants[k + 1].time - job.instants[k].time).ns());
    const double motion = image_motion_px(job.instants[k], job.instants[k + 1], rays.focal_px);
    if (span_ns > 0) fastest_px = std::max(fastest_px, motion * step_ns / span_ns);
  }
  const double factor = std::ceil(fastest_px / options.max_motion_px - 1e-9);
  if (!(factor > 1)) return given;
  return static_cast<int>(std::min<double>(factor * given, std::max(kMaxRefinedInstants, given)));
}

// For each instant the rows of rays that sample it, from the first to the last; rows of the border
// go with the nearest row of the image.
std::vector<RowRange> rows_that_see(const RowSchedule& schedule, const CameraRays& rays) {
  std::vector<RowRange> ranges(schedule.instants.size(), {rays.rows(), -1});
  for (int row = 0; row < rays.rows(); ++row) {
    const int image_row = std::clamp(row - rays.border_px, 0, rays.height_px - 1);
    const size_t first = static_cast<size_t>(schedule.first_instant[image_row]);
    for (size_t k = first; k < first + schedule.weights[image_row].size(); ++k) {
      ranges[k].first = std::min(ranges[k].first, row);
      ranges[k].last = std::max(ranges[k].last, row);
    }
  }
  // An instant that no row samples.
  for (RowRange& range : ranges) {
    if (range.last < 0) range = {0, 0};
  }
  return ranges;
}

SceneInstant scene_at(const FrameJob& job, SimTime time) {
  const auto after = std::lower_bound(job.instants.begin(), job.instants.end(), time,
                                      [](const SceneInstant& a, SimTime t) { return a.time < t; });
  const auto b = std::clamp(after, job.instants.begin() + 1, job.instants.end() - 1);
  return interpolate(*(b - 1), *b, time);
}

}  // namespace

SampledInstants::SampledInstants(const FrameJob& job, const CameraRays& rays,
                                 const RendererOptions& options)
    : job_(job) {
  SEAM_CHECK(job.instants.size() == job.schedule.instants.size() && !job.instants.empty(), "{} {}",
             job.instants.size(), job.schedule.instants.size());
  SEAM_CHECK(static_cast<int>(job.schedule.rows.size()) == rays.height_px, "{}",
             job.schedule.rows.size());
  const int wanted = instants_wanted(job, rays, options);
  refined_ = wanted > fewest_instants(job.schedule);
  schedule_ = refined_ ? effects::schedule_of_windows(job.schedule.rows, wanted) : job.schedule;
  rows_ = rows_that_see(schedule_, rays);
}

int SampledInstants::fewest_a_row() const {
  return fewest_instants(schedule_);
}

void SampledInstants::with_scene(int k, const std::function<void(const SceneInstant&)>& see) const {
  if (refined_)
    see(scene_at(job_, schedule_.instants[k]));
  else
    see(job_.instants[k]);
}

SamplingPlan plan_sampling(const FrameJob& job, const CameraRays& rays,
                           const RendererOptions& options) {
  SamplingPlan plan{.instants = SampledInstants(job, rays, options), .scenes = {}};
  plan.scenes.resize(plan.instants.count());
  split_over_threads(options.threads, static_cast<int>(plan.scenes.size()),
                     [&](int begin, int end) {
                       for (int k = begin; k < end; ++k) {
                         plan.instants.with_scene(k, [&](const SceneInstant& scene) {
                           prepare(scene, job.lighting, job.background, rays,
                                   plan.instants.rows_of(k), plan.scenes[k]);
                         });
                       }
                     });
  return plan;
}

void integrate_light(const SamplingPlan& plan, const CameraRays& rays, const FrameJob& job,
                     const RendererOptions& options, LinearImage& image) {
  const SamplePattern pattern(rays.columns());
  split_over_threads(options.threads, rays.rows(), [&](int begin, int end) {
    // Every row holds nearly as many instants as any other; all refine their edges alike.
    const int instants_a_row = plan.instants.fewest_a_row();
    const int first_look = instants_a_row * divide_up(options.samples_per_pixel, instants_a_row);
    RowCaster caster(rays, pattern, job.lighting.lambert,
                     divide_up(options.edge_samples_per_pixel, first_look));
    std::vector<RowSample> samples;
    std::vector<int> order;
    for (int row = begin; row < end; ++row) {
      const int image_row = std::clamp(row - rays.border_px, 0, rays.height_px - 1);
      const std::vector<double>& weights = plan.instants.schedule().weights[image_row];
      const int instants = static_cast<int>(weights.size());
      const int each = divide_up(options.samples_per_pixel, instants);
      if (order.size() != static_cast<size_t>(instants * each))
        order = SamplePattern::scattered_order(instants * each);
      samples.clear();
      for (int k = 0; k < instants; ++k) {
        const auto& scene = plan.scenes[plan.instants.schedule().first_instant[image_row] + k];
        for (int s = 0; s < each; ++s) {
          samples.push_back({&scene, static_cast<float>(weights[k] / each), order[k * each + s]});
        }
      }
      const std::vector<Colour>& light = caster.cast_row(row, samples);
      for (int c = 0; c < 3; ++c) {
        float* const plane = &image.planes[c][rays.at(row)];
        for (int column = 0; column < rays.columns(); ++column)
          plane[column] = light[column].rgb[c];
      }
    }
  });
}

}  // namespace seam::render
