// Each optical effect alone, seen in finished 8-bit frames: what a frame shows is the effect's
// formula
// (../docs/reference/effects.md), written here once more.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>
#include <tuple>

#include "render/renderer.h"
#include "render/test_scenes.h"

namespace seam::render {
namespace {

using namespace testing;

const std::string kPinhole = "  pinhole: {fx_px: 161.9, fy_px: 162.5, cx_px: 88.5, cy_px: 71.5}\n";
enum Channel { red, green, blue };

Frame frame_of(const std::string& effects, const MovingScene& scene, double stamp_s = 0) {
  const effects::Model model = model_of(effects);
  return Renderer(model, kWidth, kHeight).render(job_of(scene, model, kHeight, stamp_s));
}

double dn(const Frame& frame, int u, int v, int channel = green) {
  return frame.rgb[3 * (v * kWidth + u) + channel];
}

struct Image2 {
  double u = 0, v = 0;
};

// ---- Geometry: where small bright balls are seen.

constexpr double kDepth_m = 2, kBall_m = 0.02;  // 1.6 px.

Image2 ideal(double x, double y) {
  return {kCx + kFx * x, kCy + kFy * y};
}

// A ball in the direction (x, y, 1) of a camera that looks along the world's x axis.
MovingScene ball_at(double x, double y, std::function<Pose(double)> camera = nullptr) {
  MovingScene scene;
  scene.background = {0, 0, 0};
  scene.camera = camera ? std::move(camera) : [](double) { return head_camera(0, 0, 0, 0); };
  scene.primitives = [=](double) {
    return std::vector<Primitive>{
        sphere({kDepth_m, -kDepth_m * x, -kDepth_m * y}, kBall_m, {0.9, 0.9, 0.9})};
  };
  return scene;
}

Image2 centroid(const Frame& frame, int channel = green) {
  double sum = 0, u_sum = 0, v_sum = 0;
  for (int v = 0; v < kHeight; ++v)
    for (int u = 0; u < kWidth; ++u) {
      const double light = dn(frame, u, v, channel);
      sum += light, u_sum += light * u, v_sum += light * v;
    }
  return {u_sum / sum, v_sum / sum};
}

// The ball is seen where `formula` says, within what 8 bits and 64 rays a pixel allow, at places
// all over the image.
void expect_places(const std::string& effects,
                   const std::function<Image2(double x, double y)>& formula, int channel = green) {
  double moved = 0;
  for (const double x : {-0.4, -0.15, 0.3})
    for (const double y : {-0.3, 0.05, 0.25}) {
      const Image2 seen = centroid(frame_of(effects, ball_at(x, y)), channel),
                   expected = formula(x, y);
      EXPECT_NEAR(seen.u, expected.u, 0.08) << effects << x << ", " << y;
      EXPECT_NEAR(seen.v, expected.v, 0.08) << effects << x << ", " << y;
      moved = std::max(moved, std::hypot(expected.u - ideal(x, y).u, expected.v - ideal(x, y).v));
    }
  EXPECT_GT(moved, 0.6) << effects << ": the test would not see that the effect is missing";
}

TEST(EffectImages, RadialDistortion) {
  expect_places(kPinhole + "  radial_distortion: {kappa: -0.3}\n", [](double x, double y) {
    const double scale = 2 / (1 + std::sqrt(1 + 1.2 * (x * x + y * y)));
    return ideal(scale * x, scale * y);
  });
}

TEST(EffectImages, RadialPolynomial) {
  expect_places(
      kPinhole + "  radial_polynomial: {k1: 0.2, k2: -0.1, k3: 0.05}\n", [](double x, double y) {
        const double r2 = x * x + y * y, scale = 1 + 0.2 * r2 - 0.1 * r2 * r2 + 0.05 * r2 * r2 * r2;
        return ideal(scale * x, scale * y);
      });
}

TEST(EffectImages, TangentialDistortion) {
  expect_places(kPinhole + "  tangential_distortion: {p1: 0.03, p2: -0.02}\n",
                [](double x, double y) {
                  const double r2 = x * x + y * y;
                  return ideal(x + 2 * 0.03 * x * y - 0.02 * (r2 + 2 * x * x),
                               y + 0.03 * (r2 + 2 * y * y) - 2 * 0.02 * x * y);
                });
}

TEST(EffectImages, Fisheye) {
  expect_places(kPinhole + "  fisheye: {k1: 0.1, k2: -0.05, k3: 0.02, k4: 0.01}\n",
                [](double x, double y) {
                  const double r = std::hypot(x, y), a = std::atan(r);
                  const double lies = a * (1 + 0.1 * std::pow(a, 2) - 0.05 * std::pow(a, 4) +
                                           0.02 * std::pow(a, 6) + 0.01 * std::pow(a, 8));
                  return ideal(x * lies / r, y * lies / r);
                });
}

// A cubic B-spline by the recursion of Cox and de Boor, over knots at whole numbers.
double bump(int i, int degree, double at) {
  if (degree == 0) return i <= at && at < i + 1 ? 1 : 0;
  return ((at - i) * bump(i, degree - 1, at) +
          (i + degree + 1 - at) * bump(i + 1, degree - 1, at)) /
         degree;
}

TEST(EffectImages, LensOfSplines) {
  expect_places(
      kPinhole +
          "  spline_lens: {fov_x_deg: 70, x_2_3: 0.05, y_3_4: -0.04, x_1_1: 0.03, y_4_6: 0.05}\n",
      [](double x, double y) {
        const double to_plane = 2 / (1 + std::sqrt(1 + x * x + y * y));
        const double apart = 4 * std::tan(70 * std::numbers::pi / 180 / 4) / 5;
        double place[] = {to_plane * x, to_plane * y};
        const double column = place[0] / apart + 3.5, row = place[1] / apart + 2.5;
        for (const auto& [r, c, part, value] :
             {std::tuple{2, 3, 0, 0.05}, {3, 4, 1, -0.04}, {1, 1, 0, 0.03}, {4, 6, 1, 0.05}})
          place[part] += value * bump(c - 2, 3, column) * bump(r - 2, 3, row);
        return ideal(place[0], place[1]);
      });
}

TEST(EffectImages, FocalLengthAndPrincipalPoint) {
  expect_places(kPinhole + "  focal_length_error: {fx_scale: 0.05, fy_scale: -0.04}\n",
                [](double x, double y) {
                  return Image2{kCx + 1.05 * kFx * x, kCy + 0.96 * kFy * y};
                });
  expect_places(kPinhole + "  principal_point_offset: {du_px: 2.5, dv_px: -1.25}\n",
                [](double x, double y) {
                  return Image2{ideal(x, y).u + 2.5, ideal(x, y).v - 1.25};
                });
}

TEST(EffectImages, ChromaticAberration) {
  const std::string model =
      kPinhole + "  chromatic_aberration: {red_scale: 0.02, blue_scale: -0.03}\n";
  expect_places(
      model, [](double x, double y) { return ideal(1.02 * x, 1.02 * y); }, red);
  expect_places(
      model, [](double x, double y) { return ideal(0.97 * x, 0.97 * y); }, blue);
  const Image2 seen = centroid(frame_of(model, ball_at(0.3, 0.2)), green);
  EXPECT_NEAR(seen.u, ideal(0.3, 0.2).u, 0.06);
}

// ---- Timing: where a turning head sees the ball.

TEST(EffectImages, LatencyAndDrift) {
  constexpr double kRate = 2;  // rad/s to the left.
  const auto camera = [](double t_s) { return head_camera(0, kRate * (t_s - 100), 0, 0); };
  const auto column = [](double t_s) {
    return kCx + kFx * std::tan(std::atan(0.1) + kRate * (t_s - 100));
  };
  const MovingScene scene = ball_at(0.1, 0, camera);
  EXPECT_NEAR(centroid(frame_of(kPinhole, scene, 100)).u, column(100), 0.06);
  EXPECT_NEAR(centroid(frame_of(kPinhole + "  frame_latency: {latency_s: 0.031}\n", scene, 100)).u,
              column(100.031), 0.06);
  EXPECT_NEAR(centroid(frame_of(kPinhole + "  clock_drift: {drift_ppm: 400}\n", scene, 100)).u,
              column(100.04), 0.06);
}

// A vertical edge, from the wall's light on the left to the dark on the right, at `column` of a
// camera that looks straight ahead.
MovingScene edge_at(double column) {
  MovingScene scene;
  scene.background = {0, 0, 0};
  scene.camera = [](double) { return head_camera(0.2, 0, 0, 0); };
  scene.primitives = [=](double) {
    const Mat3 facing(Vec3(0, 1, 0), Vec3(0, 0, 1), Vec3(1, 0, 0));
    const double y_m = 1.5 * (kCx - column) / kFx;
    return std::vector<Primitive>{{.shape = Shape::rectangle,
                                   .X_WO = {facing, {1.5, y_m + 2.5, 0.2}},
                                   .size = {5, 6, 0},
                                   .rgb = {0.8, 0.8, 0.8}}};
  };
  return scene;
}

TEST(EffectImages, ExposureBlursAlongTheMotion) {
  // The light of an edge that moves by L pixels in the window is spread evenly over them.
  constexpr double kRate = 3, kExposure_s = 0.012;
  MovingScene scene = edge_at(kCx);
  scene.camera = [](double t_s) { return head_camera(0.2, kRate * t_s, 0, 0); };
  const Frame frame = frame_of(kPinhole + "  exposure: {exposure_s: 0.012}\n", scene);
  const double from = kCx, to = kCx + kFx * std::tan(kRate * kExposure_s);
  ASSERT_GT(to - from, 5);
  // Mean over the columns' width of a ramp, row by row the same.
  for (int u = 80; u < 104; ++u) {
    double mean = 0;
    for (int v = 30; v < 114; ++v) mean += dn(frame, u, v) / 84;
    double expected = 0;
    for (int i = 0; i < 1000; ++i) {
      const double place = u - 0.5 + (i + 0.5) / 1000;
      expected += 204 * std::clamp((to - place) / (to - from), 0.0, 1.0) / 1000;
    }
    EXPECT_NEAR(mean, expected, 4) << u;  // Of 204; an instant of eight is 25.
  }
}

// ---- Light: edges and even fields.

// The steps from pixel to pixel, as a distribution: their mean is the edge, their variance the
// Gaussian's.
TEST(EffectImages, BlurSpreadsAnEdge) {
  for (const double sigma : {0.7, 1.0, 1.8}) {
    const std::string model = kPinhole + "  lens_blur: {sigma_px: " + std::to_string(sigma) + "}\n";
    constexpr int kPlaces = 16;
    for (int place = 0; place < kPlaces; ++place) {
      const double column = 88 + (place + 0.5) / kPlaces;
      const Frame frame = frame_of(model, edge_at(column));
      double mean = 0, square = 0;
      for (int u = 70; u < 106; ++u) {
        double step = 0;  // Rows are sampled at places of their own.
        for (int v = 10; v < 134; ++v)
          step += (dn(frame, u, v) - dn(frame, u + 1, v)) / (204 * 124);
        const double from_edge = u + 0.5 - column;
        mean += step * from_edge, square += step * from_edge * from_edge;
        // The shape is the Gaussian's to 4.5 % of the step's height: the blur acts on whole pixels.
        double lit = 0;
        for (int v = 10; v < 134; ++v) lit += dn(frame, u, v) / (204 * 124);
        EXPECT_NEAR(lit, 0.5 * std::erfc((u - column) / std::sqrt(2 * (sigma * sigma + 1.0 / 12))),
                    0.045)
            << sigma << ", " << u;
      }
      EXPECT_NEAR(mean, 0, 0.02) << sigma << " at " << column;
      // An edge that cuts a pixel is spread over two steps: 1/6 in the mean over places, none at a
      // pixel's border.
      const double inside = column + 0.5 - std::floor(column + 0.5);
      EXPECT_NEAR(square, sigma * sigma + inside * (1 - inside), 0.02 * sigma * sigma + 0.02)
          << sigma << " at " << column;
    }
  }
}

MovingScene even(double light) {
  MovingScene scene;
  scene.background = {light, light, light};
  scene.camera = [](double) { return head_camera(0, 0, 0, 0); };
  scene.primitives = [](double) { return std::vector<Primitive>(); };
  return scene;
}

// Every pixel of an even field has the light of `formula`, but for the rounding to 8 bits.
void expect_field(const Frame& frame, double light,
                  const std::function<double(int u, int v)>& formula) {
  double least = 1e9, most = 0;
  for (int v = 0; v < kHeight; ++v)
    for (int u = 0; u < kWidth; ++u) {
      const double expected = 255 * light * formula(u, v);
      ASSERT_NEAR(dn(frame, u, v), expected, 0.51) << u << ", " << v;
      least = std::min(least, expected), most = std::max(most, expected);
    }
  EXPECT_GT(most - least, 10) << "the test would not see that the effect is missing";
}

TEST(EffectImages, VignettingIsAGainOfTheRadius) {
  expect_field(frame_of(kPinhole + "  vignetting: {a2: 0.3, a4: 0.1}\n", even(0.8)), 0.8,
               [](int u, int v) {
                 const double rho2 =
                     (std::pow(u - 88.5, 2) + std::pow(v - 71.5, 2)) / (89.0 * 89.0 + 72.0 * 72.0);
                 return 1 - 0.3 * rho2 - 0.1 * rho2 * rho2;
               });
}

TEST(EffectImages, FlickerMakesBands) {
  constexpr double kDelay_s = 2e-4, kExposure_s = 0.004, kStamp_s = 3.217, kOmega = 2 * M_PI * 100;
  const Frame frame =
      frame_of(kPinhole +
                   "  rolling_shutter: {line_delay_s: 2.0e-4}\n  exposure: {exposure_s: 0.004}\n"
                   "  lamp_flicker: {frequency_hz: 100, depth: 0.3, phase_rad: 0.4}\n",
               even(0.7), kStamp_s);
  expect_field(frame, 0.7, [](int, int v) {
    const double from = kOmega * (kStamp_s + kDelay_s * v) + 0.4, to = from + kOmega * kExposure_s;
    return 1 + 0.3 * (std::cos(from) - std::cos(to)) / (kOmega * kExposure_s);
  });
}

TEST(EffectImages, GlareLiftsTheDarkByTheMean) {
  MovingScene scene = ball_at(0, 0);
  scene.background = {0.1, 0.1, 0.1};
  scene.primitives = [](double) {
    return std::vector<Primitive>{sphere({1, 0, 0}, 0.3, {1, 1, 1})};
  };
  const Frame clear = frame_of(kPinhole, scene),
              veiled = frame_of(kPinhole + "  veiling_glare: {fraction: 0.2}\n", scene);
  double mean = 0;
  for (int v = 0; v < kHeight; ++v)
    for (int u = 0; u < kWidth; ++u) mean += dn(clear, u, v) / (kWidth * kHeight);
  ASSERT_GT(mean, 60);
  for (const auto& [u, v] : {std::pair{5, 5}, {88, 71}, {170, 140}})
    EXPECT_NEAR(dn(veiled, u, v), 0.8 * dn(clear, u, v) + 0.2 * mean, 1.5) << u << ", " << v;
}

}  // namespace
}  // namespace seam::render
