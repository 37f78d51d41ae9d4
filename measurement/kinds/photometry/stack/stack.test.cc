// What is read of a stack of frames: bits, light and exposure, levels that cannot be right, and the
// figures of EMVA 1288 against a sensor whose figures are known.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <random>

#include "measurement/kinds/photometry/stack/emva.h"
#include "measurement/kinds/photometry/stack/photometry_data.h"
#include "measurement/kinds/photometry/stack/stated_light.h"
#include "sim_core/base/error.h"

namespace seam::measurement {
namespace {

constexpr int kWidth = 120, kHeight = 100;

// A camera by plain loops and the standard library's random numbers: 12 bits, K DN an electron.
struct Camera {
  double gain = 0.25, dark_electrons = 8, black = 60, prnu = 0.008, dsnu = 1.5, efficiency = 0.6;
  double k2 = 0;
  uint16_t shift = 0;
};

struct Row {
  double exposure_s, illumination, photons;
  std::string level;
};

class Folder {
 public:
  explicit Folder(const std::string& name)
      : path_(std::filesystem::path(testing::TempDir()) / ("stack-" + name)) {
    std::filesystem::remove_all(path_);
    std::filesystem::create_directories(path_);
  }
  ~Folder() { std::filesystem::remove_all(path_); }

  // Frames in pairs; `truth` is the light that a level really has over what is stated.
  void write(
      const Camera& camera, const std::vector<Row>& rows, const std::string& bits,
      const std::function<double(size_t)>& truth = [](size_t) { return 1.0; }) {
    std::ranlux48_base random(5);
    std::normal_distribution<double> gauss;
    std::vector<double> gain, offset;
    for (int i = 0; i < kWidth * kHeight; ++i)
      gain.push_back(1 + camera.prnu * gauss(random)),
          offset.push_back(camera.dsnu * gauss(random));
    std::ofstream csv(path_ / "frames.csv");
    csv << "frame,file,time_s,exposure_s,illumination,photons,level\n";
    int frame = 0;
    for (size_t r = 0; r < rows.size(); ++r) {
      for (int copy = 0; copy < 2; ++copy, ++frame) {
        Image image{.width_px = kWidth, .height_px = kHeight, .bits = 16};
        const double mean = camera.efficiency * rows[r].photons * truth(r);
        for (size_t i = 0; i < gain.size(); ++i) {
          double e = mean * gain[i];
          e += std::sqrt(e) * gauss(random);
          const double s = camera.gain * e / 4095;
          const double dn = camera.gain * e * (1 + camera.k2 * s) + camera.black + offset[i] +
                            camera.gain * camera.dark_electrons * gauss(random);
          image.samples.push_back(static_cast<uint16_t>(std::clamp(std::round(dn), 0.0, 4095.0))
                                  << camera.shift);
        }
        const std::string file = fmt::format("{}.png", frame);
        write_png(path_ / file, image);
        csv << fmt::format("{0},{1},{2},{3},{4},{5},{6}\n", frame, file, 0.1 * frame,
                           rows[r].exposure_s, rows[r].illumination, rows[r].photons,
                           rows[r].level);
      }
    }
    std::ofstream(path_ / "measurement.yaml")
        << "format: seam-measurement/1\nkind: photometry\ncamera: {width_px: 120, height_px: 100"
        << bits << "}\nfiles: {frames: frames.csv}\n";
  }

  PhotometryData read(Facts& facts) const {
    return read_photometry(MeasurementSet::open(path_), facts);
  }
  std::string refusal() const {
    try {
      Facts facts;
      read(facts);
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  }

 private:
  std::filesystem::path path_;
};

// One lamp, growing exposures, darks at each.
std::vector<Row> series(int count = 12, double photons_each = 2400) {
  std::vector<Row> rows;
  for (int k = 1; k <= count; ++k) rows.push_back({0.001 * k, 1, photons_each * k, ""});
  for (int k = 1; k <= count; ++k) rows.push_back({0.001 * k, 0, 0, ""});
  return rows;
}

double figure(const FigureTable& table, const std::string& name, double* sigma = nullptr) {
  for (const Figure& f : table.figures) {
    if (f.name != name) continue;
    if (sigma) *sigma = f.sigma;
    return f.value;
  }
  return std::nan("");
}

TEST(PhotometryStack, EmvaFiguresOfAKnownSensor) {
  Camera camera;
  Folder out("emva");
  out.write(camera, series(), ", bits: 12");
  Facts facts;
  out.read(facts);
  const auto expect = [&](const std::string& name, double truth, double at_most) {
    double sigma = 0;
    const double value = figure(facts.figures, name, &sigma);
    EXPECT_NEAR(value, truth, 4 * sigma + 1e-3 * truth) << name;
    EXPECT_GT(sigma, 0) << name;
    EXPECT_LT(sigma, at_most * truth) << name;
  };
  expect("system gain K", camera.gain, 0.01);
  expect("dark noise sigma_d", camera.dark_electrons, 0.02);
  expect("DSNU1288", camera.dsnu / camera.gain, 0.05);
  expect("PRNU1288", 100 * camera.prnu, 0.05);
  expect("quantum efficiency", 100 * camera.efficiency, 0.01);
  EXPECT_LT(figure(facts.figures, "linearity error LE"), 0.1);
  // The signal over the noise of 2400 k photons at 60 %, 8 electrons of dark noise.
  const FigurePoint& first = facts.figures.curve.front();
  const double e = 0.6 * 2400;
  EXPECT_NEAR(first.snr, e / std::sqrt(e + 64 + 1 / (12 * 0.25 * 0.25)), 5 * first.sigma);
  EXPECT_NEAR(first.expected, first.snr, 5 * first.sigma);
}

// Half of the values of dark frames are cut off: they say nothing of noise, offset or their spread.
TEST(PhotometryStack, DarkFramesThatAreCutOffGiveNoFigures) {
  Camera camera{.black = 0.5};
  Folder out("emva-cut");
  out.write(camera, series(), ", bits: 12");
  Facts facts;
  out.read(facts);
  double sigma = 0;
  const double gain = figure(facts.figures, "system gain K", &sigma);
  EXPECT_NEAR(gain, camera.gain, 4 * sigma);
  EXPECT_LT(sigma, 0.02 * camera.gain);
  EXPECT_LT(figure(facts.figures, "linearity error LE"), 0.1);
  EXPECT_TRUE(std::isnan(figure(facts.figures, "dark noise")));
  EXPECT_TRUE(std::isnan(figure(facts.figures, "DSNU1288")));
  ASSERT_FALSE(facts.notes.empty());
  EXPECT_NE(facts.notes.front().find("are 0, where they are cut off"), std::string::npos)
      << facts.notes.front();
}

// A camera whose gain falls with the light by a third: the standard's figure lies between.
TEST(PhotometryStack, TheGainOfAModelIsThatOfItsFrames) {
  const Camera camera{.k2 = -0.2};
  Folder out("model-gain");
  out.write(camera, series(), ", bits: 12");
  Facts facts;
  const PhotometryData data = out.read(facts);
  // 2400 photons in the first frame are 1440 electrons.
  effects::SensorChain chain{.gain_dn = 1440 * camera.gain, .black_dn = camera.black};
  EXPECT_FALSE(emva_gain(data, chain).has_value());
  chain.electrons_per_dn = 1 / camera.gain;
  ASSERT_TRUE(emva_gain(data, chain).has_value());
  EXPECT_NEAR(*emva_gain(data, chain), camera.gain, 1e-9);
  chain.cubic2 = camera.k2;
  double sigma = 0;
  const double measured = figure(facts.figures, "system gain K", &sigma);
  EXPECT_NEAR(*emva_gain(data, chain), measured, 0.03 * measured);
  EXPECT_LT(measured, 0.85 * camera.gain);
}

TEST(PhotometryStack, EmvaSaturationIsWhereTheNoiseIsLargest) {
  Folder folder("saturation");
  folder.write({}, series(14), ", bits: 12");
  Facts facts;
  folder.read(facts);
  // 4095 - 60 DN are 16,140 electrons; levels are 1,440 apart: the last below is 15,840.
  EXPECT_NEAR(figure(facts.figures, "saturation capacity"), 15840, 200);
  EXPECT_NEAR(figure(facts.figures, "SNR max"), std::sqrt(15840.0), 2);
}

TEST(PhotometryStack, BitsAreThoseOfTheCamera) {
  Folder folder("bits");
  folder.write({}, series(6), ", bits: 12");
  Facts facts;
  const PhotometryData data = folder.read(facts);
  EXPECT_EQ(data.file_bits, 12);
  EXPECT_EQ(data.stored_bits, 16);
  Camera left;
  left.shift = 4;
  folder.write(left, series(6), ", bits: 12");
  const std::string refused = folder.refusal();
  EXPECT_NE(refused.find("frames.csv:2"), std::string::npos) << refused;
  EXPECT_NE(refused.find("0 to 4095"), std::string::npos) << refused;
  folder.write(left, series(6), ", bits: 16");
  Facts hinted;
  folder.read(hinted);
  ASSERT_FALSE(hinted.notes.empty());
  EXPECT_NE(hinted.notes.front().find("multiples of 16"), std::string::npos);
}

TEST(PhotometryStack, LevelsWhoseLightIsWrongAreNamed) {
  Folder folder("wrong");
  Camera bent;
  bent.k2 = -0.05;
  folder.write(bent, series(9), ", bits: 12", [](size_t row) { return row == 4 ? 1.08 : 1.0; });
  Facts facts;
  const PhotometryData data = folder.read(facts);
  std::string notes;
  for (const std::string& note : facts.notes) notes += note;
  EXPECT_NE(notes.find("frames.csv:10:"), std::string::npos) << notes;
  EXPECT_NE(notes.find("more light"), std::string::npos) << notes;
  EXPECT_TRUE(std::isnan(data.levels[4].illumination));
  folder.write(bent, series(9), ", bits: 12");
  Facts none;
  folder.read(none);
  EXPECT_TRUE(none.notes.empty()) << none.notes.front();
}

// Means of levels alone: `light` is what each really had, `response` what the camera makes of it.
PhotometryData levels_of(const std::vector<double>& stated, const std::vector<double>& light,
                         const std::function<double(double)>& response) {
  PhotometryData data{.width_px = 100, .height_px = 100};
  data.levels.push_back({.illumination = 0, .exposure_s = 0.001});
  data.levels.back().whole = {.mean = 20, .temporal_variance = 4};
  for (size_t i = 0; i < stated.size(); ++i) {
    data.levels.push_back(
        {.illumination = 1, .exposure_s = stated[i], .exposure_ratio = 1000 * stated[i]});
    const double dn = response(light[i]);
    data.levels.back().whole = {.mean = 20 + dn, .temporal_variance = 4 + 0.3 * dn};
  }
  return data;
}

std::vector<size_t> named(const PhotometryData& data) {
  std::vector<size_t> levels;
  for (const WrongLight& wrong : wrong_lights(data)) levels.push_back(wrong.level - 1);
  std::sort(levels.begin(), levels.end());
  return levels;
}

TEST(PhotometryStack, SeveralExposuresThatDoNotMatchTheirLevelsAreNamed) {
  std::ranlux48_base random(7);
  std::normal_distribution<double> gauss;
  const auto cubic = [](double x) { return 3000 * x * (1 - 0.06 * x + 0.03 * x * x); };
  for (const size_t count : {9, 12, 30}) {
    std::vector<double> stated, light;
    for (size_t i = 1; i <= count; ++i) {
      stated.push_back(static_cast<double>(i) / static_cast<double>(count));
      light.push_back(stated.back() * (1 + 2e-4 * gauss(random)));
    }
    EXPECT_TRUE(named(levels_of(stated, light, cubic)).empty()) << count;
    auto off = light;
    off[3] *= 1.02, off[6] *= 0.97;
    EXPECT_EQ(named(levels_of(stated, off, cubic)), (std::vector<size_t>{3, 6})) << count;
    auto exchanged = stated;
    std::swap(exchanged[2], exchanged[5]);
    EXPECT_EQ(named(levels_of(exchanged, light, cubic)), (std::vector<size_t>{2, 5})) << count;
    auto milliseconds = stated;
    milliseconds[4] *= 1000;
    const auto wrong = wrong_lights(levels_of(milliseconds, light, cubic));
    ASSERT_EQ(wrong.size(), 1u) << count;
    EXPECT_EQ(wrong[0].level, 5u);
    EXPECT_NEAR(wrong[0].ratio, 0.001, 0.00002);
  }
}

TEST(PhotometryStack, AFrameThatIsNoneOfItsLevelIsNamed) {
  Folder folder("odd");
  const auto off = [](size_t row) { return row == 4 ? 0.6 : 1.0; };
  std::vector<Row> rows = series(6);
  // Two pairs more of the fifth exposure, one of them with the light of the third.
  rows.insert(rows.begin() + 4, {{0.005, 1, 12000, ""}, {0.005, 1, 12000, ""}});
  folder.write({}, rows, ", bits: 12", off);
  Facts facts;
  folder.read(facts);
  std::string notes;
  for (const std::string& note : facts.notes) notes += note + "\n";
  EXPECT_NE(notes.find("frames.csv:10: this frame is 1080 DN above dark"), std::string::npos)
      << notes;
  EXPECT_NE(notes.find("(2 frames are so): exposure_s or illumination is not its own"),
            std::string::npos)
      << notes;
}

// No curve fits these: a lit frame without exposure or light, and exposures of other pictures.
TEST(PhotometryStack, LightWhereNoneIsStatedIsNamed) {
  const auto notes_of = [](std::vector<Row> rows) {
    Folder folder("bright");
    folder.write({}, rows, ", bits: 12");
    Facts facts;
    folder.read(facts);
    std::string notes;
    for (const std::string& note : facts.notes) notes += note + "\n";
    return notes;
  };
  EXPECT_EQ(notes_of(series(6)), "");
  std::vector<Row> rows = series(6);
  rows[2].exposure_s = 0;
  EXPECT_NE(notes_of(rows).find("frames.csv:6: no light by illumination 1 and exposure 0 s, and "),
            std::string::npos)
      << notes_of(rows);
  rows = series(8);
  for (int k = 0; k < 8; ++k) rows[k].exposure_s = 0.001 * (8 - k);
  EXPECT_NE(notes_of(rows).find("DN above dark, where line 16 with less light stated has"),
            std::string::npos)
      << notes_of(rows);
}

TEST(PhotometryStack, FramesUnlikeTheirPairAndLitDarksAreNamed) {
  Folder folder("pair");
  folder.write({}, series(6), ", bits: 12");
  Facts facts;
  PhotometryData data = folder.read(facts);
  EXPECT_TRUE(odd_frames(data).empty());
  EXPECT_TRUE(bright_darks(data).empty());
  data.levels[8].whole.mean += 200;
  const auto bright = bright_darks(data);
  ASSERT_EQ(bright.size(), 1u);
  EXPECT_EQ(bright[0].level, 8u);
  EXPECT_NEAR(bright[0].above_dark, 200, 1);
  for (uint16_t& value : data.images[4]) value = static_cast<uint16_t>(value / 2);
  const auto odd = odd_frames(data);
  ASSERT_EQ(odd.size(), 1u);
  EXPECT_EQ(odd[0].frame, 4u);
  EXPECT_EQ(odd[0].other, 5u);
}

TEST(PhotometryStack, FilesThatAreNoPicturesAreToldWithTheirLine) {
  Folder folder("gone");
  folder.write({}, series(2), ", bits: 12");
  std::filesystem::remove(std::filesystem::path(testing::TempDir()) / "stack-gone" / "2.png");
  EXPECT_NE(folder.refusal().find("frames.csv:4: column file: "), std::string::npos)
      << folder.refusal();
}

TEST(PhotometryStack, ExposuresThatDoNotMatchTheirLevelAreRefused) {
  Folder folder("level");
  folder.write({}, {{0.001, 1, 2400, "a"}, {0.002, 1, 4800, "a"}}, ", bits: 12");
  const std::string refused = folder.refusal();
  EXPECT_NE(refused.find("frames.csv:4"), std::string::npos) << refused;
  EXPECT_NE(refused.find("exposure_s"), std::string::npos) << refused;
}

TEST(PhotometryStack, ThinnedRowsAndColumnsAreThoseOfTheWhole) {
  PhotometryData data{.width_px = 50, .height_px = 40};
  data.levels.push_back({.frames = {0}});
  data.frames.push_back({});
  data.images.emplace_back();
  for (int i = 0; i < 2000; ++i) data.images[0].push_back(static_cast<uint16_t>(i));
  sum_rows(data);
  const PhotometryData part = thinned(data, thinning_of(50, 40, 1, 500));
  EXPECT_NEAR(static_cast<double>(part.samples()), 500, 60);
  for (int v = 0; v < part.height_px; ++v)
    for (int u = 0; u < part.width_px; ++u)
      EXPECT_EQ(part.images[0][static_cast<size_t>(v * part.width_px + u)],
                part.row(v) * 50 + part.column(u));
}

}  // namespace
}  // namespace seam::measurement
