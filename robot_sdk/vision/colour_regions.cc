#include "robot_sdk/vision/colour_regions.h"

#include <algorithm>
#include <numeric>
#include <tuple>

namespace seam::sdk {
namespace {

std::vector<Run> find_runs(const ColourMask& mask, Colour colour) {
  std::vector<Run> runs;
  for (int v = 0; v < mask.height_px; ++v) {
    for (int u = 0; u < mask.width_px; ++u) {
      if (!mask.has(u, v, colour)) continue;
      const int first = u;
      while (u + 1 < mask.width_px && mask.has(u + 1, v, colour)) ++u;
      runs.push_back({v, first, u});
    }
  }
  return runs;
}

// Union-find over runs.
struct Forest {
  std::vector<size_t> parent;
  explicit Forest(size_t count) : parent(count) {
    std::iota(parent.begin(), parent.end(), size_t{0});
  }
  size_t root(size_t i) {
    while (parent[i] != i) i = parent[i] = parent[parent[i]];
    return i;
  }
  // The smaller index becomes the root, so that results do not depend on the order of unions.
  void join(size_t a, size_t b) {
    a = root(a), b = root(b);
    parent[std::max(a, b)] = std::min(a, b);
  }
};

Region region_of(std::vector<Run> runs, Colour colour, const ColourMask& mask) {
  Region region{.colour = colour,
                .u_min = runs.front().u_first,
                .u_max = runs.front().u_last,
                .v_min = runs.front().v,
                .v_max = runs.back().v};
  int64_t sum_u2 = 0, sum_v = 0;  // Twice the sum of columns: exact.
  for (const Run& run : runs) {
    const int count = run.u_last - run.u_first + 1;
    region.area_px += count;
    region.u_min = std::min(region.u_min, run.u_first);
    region.u_max = std::max(region.u_max, run.u_last);
    sum_u2 += static_cast<int64_t>(run.u_first + run.u_last) * count;
    sum_v += static_cast<int64_t>(run.v) * count;
  }
  region.u_mean = static_cast<float>(static_cast<double>(sum_u2) / (2.0 * region.area_px));
  region.v_mean = static_cast<float>(static_cast<double>(sum_v) / region.area_px);
  region.at_border = region.u_min == 0 || region.v_min == 0 || region.u_max == mask.width_px - 1 ||
                     region.v_max == mask.height_px - 1;
  region.runs = std::move(runs);
  return region;
}

}  // namespace

std::vector<Region> find_regions(const ColourMask& mask, Colour colour, int min_area_px) {
  const std::vector<Run> runs = find_runs(mask, colour);
  Forest forest(runs.size());
  size_t above = 0;
  for (size_t i = 0; i < runs.size(); ++i) {
    while (above < i &&
           (runs[above].v < runs[i].v - 1 ||
            (runs[above].v == runs[i].v - 1 && runs[above].u_last < runs[i].u_first - 1))) {
      ++above;
    }
    for (size_t j = above;
         j < i && runs[j].v == runs[i].v - 1 && runs[j].u_first <= runs[i].u_last + 1; ++j) {
      if (runs[j].u_last >= runs[i].u_first - 1) forest.join(i, j);
    }
  }
  std::vector<std::vector<Run>> members(runs.size());
  for (size_t i = 0; i < runs.size(); ++i) members[forest.root(i)].push_back(runs[i]);
  std::vector<Region> regions;
  for (auto& member : members) {
    if (member.empty()) continue;
    Region region = region_of(std::move(member), colour, mask);
    if (region.area_px >= min_area_px) regions.push_back(std::move(region));
  }
  std::sort(regions.begin(), regions.end(), [](const Region& a, const Region& b) {
    return std::tuple(-a.area_px, a.v_min, a.u_min) < std::tuple(-b.area_px, b.v_min, b.u_min);
  });
  return regions;
}

}  // namespace seam::sdk
