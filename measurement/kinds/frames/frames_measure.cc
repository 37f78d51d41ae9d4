// Makes a set of whole images: what the model would give by a protocol's rig, scene and stamps.
#include <filesystem>

#include "effects/cameras.h"
#include "effects/questions.h"
#include "effects/stages/sensor/sensor.h"
#include "effects/stages/timing.h"
#include "measurement/kinds/frames/frames.h"
#include "sim_core/base/error.h"

namespace seam::measurement {

namespace {

// The scene with the files that it names, and what lies beside a mesh of a format that names files
// itself.
void copy_scene(const std::filesystem::path& out, const MeasurementSet& protocol,
                const SceneFiles& files) {
  namespace fs = std::filesystem;
  copy_into(out, protocol, protocol.root.at("scene").text());
  const auto copy = [&](const fs::path& file) {
    copy_into(out, protocol, fs::relative(file, protocol.folder).string());
  };
  for (const FileName& texture : files.textures) copy(fs::path(texture.folder) / texture.name);
  for (const SceneFiles::MeshFile& mesh : files.meshes) {
    const fs::path file = fs::path(mesh.file.folder) / mesh.file.name;
    copy(file);
    const std::string sort = file.extension().string();
    if (sort == ".stl" || sort == ".glb") continue;
    for (const auto& beside : fs::directory_iterator(file.parent_path())) {
      if (!beside.is_regular_file() || beside.is_symlink()) continue;
      const std::string part = beside.path().extension().string();
      if (part == ".mtl" || part == ".bin" || part == ".png" || part == ".jpg" || part == ".jpeg")
        copy(beside.path());
    }
  }
}

}  // namespace

void measure_frames(const Model& whole, const MeasurementSet& protocol,
                    const MeasureOptions& options, const Instruments& instruments) {
  effects::check_pictured(whole);
  const Model truth = effects::without_points_own(whole);
  const CsvTable table = protocol.table("frames");
  const FrameProtocol frames(protocol, table, instruments);
  const auto files = table.texts("file");
  copy_protocol(protocol, options.out, {});
  copy_scene(options.out, protocol, frames.scene_files());
  const effects::SensorChain chain = effects::sensor_of(truth);
  const RandomStream camera = RandomStream{.seed = options.seed}.child("frames");
  const auto pattern =
      effects::fixed_pattern(chain, frames.width_px(), frames.height_px(), 3, camera);
  const auto predictor = frames.predictor(truth);
  const Rig::Motion motion = frames.rig().motion(truth);
  for (size_t f = 0; f < frames.frames(); ++f) {
    protocol.inside(table, f, "file");
    const std::vector<float> light = predictor->light(frames.job(f, truth, motion));
    const effects::SensorExposure exposure{.exposure_s = effects::timing_of(truth).exposure_s,
                                           .t_s = (frames.stamp(f) - frames.reference()).s()};
    const Image image = effects::expose(chain, pattern, light, exposure,
                                        camera.child("frame").child(f), options.noise);
    write_png(written_path(options.out, files[f]), image);
  }
}

}  // namespace seam::measurement
