#include "app/exchange/exchange.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <sstream>

#include "sim_core/base/config.h"
#include "sim_core/base/error.h"

namespace seam::app {
namespace {

effects::Model model_of(const std::string& effects) {
  return effects::Model::from_config(ConfigNode::from_text(
      "format: seam-model/1\nname: seen\neffects: {" + effects + "}\n", "seen"));
}

const std::string kPinhole = "pinhole: {fx_px: 161.9, fy_px: 162.5, cx_px: 88.5, cy_px: 71.5}";

const ExchangeFormat& format(const std::string& name) {
  for (const ExchangeFormat& one : exchange_formats()) {
    if (one.name == name) return one;
  }
  throw std::logic_error(name);
}

TEST(Lens, HasTheFormulaOfOpencv) {
  const Lens lens{.family = LensFamily::thin_prism,
                  .fx_px = 161.9,
                  .fy_px = 162.5,
                  .cx_px = 88.5,
                  .cy_px = 71.5,
                  .coefficients = {-0.2, 0.05, 0.01, -0.02, 0.003, 0.1, -0.03, 0.02, 0.004, -0.002,
                                   0.001, 0.003}};
  // The formula of its documentation, term by term: x = 0.24, y = -0.16, r2 = 0.0832.
  const double r2 = 0.0832, x = 0.24, y = -0.16;
  const double radial = (1 - 0.2 * r2 + 0.05 * r2 * r2 + 0.003 * r2 * r2 * r2) /
                        (1 + 0.1 * r2 - 0.03 * r2 * r2 + 0.02 * r2 * r2 * r2);
  const double xd =
      x * radial + 2 * 0.01 * x * y - 0.02 * (r2 + 2 * x * x) + 0.004 * r2 - 0.002 * r2 * r2;
  const double yd =
      y * radial + 0.01 * (r2 + 2 * y * y) - 2 * 0.02 * x * y + 0.001 * r2 + 0.003 * r2 * r2;
  const auto [u, v] = lens.project({0.3, -0.2, 1.25});
  EXPECT_NEAR(u, 161.9 * xd + 88.5, 1e-12);
  EXPECT_NEAR(v, 162.5 * yd + 71.5, 1e-12);
}

TEST(Lens, OfTheSameFormIsExact) {
  const effects::Model model = model_of(kPinhole +
                                        ", radial_polynomial: {k1: -0.2, k2: 0.05, k3: 0.001}, "
                                        "tangential_distortion: {p1: 0.003, p2: -0.002}");
  const LensFit fit = fit_lens(effects::Projection(model, 178, 144), LensFamily::plumb_bob);
  EXPECT_LT(fit.most_px, 1e-6);
  EXPECT_NEAR(fit.lens.fx_px, 161.9, 1e-6);
  EXPECT_NEAR(fit.lens.coefficients[0], -0.2, 1e-6);
  EXPECT_NEAR(fit.lens.coefficients[2], 0.003, 1e-6);
  EXPECT_NEAR(fit.lens.coefficients[3], -0.002, 1e-6);
  EXPECT_FALSE(fit_lens(effects::Projection(model, 178, 144), LensFamily::pinhole).exact());
}

TEST(Export, TellsWhatALensOfAnotherFormMisses) {
  const effects::Model model = model_of(kPinhole + ", radial_distortion: {kappa: -0.1}");
  const Exported exported =
      export_model(model, format("kalibr"), {.width_px = 178, .height_px = 144});
  ASSERT_EQ(exported.notes.size(), 1u);
  EXPECT_THAT(exported.notes[0], testing::HasSubstr("nearest misses by"));
}

TEST(Export, NamesWhatAFormatCannotHold) {
  const effects::Model model =
      model_of(kPinhole + ", rolling_shutter: {line_delay_s: 0.0002}, read_noise: {sigma_dn: 1}");
  const ExportOptions size{.width_px = 178, .height_px = 144};
  try {
    export_model(model, format("opencv"), size);
    FAIL() << "rolling shutter was taken";
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("'rolling_shutter'"));
  }
  ExportOptions dropping = size;
  dropping.drop = {"rolling_shutter"};
  EXPECT_THROW(export_model(model, format("opencv"), dropping), InputError);  // read_noise
  dropping.drop = {"all"};
  const Exported exported = export_model(model, format("opencv"), dropping);
  ASSERT_EQ(exported.notes.size(), 2u);
  // 0.0002 s x 143 rows x 1 rad/s x 161.9 px.
  EXPECT_THAT(exported.notes[0], testing::HasSubstr("up to 4.63 px while"));
  dropping.drop = {"rolling_shuter"};
  EXPECT_THROW(export_model(model, format("opencv"), dropping), InputError);
}

TEST(Export, KalibrHoldsTheTimeOfRows) {
  const effects::Model model = model_of(
      kPinhole + ", rolling_shutter: {line_delay_s: 0.0002}, frame_latency: {latency_s: 0.03}");
  const Exported exported =
      export_model(model, format("kalibr"), {.width_px = 178, .height_px = 144});
  const ConfigNode cam = ConfigNode::from_text(exported.text, "camchain").at("cam0");
  EXPECT_DOUBLE_EQ(cam.at("line_delay").number(), 0.0002);
  EXPECT_DOUBLE_EQ(cam.at("timeshift_cam_imu").number(), 0.03);
}

TEST(Export, AColouredLensIsNoPlainOne) {
  const effects::Model model =
      model_of(kPinhole + ", chromatic_aberration: {red_scale: 0.002, blue_scale: -0.001}");
  EXPECT_THROW(export_model(model, format("ros"), {.width_px = 178, .height_px = 144}), InputError);
}

TEST(Export, TakesTheSizeFromThePrincipalPointAndSaysSo) {
  const Exported exported = export_model(model_of(kPinhole), format("ros"), {});
  ASSERT_EQ(exported.notes.size(), 1u);
  EXPECT_THAT(exported.notes[0], testing::HasSubstr("178 x 144 px"));
}

// 31 degrees to either side, with a radial effect that no format has: a fisheye misses by less, but
// most programs would read its four numbers as k1, k2, p1, p2.
TEST(Export, TakesTheOrdinaryFormOfAnOrdinaryLens) {
  const effects::Model model = model_of(
      "pinhole: {fx_px: 600, fy_px: 601, cx_px: 321, cy_px: 237}, radial_distortion: {kappa: "
      "-0.2}");
  const ExportOptions size{.width_px = 640, .height_px = 480};
  for (const char* name : {"opencv", "ros", "kalibr"}) {
    const Exported exported = export_model(model, format(name), size);
    EXPECT_THAT(exported.form, testing::StartsWith("ordinary (k1, k2, p1, p2")) << name;
    EXPECT_THAT(exported.text, testing::HasSubstr("# Lens: ordinary (k1, k2, p1, p2")) << name;
    ExportOptions chosen = size;
    chosen.form = "fisheye";
    const Exported fisheye = export_model(model, format(name), chosen);
    EXPECT_THAT(fisheye.form, testing::StartsWith("fisheye"));
    EXPECT_THAT(fisheye.text, testing::HasSubstr("equidistant"));
  }
  // Read the usual way it is the model's lens: 0.3 px is far below what another form gives, 46 px.
  const LensFit fit = best_lens(effects::Projection(model, 640, 480),
                                {LensFamily::radtan, LensFamily::equidistant});
  EXPECT_EQ(fit.lens.family, LensFamily::radtan);
  EXPECT_LT(fit.most_px, 0.3);
}

TEST(Export, TakesTheFisheyeOfAFisheye) {
  const effects::Model model =
      model_of(kPinhole + ", fisheye: {k1: 0.02, k2: -0.003, k3: 0.001, k4: 0}");
  const Exported exported =
      export_model(model, format("opencv"), {.width_px = 178, .height_px = 144});
  EXPECT_THAT(exported.form, testing::StartsWith("fisheye"));
}

// B of four control points by the recursion of Cox and de Boor, over knots at whole numbers.
double bump(int i, int degree, double at) {
  if (degree == 0) return i <= at && at < i + 1 ? 1 : 0;
  return ((at - i) * bump(i, degree - 1, at) +
          (i + degree + 1 - at) * bump(i + 1, degree - 1, at)) /
         degree;
}

// What mrcal's documentation says of its splined stereographic lens, from the numbers in the file.
TEST(Export, ALensOfSplinesIsMrcalsOwn) {
  const effects::Model model =
      model_of(kPinhole +
               ", spline_lens: {fov_x_deg: 62, x_0_0: 0.02, y_1_2: -0.03, x_3_3: 0.01, "
               "y_2_3: 0.02, x_5_7: -0.02}");
  const ExportOptions size{.width_px = 178, .height_px = 144};
  const std::string text = export_model(model, format("mrcal"), size).text;
  EXPECT_THAT(
      text, testing::HasSubstr("'LENSMODEL_SPLINED_STEREOGRAPHIC_order=3_Nx=8_Ny=6_fov_x_deg=62'"));
  std::vector<double> k;
  std::stringstream list(text.substr(text.find("'intrinsics': [") + 15));
  for (char comma = ','; comma == ','; list >> comma) list >> k.emplace_back();
  ASSERT_EQ(k.size(), 4u + 2 * 8 * 6);
  const double apart = 4 * std::tan(62 * std::numbers::pi / 180 / 4) / 5;
  const effects::Projection camera(model, 178, 144);
  for (const Vec3& p : {Vec3{0.3, -0.2, 1}, Vec3{-0.45, 0.3, 1}, Vec3{0.01, 0.02, 1}}) {
    const double length = std::sqrt(p.x * p.x + p.y * p.y + p.z * p.z);
    const double u[] = {2 * p.x / (length + p.z), 2 * p.y / (length + p.z)};
    double q[] = {u[0], u[1]};
    for (int i = 0; i < 48; ++i) {
      const double weight =
          bump(i % 8 - 2, 3, u[0] / apart + 3.5) * bump(i / 8 - 2, 3, u[1] / apart + 2.5);
      for (const int part : {0, 1}) q[part] += weight * k[4 + 2 * i + part];
    }
    const effects::ImagePoint seen = camera.project(p);
    EXPECT_NEAR(seen.u, k[0] * q[0] + k[2], 1e-9);
    EXPECT_NEAR(seen.v, k[1] * q[1] + k[3], 1e-9);
  }
  // Others get what comes nearest.
  EXPECT_THAT(export_model(model, format("opencv"), size).notes,
              testing::Contains(testing::HasSubstr("misses by")));
}

TEST(Export, AFormMustBeOneOfTheFormat) {
  const ExportOptions wrong{.width_px = 178, .height_px = 144, .form = "fisheye"};
  EXPECT_THROW(export_model(model_of(kPinhole), format("mrcal"), wrong), UsageError);
  EXPECT_THROW(export_model(model_of(kPinhole), format("json"), wrong), UsageError);
  const ExportOptions rational{.width_px = 178, .height_px = 144, .form = "rational"};
  EXPECT_THAT(export_model(model_of(kPinhole), format("mrcal"), rational).form,
              testing::StartsWith("rational"));
}

TEST(Export, WhatIsNoPropertyOfTheCameraIsNoLoss) {
  const ExportOptions size{.width_px = 178, .height_px = 144};
  const std::string plain = export_model(model_of(kPinhole), format("opencv"), size).text;
  for (const std::string effect :
       {"board_warp: {x_m: 0.0003, y_m: -0.0001}", "target_scatter: {sigma_m: 0.001}",
        "board_scale: {x_scale: 0.001}", "point_scatter: {fraction: 0.03, sigma_px: 1.5}"}) {
    const Exported exported =
        export_model(model_of(kPinhole + ", " + effect), format("opencv"), size);
    EXPECT_EQ(exported.text, plain) << effect;
    ASSERT_EQ(exported.notes.size(), 1u);
    EXPECT_THAT(exported.notes[0], testing::HasSubstr(effect.substr(0, effect.find(':'))));
    EXPECT_THAT(exported.notes[0], testing::HasSubstr("no property of the camera"));
  }
}

TEST(Export, SaysWhatKpIsToBeMultipliedBy) {
  const effects::Model model = model_of(
      "motor_servo: {stall_rad_per_s2: 200, back_emf_per_s: 8, gain: 0.5, damping_s: 0.01, "
      "max_duty: 0.9}");
  const auto exported = [&](const ServoGains& gains) {
    return export_model(model, format("mjcf"), {.gains = gains});
  };
  const auto both = [](const Exported& what, const std::string& words) {
    EXPECT_THAT(what.text, testing::HasSubstr(words));
    EXPECT_THAT(what.notes, testing::Contains(testing::HasSubstr(words)));
  };
  // 200 rad/s^2 x 0.5 for each rad and unit of gain.
  both(exported({}), "multiply kp by the gain");
  EXPECT_THAT(exported({}).text, testing::HasSubstr("kp=\"100\" kv=\"2\""));
  const Exported two = exported({.known = true, .values = {6, 12}});
  both(two, "multiply kp by the gain");
  both(two, "6, 12");
  EXPECT_THAT(two.text, testing::HasSubstr("kp=\"100\""));
  const Exported one = exported({.known = true, .values = {6}});
  both(one, "controller gain of the set, 6");
  EXPECT_THAT(one.text, testing::HasSubstr("kp=\"600\" kv=\"2\""));
  both(exported({.known = true}), "no column kp");
}

}  // namespace
}  // namespace seam::app
