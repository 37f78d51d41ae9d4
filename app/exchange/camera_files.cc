#include "app/exchange/camera_files.h"

#include <fmt/ranges.h>

#include <array>
#include <vector>

#include "effects/stages/spline_grid.h"

namespace seam::app {
namespace {

std::string list_of(const std::vector<double>& numbers) {
  return fmt::format("[{}]", fmt::join(numbers, ", "));
}

std::vector<double> matrix_of(const Lens& lens) {
  return {lens.fx_px, 0, lens.cx_px, 0, lens.fy_px, lens.cy_px, 0, 0, 1};
}

// A text in quotes of YAML 1.0 and 1.2.
std::string quoted(const std::string& text) {
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') out += '\\';
    out += static_cast<unsigned char>(c) < 0x20 ? ' ' : c;
  }
  return out + '"';
}

// OpenCV and ROS know no lens without coefficients; all of them zero is the same.
std::vector<double> at_least(std::vector<double> coefficients, size_t count) {
  if (coefficients.size() < count) coefficients.resize(count, 0);
  return coefficients;
}

// The same numbers are another lens in another form: each file says which form it holds.
std::string form_comment(const Lens& lens) {
  return fmt::format("# Lens: {}\n", words_of(lens.family));
}

// By the names of ROS, which readers of OpenCV's files know, too.
const char* distortion_model(const Lens& lens) {
  if (lens.family == LensFamily::equidistant) return "equidistant";
  return form_of(lens.family) == LensForm::rational ? "rational_polynomial" : "plumb_bob";
}

}  // namespace

std::string opencv_text(const PlainCamera& camera) {
  const bool fisheye = camera.lens.family == LensFamily::equidistant;
  const std::vector<double> k = at_least(camera.lens.coefficients, fisheye ? 4 : 5);
  const auto matrix = [](const char* name, int rows, size_t columns, const auto& numbers) {
    return fmt::format("{}: !!opencv-matrix\n   rows: {}\n   cols: {}\n   dt: d\n   data: {}\n",
                       name, rows, columns, list_of(numbers));
  };
  return fmt::format("%YAML:1.0\n---\n{}camera_name: {}\nimage_width: {}\nimage_height: {}\n",
                     form_comment(camera.lens), quoted(camera.name), camera.width_px,
                     camera.height_px) +
         fmt::format("fisheye_model: {}\ndistortion_model: {}\n", fisheye ? 1 : 0,
                     distortion_model(camera.lens)) +
         matrix("camera_matrix", 3, 3, matrix_of(camera.lens)) +
         matrix("distortion_coefficients", static_cast<int>(fisheye ? k.size() : 1),
                fisheye ? 1 : k.size(), k);
}

std::string ros_text(const PlainCamera& camera) {
  const bool fisheye = camera.lens.family == LensFamily::equidistant;
  const std::vector<double> k = at_least(camera.lens.coefficients, fisheye ? 4 : 5);
  const auto matrix = [](const char* name, int rows, size_t columns, const auto& numbers) {
    return fmt::format("{}:\n  rows: {}\n  cols: {}\n  data: {}\n", name, rows, columns,
                       list_of(numbers));
  };
  const Lens& l = camera.lens;
  return form_comment(l) +
         fmt::format("image_width: {}\nimage_height: {}\ncamera_name: {}\n", camera.width_px,
                     camera.height_px, quoted(camera.name)) +
         matrix("camera_matrix", 3, 3, matrix_of(l)) +
         fmt::format("distortion_model: {}\n", distortion_model(l)) +
         matrix("distortion_coefficients", 1, k.size(), k) +
         matrix("rectification_matrix", 3, 3, std::vector<double>{1, 0, 0, 0, 1, 0, 0, 0, 1}) +
         matrix("projection_matrix", 3, 4,
                std::vector<double>{l.fx_px, 0, l.cx_px, 0, 0, l.fy_px, l.cy_px, 0, 0, 0, 1, 0});
}

std::string mrcal_text(const PlainCamera& camera) {
  const Lens& lens = camera.lens;
  const size_t count = lens.coefficients.size();
  std::vector<double> numbers = {lens.fx_px, lens.fy_px, lens.cx_px, lens.cy_px};
  numbers.insert(numbers.end(), lens.coefficients.begin(), lens.coefficients.end());
  const std::string model =
      count == 0 ? "LENSMODEL_PINHOLE" : fmt::format("LENSMODEL_OPENCV{}", count);
  return form_comment(lens) +
         fmt::format(
             "{{\n    'lensmodel':  '{}',\n\n    # fx, fy, cx, cy, then OpenCV's coefficients\n"
             "    'intrinsics': {},\n\n    # the camera's own frame is the reference\n"
             "    'extrinsics': [0, 0, 0, 0, 0, 0],\n\n    'imagersize': [{}, {}]\n}}\n",
             model, list_of(numbers), camera.width_px, camera.height_px);
}

std::string mrcal_text_of_splines(const PlainCamera& camera, const effects::ModelEffect& splines) {
  using namespace effects;
  const Lens& lens = camera.lens;
  std::vector<double> numbers = {lens.fx_px, lens.fy_px, lens.cx_px, lens.cy_px};
  const Values values = splines.values();
  numbers.insert(numbers.end(), values.begin() + kSplineFov + 1, values.end());
  return fmt::format(
      "{{\n    'lensmodel':  "
      "'LENSMODEL_SPLINED_STEREOGRAPHIC_order=3_Nx={}_Ny={}_fov_x_deg={:.0f}',"
      "\n\n    # fx, fy, cx, cy, then x and y of each control point, row by row\n"
      "    'intrinsics': {},\n\n    # the camera's own frame is the reference\n"
      "    'extrinsics': [0, 0, 0, 0, 0, 0],\n\n    'imagersize': [{}, {}]\n}}\n",
      kSplineColumns, kSplineRows, values[kSplineFov], list_of(numbers), camera.width_px,
      camera.height_px);
}

std::string kalibr_text(const PlainCamera& camera) {
  const Lens& lens = camera.lens;
  const bool fisheye = lens.family == LensFamily::equidistant;
  return form_comment(lens) +
         fmt::format(
             "cam0:\n  camera_model: pinhole\n  intrinsics: {}\n  distortion_model: {}\n"
             "  distortion_coeffs: {}\n  resolution: [{}, {}]\n  line_delay: {}\n"
             "  timeshift_cam_imu: {}\n  rostopic: {}\n",
             list_of({lens.fx_px, lens.fy_px, lens.cx_px, lens.cy_px}),
             fisheye ? "equidistant" : "radtan", list_of(at_least(lens.coefficients, 4)),
             camera.width_px, camera.height_px, camera.line_delay_s, camera.time_shift_s,
             quoted("/" + camera.name));
}

}  // namespace seam::app
