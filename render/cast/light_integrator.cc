#include "render/cast/light_integrator.h"

#include <algorithm>
#include <cmath>

#include "effects/stages/row_schedule.h"
#include "render/cast/frame_scenes.h"
#include "render/cast/parallel.h"
#include "render/cast/scene_motion.h"
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

// From one of `a_row` instants of a row to its next, in times of that between instants k and k + 1.
double row_step(const FrameJob& job, int a_row, size_t k) {
  const SimDuration exposure = job.schedule.rows[0].end - job.schedule.rows[0].start;
  const double step_ns = static_cast<double>(exposure.ns()) / a_row;
  const double span_ns =
      static_cast<double>((job.instants[k + 1].time - job.instants[k].time).ns());
  return span_ns > 0 ? step_ns / span_ns : 0;
}

// How many instants a row needs so that nothing moves further than allowed between two; motion(k):
// how far it moves from the job's instant k to the next, pixels.
template <typename Motion>
int instants_wanted(const FrameJob& job, const RendererOptions& options, const Motion& motion) {
  const int given = fewest_instants(job.schedule);
  if (given < 2) return given;
  double fastest_px = 0;  // In the time between two instants of a row.
  for (size_t k = 0; k + 1 < job.instants.size(); ++k)
    fastest_px = std::max(fastest_px, motion(k) * row_step(job, given, k));
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

SampledInstants::SampledInstants(const FrameJob& job, const CameraRays& rays, int a_row)
    : job_(job) {
  SEAM_CHECK(job.instants.size() == job.schedule.instants.size() && !job.instants.empty(), "{} {}",
             job.instants.size(), job.schedule.instants.size());
  SEAM_CHECK(static_cast<int>(job.schedule.rows.size()) == rays.height_px, "{}",
             job.schedule.rows.size());
  refined_ = a_row > fewest_instants(job.schedule);
  if (refined_) finer_ = effects::schedule_of_windows(job.schedule.rows, a_row);
  fewest_a_row_ = fewest_instants(schedule());
  rows_ = rows_that_see(schedule(), rays);
}

SampledInstants::SampledInstants(const FrameJob& job, const CameraRays& rays,
                                 const RendererOptions& options)
    : SampledInstants(job, rays, instants_wanted(job, options, [&](size_t k) {
                        return FrameScenes(job, rays).motion_px(k, 0);
                      })) {}

void SampledInstants::with_scene(int k, const std::function<void(const SceneInstant&)>& see) const {
  if (refined_)
    see(scene_at(job_, finer_.instants[k]));
  else
    see(job_.instants[k]);
}

namespace {

// Calls prepare(scenes, k, out) for each of the instants.
template <typename Prepare>
void prepare_scenes(const FrameJob& job, const CameraRays& rays, int threads, SamplingPlan& plan,
                    const Prepare& prepare) {
  plan.scenes = std::vector<PreparedInstant>(static_cast<size_t>(plan.instants.count()));
  split_over_threads(threads, plan.instants.count(), [&](int begin, int end) {
    FrameScenes scenes(job, rays);
    for (int k = begin; k < end; ++k) prepare(scenes, k, plan.scenes[k]);
  });
}

}  // namespace

SamplingPlan plan_sampling(const FrameJob& job, const CameraRays& rays,
                           const RendererOptions& options) {
  // Most frames need no instants but their own.
  SamplingPlan plan{.instants = SampledInstants(job, rays, 0), .scenes = {}};
  std::vector<double> motion_px(job.instants.size());
  prepare_scenes(job, rays, options.threads, plan,
                 [&](FrameScenes& scenes, int k, PreparedInstant& out) {
                   scenes.prepare_at(static_cast<size_t>(k), plan.instants.rows_of(k), out);
                   if (k == 0) return;
                   const auto before = static_cast<size_t>(k) - 1;
                   const double step = row_step(job, plan.instants.fewest_a_row(), before);
                   const double enough_px = step > 0 ? options.max_motion_px / step : 1e30;
                   motion_px[before] = scenes.motion_px(before, enough_px);
                 });
  const int wanted = instants_wanted(job, options, [&](size_t k) { return motion_px[k]; });
  if (wanted == plan.instants.fewest_a_row()) return plan;
  SamplingPlan refined{.instants = SampledInstants(job, rays, wanted), .scenes = {}};
  prepare_scenes(job, rays, options.threads, refined,
                 [&](FrameScenes& scenes, int k, PreparedInstant& out) {
                   scenes.prepare_at(refined.instants.schedule().instants[k],
                                     refined.instants.rows_of(k), out);
                 });
  return refined;
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
      const size_t first = rays.at(row);
      float* const light[3] = {&image.planes[0][first], &image.planes[1][first],
                               &image.planes[2][first]};
      caster.cast_row(row, samples, light);
    }
  });
}

}  // namespace seam::render
