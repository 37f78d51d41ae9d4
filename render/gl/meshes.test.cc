// Meshes and textures by OpenGL against every ray meeting every triangle.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <stdlib.h>

#include <filesystem>

#include "render/assets/closed_mesh.h"
#include "render/gl/device.h"
#include "render/golden/brute_triangles.h"
#include "render/renderer.h"
#include "sim_core/base/error.h"
#include "sim_core/base/image.h"
#include "sim_core/base/output.h"

namespace seam::render {
namespace {

using namespace testing;
namespace fs = std::filesystem;

class Files : public ::testing::Test {
 protected:
  Files() {
    std::string pattern = ::testing::TempDir() + "/seam-mesh-XXXXXX";
    folder_ = mkdtemp(pattern.data());
  }
  ~Files() override { fs::remove_all(folder_); }
  FileName put(const std::string& name, const std::string& bytes) const {
    write_file_atomically(folder_ / name, bytes);
    return {name, folder_.string(), ""};
  }
  std::string why_not(const FileName& file) const {
    try {
      read_mesh(file, 1);
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  }
  fs::path folder_;
};

// Waves of colour, so that where a texture stands is seen everywhere.
Image waves(int size) {
  Image image{.width_px = size, .height_px = size, .channels = 3, .samples = {}};
  for (int v = 0; v < size; ++v) {
    for (int u = 0; u < size; ++u) {
      image.samples.push_back(static_cast<uint16_t>(120 + 100 * std::sin(6.0 * u / size)));
      image.samples.push_back(static_cast<uint16_t>(130 + 90 * std::cos(9.0 * v / size)));
      image.samples.push_back(static_cast<uint16_t>(40 + 180 * u / size));
    }
  }
  return image;
}

// A ring of quads with a texture around it. Where it is closed, its last corners are its first;
// else they are apart by rounding, and its far sides are drawn too.
std::string ring_obj(int around, int tube, bool closed) {
  std::string text = "mtllib ring.mtl\nusemtl look\n";
  std::string faces;
  for (int a = 0; a <= around; ++a) {
    for (int b = 0; b <= tube; ++b) {
      const double s = 6.283185307179586 * (closed ? a % around : a) / around;
      const double t = 6.283185307179586 * (closed ? b % tube : b) / tube;
      text += fmt::format("v {} {} {}\n", (0.2 + 0.08 * std::cos(t)) * std::cos(s),
                          (0.2 + 0.08 * std::cos(t)) * std::sin(s), 0.08 * std::sin(t));
      text += fmt::format("vt {} {}\n", 2.0 * a / around, 1.0 * b / tube);
      if (a == around || b == tube) continue;
      const int i = a * (tube + 1) + b + 1, j = i + tube + 1;
      faces += fmt::format("f {0}/{0} {1}/{1} {2}/{2} {3}/{3}\n", i, j, j + 1, i + 1);
    }
  }
  return text + faces;
}

struct Apart {
  double mean = 0, within_6 = 0;
};

// Every 24th row, 256 instants.
Apart against_brute_force(const MovingScene& scene, const Assets& assets, double kappa,
                          RendererOptions options) {
  const GlDevice device(assets, gl_source());
  options.opengl = &device;
  const std::string lens =
      kappa == 0 ? "" : fmt::format("  radial_distortion: {{kappa: {}}}\n", kappa);
  const effects::Model model = model_of(
      "  pinhole: {fx_px: 161.9, fy_px: 162.5, cx_px: 88.5, cy_px: 71.5}\n"
      "  rolling_shutter: {line_delay_s: 2.78e-4}\n  exposure: {exposure_s: 0.005}\n" +
      lens);
  const FrameJob job = job_of(scene, model, kHeight, 0, 16);
  const LinearImage light = Renderer(model, kWidth, kHeight, options).render_linear(job);
  const BruteLens brute{161.9, 162.5, 88.5, 71.5, kappa};
  const BruteScene exact{assets, scene.background, scene.lighting};
  Apart found;
  size_t count = 0;
  for (int row = 5; row < kHeight; row += 24) {
    const RowWindow window = job.schedule.rows[row];
    std::vector<Rgb> sums(kWidth, Rgb{0, 0, 0});
    constexpr int kInstants = 256;
    for (int k = 0; k < kInstants; ++k) {
      const double t = window.start.s() + (window.end - window.start).s() * (k + 0.5) / kInstants;
      const std::vector<Primitive> primitives = scene.primitives(t);
      const Pose X_WC = scene.camera(t);
      for (int u = 0; u < kWidth; ++u) {
        const double a = k * 0.7548776662466927 + u * 0.3819660112501051;
        const double b = k * 0.5698402909980532 + u * 0.2360679774997897;
        const Rgb rgb = radiance_of(
            exact, primitives, X_WC.p,
            X_WC.R * brute.direction(u + a - std::floor(a) - 0.5, row + b - std::floor(b) - 0.5));
        for (int c = 0; c < 3; ++c) sums[u][c] += rgb[c] / kInstants;
      }
    }
    for (int u = 0; u < kWidth; ++u) {
      for (int c = 0; c < 3; ++c, ++count) {
        const double off = 255 * std::abs(sums[u][c] - light.planes[c][row * kWidth + u]);
        found.mean += off, found.within_6 += off <= 6;
      }
    }
  }
  found.mean /= static_cast<double>(count), found.within_6 /= static_cast<double>(count);
  std::printf("mean %.3f DN, within 6 DN %.5f\n", found.mean, found.within_6);
  return found;
}

TEST_F(Files, AMeshInMotionAgreesWithEveryTriangleAlone) {
  write_png(folder_ / "waves.png", waves(64));
  put("ring.mtl", "newmtl look\nKd 0.9 0.8 0.7\nmap_Kd waves.png\n");
  for (const bool lambert : {false, true}) {
    Assets assets;
    assets.meshes.push_back(read_mesh(put("ring.obj", ring_obj(10, 5, lambert)), 1));
    EXPECT_EQ(assets.meshes[0].indices.size(), 3u * 2 * 10 * 5);
    EXPECT_EQ(turn_seen_from_outside(assets.meshes[0]), lambert ? 1 : 0);
    ASSERT_EQ(assets.meshes[0].pictures.size(), 1u);
    MovingScene scene{[](double t) { return head_camera(0.3, 2.0 * (t - 0.02), -0.1, 0.05); },
                      [&](double t) {
                        return std::vector<Primitive>{
                            {.shape = Shape::mesh,
                             .X_WO = {rotation_zyx(0.5, 0.4 + 6 * t, 0.2), {0.8, 0.05 - t, 0.2}},
                             .size = Vec3(assets.meshes[0].radius_m),
                             .rgb = {1, 1, 1},
                             .asset = 1}};
                      }};
    scene.lighting = {
        .lambert = lambert, .direction_W = Vec3(-0.6, 0.0, 0.8), .ambient = 0.4, .diffuse = 0.6};
    const Apart found = against_brute_force(scene, assets, -0.2, {.edge_samples_per_pixel = 256});
    EXPECT_LE(found.mean, 0.3);
    EXPECT_GE(found.within_6, 0.999);
  }
}

// The same with light that falls on plain faces, of which STL files repeat each corner: these
// become one, and the faces keep their own normals.
TEST_F(Files, AMeshOfFlatFacesAgrees) {
  constexpr int kAround = 12, kTube = 6;
  std::string stl = "solid ring\n";
  const auto corner = [&](int a, int b) {
    const double s = 6.283185307179586 * (a % kAround) / kAround;
    const double t = 6.283185307179586 * (b % kTube) / kTube;
    return fmt::format("vertex {} {} {}\n", (0.2 + 0.08 * std::cos(t)) * std::cos(s),
                       (0.2 + 0.08 * std::cos(t)) * std::sin(s), 0.08 * std::sin(t));
  };
  for (int face = 0; face < kAround * kTube * 2; ++face) {
    const int a = face / 2 / kTube, b = face / 2 % kTube;
    // Some writers leave the normals at zero.
    stl += "facet normal 0 0 0\nouter loop\n" + corner(a, b) +
           (face % 2 == 0 ? corner(a + 1, b) + corner(a + 1, b + 1)
                          : corner(a + 1, b + 1) + corner(a, b + 1)) +
           "endloop\nendfacet\n";
  }
  Assets assets;
  assets.meshes.push_back(read_mesh(put("ring.stl", stl + "endsolid ring\n"), 1));
  const Mesh& mesh = assets.meshes[0];
  ASSERT_EQ(mesh.parts.size(), 1u);
  EXPECT_EQ(mesh.parts[0].flat, 1);
  EXPECT_EQ(mesh.vertices.size(), static_cast<size_t>(kAround * kTube));
  EXPECT_EQ(mesh.indices.size(), static_cast<size_t>(3 * 2 * kAround * kTube));
  EXPECT_EQ(turn_seen_from_outside(mesh), 1);
  MovingScene scene{[](double t) { return head_camera(0.3, 2.0 * (t - 0.02), -0.1, 0.05); },
                    [&](double t) {
                      return std::vector<Primitive>{
                          {.shape = Shape::mesh,
                           .X_WO = {rotation_zyx(0.5, 0.4 + 6 * t, 0.2), {0.8, 0.05 - t, 0.2}},
                           .size = Vec3(mesh.radius_m),
                           .rgb = {0.9, 0.5, 0.7},
                           .asset = 1}};
                    }};
  scene.lighting = {
      .lambert = true, .direction_W = Vec3(-0.6, 0.0, 0.8), .ambient = 0.3, .diffuse = 0.7};
  const Apart found = against_brute_force(scene, assets, -0.2, {.edge_samples_per_pixel = 256});
  EXPECT_LE(found.mean, 0.3);
  EXPECT_GE(found.within_6, 0.999);
}

// Surfaces of one colour each are drawn otherwise: as places in a palette. The mesh is cut by a
// rectangle, and its triangles are in several clusters.
TEST_F(Files, AMeshOfOneColourAPartAgrees) {
  put("ring.mtl", "newmtl look\nKd 0.9 0.8 0.7\nnewmtl other\nKd 0.2 0.1 0.6\n");
  std::string text = ring_obj(14, 6, true);
  text.insert(text.find("\nf ", text.size() * 7 / 8) + 1, "usemtl other\n");
  Assets assets;
  assets.meshes.push_back(read_mesh(put("ring.obj", text), 1));
  ASSERT_EQ(assets.meshes[0].parts.size(), 2u);
  ASSERT_TRUE(assets.meshes[0].pictures.empty());
  const MovingScene scene{
      [](double t) { return head_camera(0.3, 2.0 * (t - 0.02), -0.1, 0.05); },
      [&](double t) {
        return std::vector<Primitive>{
            {.shape = Shape::rectangle,
             .X_WO = {rotation_zyx(1.3, 0.2, -1.2), {0.8, t, 0.2}},
             .size = {0.7, 0.3, 0},
             .rgb = {0.4, 0.5, 0.1}},
            {.shape = Shape::mesh,
             .X_WO = {rotation_zyx(0.5, 0.4 + 6 * t, 0.2), {0.8, 0.05 - t, 0.2}},
             .size = Vec3(assets.meshes[0].radius_m),
             .rgb = {1, 0.9, 0.8},
             .asset = 1}};
      }};
  const Apart found = against_brute_force(scene, assets, -0.2, {.edge_samples_per_pixel = 256});
  EXPECT_LE(found.mean, 0.3);
  EXPECT_GE(found.within_6, 0.999);
}

TEST_F(Files, ATexturedRectangleAgrees) {
  write_png(folder_ / "waves.png", waves(32));
  Assets assets;
  assets.textures.push_back(read_texture({"waves.png", folder_.string(), ""}));
  const MovingScene scene{
      [](double t) { return head_camera(0.3, 2.0 * (t - 0.02), -0.1, 0.05); },
      [&](double t) {
        return std::vector<Primitive>{{.shape = Shape::rectangle,
                                       .X_WO = {rotation_zyx(1.3, 0.2, -1.2), {0.9, t, 0.25}},
                                       .size = {0.7, 0.5, 0},
                                       .rgb = {0.9, 1, 0.8},
                                       .asset = 1}};
      }};
  const Apart found = against_brute_force(scene, assets, 0, {.edge_samples_per_pixel = 256});
  EXPECT_LE(found.mean, 0.3);
  EXPECT_GE(found.within_6, 0.999);
}

// ---- Files ----

constexpr const char* kTriangleStl =
    "solid t\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 2 0 0\nvertex 0 1 0\nendloop\n"
    "endfacet\nendsolid t\n";

TEST_F(Files, StlIsTakenAsItStands) {
  const Mesh mesh = read_mesh(put("t.stl", kTriangleStl), 0.5);
  ASSERT_EQ(mesh.vertices.size(), 3u);
  EXPECT_NEAR(mesh.radius_m, 1, 1e-5);
  for (const MeshVertex& vertex : mesh.vertices) {
    EXPECT_EQ(vertex.n[2], 1);
    EXPECT_EQ(vertex.rgb[0], 1);
  }
}

TEST_F(Files, UpOfGltfBecomesZ) {
  // Three vertices as floats: (0,0,0), (1,0,0), (0,1,0).
  const std::string gltf =
      R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],
"meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],
"buffers":[{"byteLength":36,
"uri":"data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"}],
"bufferViews":[{"buffer":0,"byteOffset":0,"byteLength":36}],
"accessors":[{"bufferView":0,"componentType":5126,
"count":3,"type":"VEC3","min":[0,0,0],"max":[1,1,0]}]})";
  const Mesh mesh = read_mesh(put("t.gltf", gltf), 1);
  ASSERT_EQ(mesh.vertices.size(), 3u);
  double highest = 0;
  for (const MeshVertex& vertex : mesh.vertices) highest = std::max<double>(highest, vertex.p[2]);
  EXPECT_EQ(highest, 1);
}

TEST_F(Files, HostileOnesAreRefusedByName) {
  EXPECT_THAT(why_not({"none.obj", folder_.string(), ""}), ::testing::HasSubstr("none.obj"));
  for (const auto& [name, bytes, why] :
       std::vector<std::tuple<std::string, std::string, std::string>>{
           {"empty.obj", "", "not a readable mesh"},
           {"text.stl", "this is no mesh", "not a readable mesh"},
           {"half.glb", std::string("glTF\x02\0\0\0\xff\xff\xff\x7f", 12), "not a readable mesh"},
           {"nan.obj", "v nan 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "not finite"},
           {"points.obj", "v 0 0 0\nv 1 0 0\n", "not a readable mesh"},
           {"flat.obj", "v 0 0 0\nv 0 0 0\nv 0 0 0\nf 1 2 3\n", "radius"},
           {"beyond.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n", "not a readable mesh"},
           {"out.obj", "mtllib o.mtl\nusemtl m\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nf 1/1 2/1 3/1\n",
            "leads out of the folder"},
           {"lost.dae", "<?xml version=\"1.0\"?><COLLADA version=\"1.4.1\">",
            "not a readable mesh"}}) {
    put("o.mtl", "newmtl m\nmap_Kd ../../secret.png\n");
    const std::string found = why_not(put(name, bytes));
    EXPECT_THAT(found, ::testing::HasSubstr(name));
    EXPECT_THAT(found, ::testing::HasSubstr(why)) << name;
  }
  // A header that promises 50 million triangles.
  std::string stl(84, '\0');
  const uint32_t count = 50'000'000;
  std::memcpy(stl.data() + 80, &count, 4);
  EXPECT_THAT(why_not(put("many.stl", stl)), ::testing::HasSubstr("many.stl"));
}

TEST_F(Files, PicturesAreRefusedByName) {
  put("bad.png", "\x89PNG\r\n\x1a\nno");
  put("bad.jpg", "\xff\xd8\xff\xe0 nothing");
  put("bad.gif", "GIF89a");
  for (const char* name : {"bad.png", "bad.jpg", "bad.gif"}) {
    try {
      read_texture({name, folder_.string(), ""});
      ADD_FAILURE() << name;
    } catch (const InputError& error) {
      EXPECT_THAT(error.what(), ::testing::HasSubstr(name));
    }
  }
}

TEST_F(Files, AChangedFileIsNotThatOfTheLog) {
  FileName file = put("t.stl", kTriangleStl);
  file.fingerprint = read_mesh(file, 1).fingerprint;
  EXPECT_NO_THROW(read_mesh(file, 1));
  put("t.stl", std::string(kTriangleStl) + "\n");
  EXPECT_THAT(why_not(file), ::testing::HasSubstr("has changed"));
}

}  // namespace
}  // namespace seam::render
