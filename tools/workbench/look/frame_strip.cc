#include "tools/workbench/look/frame_strip.h"

#include <algorithm>
#include <cmath>

#include "sim_core/base/image.h"
#include "tools/workbench/look/columns.h"

namespace seam::tools {
namespace {

using measurement::Groups;
using measurement::MeasurementSet;
using measurement::Problem;
using nlohmann::json;

constexpr size_t kMostFrames = 6;
constexpr int kMostWidth_px = 240;  // Of a shown frame: three stand side by side.

bool is_whole_images(const Problem& problem) {
  return problem.facts().rows() > 0 && problem.facts().scalars() > problem.facts().rows() * 3 &&
         problem.facts().kind() == "frames";
}

std::vector<size_t> shown_rows(const Problem& problem) {
  const size_t rows = problem.facts().rows(), count = std::min(rows, kMostFrames);
  std::vector<size_t> shown;
  for (size_t i = 0; i < count; ++i) shown.push_back(count == 1 ? 0 : i * (rows - 1) / (count - 1));
  return shown;
}

// Every k-th pixel, so that the image is not too wide. `value` is that of a sample.
template <class Value>
void append_pixels(const MeasurementSet& set, int k, std::string& bytes, Value value) {
  for (int row = 0; row < set.camera.height_px / k; ++row) {
    for (int column = 0; column < set.camera.width_px / k; ++column) {
      const size_t pixel = static_cast<size_t>(row * k) * set.camera.width_px + column * k;
      for (size_t c = 0; c < 3; ++c)
        bytes += static_cast<char>(std::lround(std::clamp(value(3 * pixel + c), 0.0, 255.0)));
    }
  }
}

// `frame` gives the samples of a row.
template <class Frame>
std::string strip(const Problem& problem, const MeasurementSet& set, bool predicted, Frame frame) {
  const auto table = set.table("frames");
  const int k = (set.camera.width_px + kMostWidth_px - 1) / kMostWidth_px;
  json frames = json::array();
  std::string pixels;
  for (const size_t row : shown_rows(problem)) {
    const int line = problem.facts().line_of_row[row];
    frames.push_back(
        {{"line", line},
         {"row", row},
         {"name", problem.facts().groups[static_cast<size_t>(problem.facts().group_of_row[row])]}});
    size_t in_table = 0;
    while (table.line(in_table) != line) ++in_table;
    const std::vector<uint16_t> seen = read_png(set.inside(table, in_table, "file")).samples;
    append_pixels(set, k, pixels, frame(row, seen));
  }
  return head_bytes({{"frames", std::move(frames)},
                     {"width_px", set.camera.width_px / k},
                     {"height_px", set.camera.height_px / k},
                     {"predicted", predicted}}) +
         pixels;
}

}  // namespace

std::string measured_frames(const Problem& problem, const MeasurementSet& set) {
  if (!is_whole_images(problem)) return "";
  return strip(problem, set, false, [](size_t, const std::vector<uint16_t>& seen) {
    return [&seen](size_t sample) { return static_cast<double>(seen[sample]); };
  });
}

std::string predicted_frames(const Problem& problem, const MeasurementSet& set,
                             const measurement::Model& model) {
  if (!is_whole_images(problem)) return "";
  const auto& facts = problem.facts();
  Groups groups(facts.groups.size(), 0);
  for (const size_t row : shown_rows(problem))
    groups[static_cast<size_t>(facts.group_of_row[row])] = 1;
  const auto evaluation = problem.evaluate(model, groups);
  if (!evaluation.valid) return "";
  const size_t samples = facts.scalars() / facts.rows();
  return strip(problem, set, true, [&](size_t row, const std::vector<uint16_t>& seen) {
    return [&evaluation, &seen, row, samples](size_t sample) {
      return seen[sample] - evaluation.residual[row * samples + sample];
    };
  });
}

}  // namespace seam::tools
