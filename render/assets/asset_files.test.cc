// Files of strangers.
#include <gmock/gmock.h>
#include <sys/resource.h>

#include "render/assets/asset_files_testing.h"
#include "render/assets/mesh_bytes.h"
#include "sim_core/base/image.h"

namespace seam::render {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

// Black, so that its file is small.
std::string black_png(int width, int height) {
  return encode_png({.width_px = width,
                     .height_px = height,
                     .channels = 1,
                     .samples = std::vector<uint16_t>(static_cast<size_t>(width) * height)});
}

// A triangle in COLLADA, with more of the file's libraries and nodes.
std::string collada(const std::string& libraries, const std::string& nodes,
                    const std::string& primitives =
                        "<triangles count=\"1\"><input semantic=\"VERTEX\" source=\"#v\" "
                        "offset=\"0\"/><p>0 1 2</p></triangles>") {
  return R"(<?xml version="1.0"?><COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema"
version="1.4.1"><asset><unit name="meter" meter="1"/><up_axis>Z_UP</up_axis></asset>)" +
         libraries +
         R"(<library_geometries><geometry id="g"><mesh><source id="p">
<float_array id="pa" count="9">0 0 0 1 0 0 0 1 0</float_array><technique_common>
<accessor source="#pa" count="3" stride="3"><param name="X" type="float"/>
<param name="Y" type="float"/><param name="Z" type="float"/></accessor></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#p"/></vertices>)" +
         primitives +
         R"(</mesh></geometry></library_geometries><library_visual_scenes><visual_scene id="s">)" +
         nodes +
         R"(<node id="n"><instance_geometry url="#g"/></node></visual_scene></library_visual_scenes>
<scene><instance_visual_scene url="#s"/></scene></COLLADA>)";
}

TEST_F(AssetFilesTest, CamerasAndLampsDoNotMatter) {
  const std::string camera =
      "<library_cameras><camera id=\"c\" name=\"Camera\"><optics><technique_common><perspective>"
      "<xfov>49</xfov><znear>0.1</znear><zfar>100</zfar></perspective></technique_common></optics>"
      "</camera></library_cameras><library_lights><light id=\"l\"><technique_common><point>"
      "<color>1 1 1</color></point></technique_common></light></library_lights>";
  std::string nodes;
  for (const char* what :
       {"camera url=\"#c\"", "camera url=\"#c\"", "light url=\"#l\"", "light url=\"#l\""})
    nodes += fmt::format("<node id=\"same\" name=\"Same\"><instance_{}/></node>", what);
  EXPECT_EQ(read_mesh(put("two.dae", collada(camera, nodes)), 1).indices.size(), 3u);
}

TEST_F(AssetFilesTest, PointsAndLinesAreLeftOut) {
  const std::string corners = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n";
  const Mesh mesh =
      read_mesh(put("mixed.obj", corners + "f 1 2 3\np 1\nl 1 2\nf 4\nf 1 2\nl 2 3\n"), 1);
  EXPECT_EQ(mesh.indices.size(), 3u);
  const std::string lines =
      "<lines count=\"1\"><input semantic=\"VERTEX\" source=\"#v\" "
      "offset=\"0\"/><p>0 1</p></lines>";
  EXPECT_THAT(why_not(put("lines.dae", collada("", "", lines))), HasSubstr("found no triangles"));
  for (const char* only : {"p 1 2\n", "l 1 2\n", "f 1\n"}) {
    const std::string why = why_not(put("none.obj", corners + only));
    EXPECT_THAT(why, HasSubstr("none.obj: not a readable mesh"));
    EXPECT_THAT(why, Not(HasSubstr("ai")));
  }
}

TEST_F(AssetFilesTest, WhatIsNotReadIsSaidInOurWords) {
  for (const char* name : {"a.fbx", "a.ply", "a.step", "a"}) {
    const std::string why = why_not(put(name, "something"));
    EXPECT_THAT(why, HasSubstr(".gltf or .glb (glTF 2.0), .obj, .stl or .dae (COLLADA)")) << name;
  }
  for (const char* name : {"a.stl", "a.dae", "a.gltf", "a.glb"}) {
    const std::string why = why_not(put(name, "something else"));
    EXPECT_THAT(why, HasSubstr(std::string(name) + ": not a readable mesh")) << why;
    EXPECT_THAT(why, Not(HasSubstr("suitable reader"))) << why;
    EXPECT_THAT(why, Not(HasSubstr("::"))) << why;
  }
}

// ---- Files that unpack to far more than they are long ----

std::string gltf(const std::string& nodes, const std::string& accessor) {
  return R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[)" + nodes +
         R"(],"meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],"accessors":[)" + accessor +
         R"(],"bufferViews":[{"buffer":0,"byteLength":36}],"buffers":[{"byteLength":36,"uri":
"data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"}]})";
}
const char* const kTriangle =
    R"({"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[1,1,0]})";

// Each node has the next one as its child twice.
std::string shared_children(int depth, const std::string& last) {
  std::string nodes;
  for (int i = 0; i < depth; ++i) nodes += fmt::format(R"({{"children":[{0},{0}]}},)", i + 1);
  return nodes + last;
}

TEST_F(AssetFilesTest, SharedChildrenAreCountedEachTime) {
  const Mesh few =
      read_mesh(put("few.gltf", gltf(shared_children(3, R"({"mesh":0})"), kTriangle)), 1);
  EXPECT_EQ(few.indices.size(), 24u);
  EXPECT_THAT(
      why_not(put("dag.gltf", gltf(shared_children(26, R"({"mesh":0})"), kTriangle))),
      HasSubstr("dag.gltf: not a readable mesh: its meshes, each as often as nodes name it, "
                "hold 201326592 vertices, expected at most 15000000"));
  EXPECT_THAT(why_not(put("bare.gltf", gltf(shared_children(60, "{}"), kTriangle))),
              HasSubstr("give each node one parent"));
  EXPECT_THAT(why_not(put("round.gltf", gltf(R"({"children":[1]},{"children":[0]})", kTriangle))),
              HasSubstr("expected children in no circle"));
}

TEST_F(AssetFilesTest, AccessorsAreCountedAsUnpacked) {
  const std::string sparse =
      R"({"componentType":5126,"count":300000000,"type":"VEC3","sparse":{"count":1,
"indices":{"bufferView":0,"componentType":5125},"values":{"bufferView":0}}})";
  EXPECT_THAT(why_not(put("sparse.gltf", gltf(R"({"mesh":0})", sparse))),
              HasSubstr("hold 300000000 vertices"));
  // In a GLB file, whose JSON is its first chunk.
  const std::string text = gltf(R"({"mesh":0})", sparse);
  std::string glb = "glTF";
  for (const uint32_t number : {2u, static_cast<uint32_t>(20 + text.size()),
                                static_cast<uint32_t>(text.size()), 0x4e4f534au})
    glb.append(reinterpret_cast<const char*>(&number), 4);
  EXPECT_THAT(why_not(put("sparse.glb", glb + text)), HasSubstr("hold 300000000 vertices"));
}

// Nodes of COLLADA may be shared, too, and its reader unpacks them before anyone can count.
TEST_F(AssetFilesTest, WhatCannotBeCountedIsStopped) {
  std::string library = "<library_nodes>";
  for (int i = 0; i < 40; ++i)
    library += fmt::format(
        "<node id=\"k{0}\"><instance_node url=\"#k{1}\"/><instance_node "
        "url=\"#k{1}\"/></node>",
        i, i + 1);
  library += "<node id=\"k40\"><instance_geometry url=\"#g\"/></node></library_nodes>";
  const std::string bytes =
      collada(library, "<node id=\"top\"><instance_node url=\"#k0\"/></node>");
  put("dag.dae", bytes);
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
  AssetLimits limits;
  limits.take_reader_seconds(AssetLimits::kMostReaderSeconds - 2);
  EXPECT_THROW(import_mesh_apart(folder_, "dag.dae", bytes, limits), InputError);
  rusage children{};
  getrusage(RUSAGE_CHILDREN, &children);
  EXPECT_LT(children.ru_maxrss, 1'500'000);  // KiB.
#endif
}

TEST_F(AssetFilesTest, APictureIsReadOnceWhateverItIsCalled) {
  put("a.png", black_png(4000, 4000));
  std::string materials, text = "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\n", dots;
  for (int i = 0; i < 20; ++i, dots += "./") {
    materials += fmt::format("newmtl m{}\nmap_Kd {}a.png\n", i, dots);
    text += fmt::format("usemtl m{}\nf 1/1 2/1 3/1\n", i);
  }
  put("m.mtl", materials);
  const Mesh mesh = read_mesh(put("m.obj", text), 1);
  ASSERT_FALSE(mesh.pictures.empty());
  for (const auto& picture : mesh.pictures) EXPECT_EQ(picture, mesh.pictures.front());
  // Of several meshes and textures, too.
  AssetFiles files;
  const Mesh one = files.mesh({"m.obj", folder_.string(), ""}, 1);
  fs::create_symlink("a.png", folder_ / "link.png");
  EXPECT_EQ(files.texture({"link.png", folder_.string(), ""}).picture, one.pictures.front());
}

TEST_F(AssetFilesTest, PixelsAreLimitedInAll) {
  AssetFiles files;
  for (int i = 0; i < 4; ++i) {
    const FileName file = put(fmt::format("{}.png", i), black_png(4000, 4000));
    EXPECT_EQ(files.texture(file).picture->rgb.size(), 48'000'000u);
  }
  try {
    files.texture(put("5.png", black_png(8, 8)));
    ADD_FAILURE();
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("5.png"));
    EXPECT_THAT(error.what(), HasSubstr("expected at most 64 million in all pictures of a scene"));
  }
}

TEST_F(AssetFilesTest, SixteenBitsAndGreyBecomeBytes) {
  write_png(folder_ / "deep.png", {.width_px = 2,
                                   .height_px = 1,
                                   .channels = 3,
                                   .bits = 16,
                                   .samples = {0x1234, 0xff00, 1, 0, 0x80ff, 0xffff}});
  EXPECT_EQ(read_texture({"deep.png", folder_.string(), ""}).picture->rgb,
            (std::vector<uint8_t>{0x12, 0xff, 0, 0, 0x80, 0xff}));
  write_png(folder_ / "grey.png",
            {.width_px = 2, .height_px = 1, .channels = 1, .samples = {7, 200}});
  EXPECT_EQ(read_texture({"grey.png", folder_.string(), ""}).picture->rgb,
            (std::vector<uint8_t>{7, 7, 7, 200, 200, 200}));
}

TEST_F(AssetFilesTest, TrianglesAreLimitedInAll) {
  AssetLimits limits;
  limits.take_triangles(kMostTriangles - 1);
  EXPECT_NO_THROW(limits.take_triangles(1));
  EXPECT_THROW(limits.take_triangles(1), InputError);
}

}  // namespace
}  // namespace seam::render
