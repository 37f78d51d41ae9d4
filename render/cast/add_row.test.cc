// Light of a row's hits, for as many places as registers hold and for more, against the formula.
#include <gtest/gtest.h>

#include <vector>

#include "render/cast/cast_kernels.h"
#include "sim_core/base/random.h"

namespace seam::render {
namespace {

TEST(AddRow, EachPixelGetsTheColourOfItsPlace) {
  for (const int places : {1, 2, 8, 9, 16, 17, 32, 33, 64, 65, 200}) {
    for (const int count : {1, 7, 16, 45, 184}) {
      const RandomStream stream{.seed = 3, .stream = static_cast<uint64_t>(places * 1000 + count)};
      uint64_t drawn = 0;
      const auto draw = [&] { return static_cast<float>(uniform(stream, drawn++)); };
      std::vector<Colour> colours;
      std::vector<uint32_t> looks;
      for (int place = 0; place < places; ++place) {
        colours.push_back({{draw(), draw(), draw(), 0}});
        looks.push_back(static_cast<uint32_t>(4e9 * uniform(stream, drawn++)));
      }
      std::vector<int32_t> id;
      std::vector<float> factor, sum[3];
      for (int i = 0; i < count; ++i) {
        id.push_back(static_cast<int32_t>(places * uniform(stream, drawn++)) - 1);
        factor.push_back(draw());
        for (auto& plane : sum) plane.push_back(draw());
      }
      for (const bool shaded : {false, true}) {
        const float weight = draw();
        const std::vector<float> before[3] = {sum[0], sum[1], sum[2]};
        std::vector<uint32_t> found(static_cast<size_t>(count));
        float* const sums[3] = {sum[0].data(), sum[1].data(), sum[2].data()};
        cast_kernels().add_row(colours.data(), looks.data(), places, id.data(),
                               shaded ? factor.data() : nullptr, weight, count, sums, found.data());
        for (size_t i = 0; i < found.size(); ++i) {
          const auto place = static_cast<size_t>(id[i] + 1);
          const float scale = shaded ? weight * factor[i] : weight;
          ASSERT_EQ(found[i], looks[place]) << places << " places, pixel " << i;
          for (int c = 0; c < 3; ++c)
            ASSERT_EQ(sum[c][i], before[c][i] + scale * colours[place].rgb[c])
                << places << " " << i;
        }
      }
    }
  }
}

}  // namespace
}  // namespace seam::render
