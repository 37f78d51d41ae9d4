// Calibrations of camodocal (VINS-Fusion), ORB-SLAM and basalt, by the formulas that these projects
// publish. Lenses that no effect has are taken as the nearest one.
#include <algorithm>
#include <cmath>

#include "app/import/cameras/camera_file.h"
#include "app/import/files/storage.h"
#include "sim_core/base/error.h"

namespace seam::app {
namespace {

using Pixel = std::optional<std::array<double, 2>>;

double number_in(const ConfigNode& node, const char* key) {
  return node.at(key).number({-1e9, 1e9});
}

double number_or_0(const ConfigNode& node, const std::string& key) {
  return node.number_or(key, 0, {-1e9, 1e9});
}

void take_linear(const ConfigNode& node, std::array<const char*, 4> keys, Lens& lens) {
  lens.fx_px = number_in(node, keys[0]), lens.fy_px = number_in(node, keys[1]);
  lens.cx_px = number_in(node, keys[2]), lens.cy_px = number_in(node, keys[3]);
  check_calibrated({lens.fx_px, lens.fy_px, lens.cx_px, lens.cy_px}, node.where());
}

// Where a lens takes normalised coordinates that no ray of a perspective camera has.
Pixel bent(const Lens& lens, double x, double y) {
  return lens.project({x, y, 1});
}

// Mei's: onto a sphere, then from a point behind its centre, then a perspective lens.
Pixel mei(const Lens& lens, double xi, const Vec3& p) {
  const double z = p.z + xi * glm::length(p);
  if (!(z > 1e-3)) return std::nullopt;
  return bent(lens, p.x / z, p.y / z);
}

// Usenko's double sphere; with xi = 0 the unified model.
Pixel double_sphere(const Lens& lens, double xi, double alpha, const Vec3& p) {
  const double z = p.z + xi * glm::length(p), across2 = p.x * p.x + p.y * p.y;
  const double below = alpha * std::sqrt(across2 + z * z) + (1 - alpha) * z;
  if (!(below > 1e-3)) return std::nullopt;
  return bent(lens, p.x / below, p.y / below);
}

// Khomutenko's extended unified model.
Pixel extended(const Lens& lens, double alpha, double beta, const Vec3& p) {
  const double d = std::sqrt(beta * (p.x * p.x + p.y * p.y) + p.z * p.z);
  const double below = alpha * d + (1 - alpha) * p.z;
  if (!(below > 1e-3)) return std::nullopt;
  return bent(lens, p.x / below, p.y / below);
}

PlainCamera of_camodocal(const ConfigNode& root, SetDraft& draft) {
  PlainCamera camera{.width_px = static_cast<int>(root.at("image_width").integer(2, 100'000)),
                     .height_px = static_cast<int>(root.at("image_height").integer(2, 100'000))};
  const ConfigNode type = root.at("model_type"), projection = root.at("projection_parameters");
  const auto bends = [&] {
    const ConfigNode node = root.at("distortion_parameters");
    take_coefficients({number_or_0(node, "k1"), number_or_0(node, "k2"), number_or_0(node, "p1"),
                       number_or_0(node, "p2")},
                      false, node.where(), camera.lens, draft);
  };
  switch (type.choice({"PINHOLE", "KANNALA_BRANDT", "MEI"})) {
    case 0:
      take_linear(projection, {"fx", "fy", "cx", "cy"}, camera.lens);
      bends();
      break;
    case 1:
      // theta + k2 theta^3 + k3 theta^5 + ...: its k2 is OpenCV's k1.
      take_linear(projection, {"mu", "mv", "u0", "v0"}, camera.lens);
      take_coefficients({number_or_0(projection, "k2"), number_or_0(projection, "k3"),
                         number_or_0(projection, "k4"), number_or_0(projection, "k5")},
                        true, projection.where(), camera.lens, draft);
      break;
    default: {
      take_linear(projection, {"gamma1", "gamma2", "u0", "v0"}, camera.lens);
      bends();
      const double xi = number_in(root.at("mirror_parameters"), "xi");
      if (xi == 0) break;
      const Lens lens = camera.lens;
      camera.lens = nearest_lens([=](const Vec3& p) { return mei(lens, xi, p); }, "MEI",
                                 camera.width_px, camera.height_px, type, draft);
    }
  }
  check_camera(camera, projection.where());
  return camera;
}

PlainCamera of_orb(const ConfigNode& root, const std::string& name, const ImportRequest& request,
                   SetDraft& draft) {
  PlainCamera camera{.width_px = request.width_px, .height_px = request.height_px};
  if (camera.width_px == 0) {
    if (!root.has("Camera.width"))
      throw InputError(
          fmt::format("{}: says no size of the images, expected Camera.width and "
                      "Camera.height, or --size WIDTHxHEIGHT",
                      root.file()));
    camera.width_px = static_cast<int>(root.at("Camera.width").integer(2, 100'000));
    camera.height_px = static_cast<int>(root.at("Camera.height").integer(2, 100'000));
  }
  const auto key = [&](const char* what) { return name + "." + what; };
  const std::array<std::string, 4> linear = {key("fx"), key("fy"), key("cx"), key("cy")};
  take_linear(root, {linear[0].c_str(), linear[1].c_str(), linear[2].c_str(), linear[3].c_str()},
              camera.lens);
  const size_t type =
      root.has("Camera.type")
          ? root.at("Camera.type").choice({"PinHole", "KannalaBrandt8", "Rectified"})
          : 0;
  std::vector<double> k;
  const auto take = [&](std::initializer_list<const char*> names) {
    for (const char* one : names) k.push_back(number_or_0(root, key(one)));
  };
  if (type == 0) take({"k1", "k2", "p1", "p2", "k3"});
  if (type == 1) take({"k1", "k2", "k3", "k4"});
  take_coefficients(k, type == 1, root.at(key("fx")).where(), camera.lens, draft);
  check_camera(camera, root.at(key("fx")).where());
  return camera;
}

Pose pose_of_basalt(const ConfigNode& node) {
  const double x = number_in(node, "qx"), y = number_in(node, "qy"), z = number_in(node, "qz"),
               w = number_in(node, "qw");
  const double size = std::sqrt(x * x + y * y + z * z + w * w);
  if (!(std::abs(size - 1) < 0.01)) node.fail("expected a quaternion of length 1");
  return {rotation_from_quaternion(w, x, y, z),
          Vec3(number_in(node, "px"), number_in(node, "py"), number_in(node, "pz"))};
}

PlainCamera of_basalt(const ConfigNode& value, size_t which, SetDraft& draft) {
  const ConfigNode entry = value.at("intrinsics").items()[which], of = entry.at("intrinsics");
  const auto sizes = value.at("resolution").items();
  if (which >= sizes.size()) value.at("resolution").fail("expected a size for each camera");
  const auto size = numbers_in(sizes[which]);
  if (size.size() != 2) sizes[which].fail("expected width and height");
  PlainCamera camera{.width_px = static_cast<int>(std::clamp(size[0], 0.0, 1e6)),
                     .height_px = static_cast<int>(std::clamp(size[1], 0.0, 1e6))};
  take_linear(of, {"fx", "fy", "cx", "cy"}, camera.lens);
  const ConfigNode type = entry.at("camera_type");
  const auto list = [&](std::initializer_list<const char*> names) {
    std::vector<double> k;
    for (const char* name : names) k.push_back(number_in(of, name));
    return k;
  };
  const Lens linear = camera.lens;
  const auto nearest = [&](const ForeignProjection& project) {
    camera.lens =
        nearest_lens(project, type.text(), camera.width_px, camera.height_px, type, draft);
  };
  switch (type.choice({"pinhole", "pinhole-radtan8", "kb4", "ds", "eucm", "ucm"})) {
    case 1:
      take_coefficients(list({"k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6"}), false, of.where(),
                        camera.lens, draft);
      break;
    case 2:
      take_coefficients(list({"k1", "k2", "k3", "k4"}), true, of.where(), camera.lens, draft);
      break;
    case 3:
      nearest([linear, xi = number_in(of, "xi"), alpha = number_in(of, "alpha")](const Vec3& p) {
        return double_sphere(linear, xi, alpha, p);
      });
      break;
    case 4:
      nearest([linear, alpha = number_in(of, "alpha"), beta = number_in(of, "beta")](
                  const Vec3& p) { return extended(linear, alpha, beta, p); });
      break;
    case 5:
      nearest([linear, alpha = number_in(of, "alpha")](const Vec3& p) {
        return double_sphere(linear, 0, alpha, p);
      });
      break;
    default:
      break;
  }
  check_camera(camera, of.where());
  return camera;
}

CameraFile basalt_file(const ConfigNode& value, SetDraft& draft) {
  CameraFile file;
  const size_t count = value.at("intrinsics").items().size();
  if (count == 0) value.at("intrinsics").fail("expected a camera or more");
  for (size_t k = 0; k < count; ++k) file.names.push_back(fmt::format("cam{}", k));
  file.read = [value, names = file.names, &draft](const std::string& name) {
    const auto at = std::find(names.begin(), names.end(), name) - names.begin();
    return of_basalt(value, static_cast<size_t>(at), draft);
  };
  if (!value.has("T_imu_cam")) return file;
  const auto places = value.at("T_imu_cam").items();
  for (size_t k = 0; k < std::min(count, places.size()); ++k)
    file.X_RC[file.names[k]] = pose_of_basalt(places[k]);
  return file;
}

CameraFile orb_file(const ConfigNode& root, const ImportRequest& request, SetDraft& draft) {
  CameraFile file;
  for (const char* name : {"Camera", "Camera1", "Camera2"}) {
    if (root.has(fmt::format("{}.fx", name))) file.names.emplace_back(name);
  }
  file.read = [root, &request, &draft](const std::string& name) {
    return of_orb(root, name, request, draft);
  };
  for (const char* key : {"Stereo.T_c1_c2", "Tlr"}) {
    if (!root.has(key) || file.names.size() != 2) continue;
    file.X_RC[file.names[0]] = Pose{};
    file.X_RC[file.names[1]] = pose_in(root.at(key));
  }
  return file;
}

}  // namespace

std::optional<CameraFile> foreign_cameras(const ConfigNode& root, const ImportRequest& request,
                                          SetDraft& draft) {
  if (!root.is_map()) return std::nullopt;
  if (root.has("model_type") && root.has("projection_parameters")) {
    const std::string name = root.has("camera_name") ? root.at("camera_name").text() : "camera";
    return CameraFile{.names = {name}, .read = [root, &draft](const std::string&) {
                        return of_camodocal(root, draft);
                      }};
  }
  if (root.has("Camera.fx") || root.has("Camera1.fx")) return orb_file(root, request, draft);
  if (root.has("value0") && root.at("value0").is_map() && root.at("value0").has("intrinsics"))
    return basalt_file(root.at("value0"), draft);
  return std::nullopt;
}

}  // namespace seam::app
