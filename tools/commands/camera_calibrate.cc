// `seam camera-calibrate --model TRUTH --out DIR`: the measurement sets that calibrate a camera,
// made with the simulator: points of a room seen from a swinging head, and flat fields with darks.
// What a laboratory would measure on a real robot; the protocols are kept beside, to be followed
// there.
#include <filesystem>

#include "app/predictors/instruments.h"
#include "measurement/kinds/kinds.h"
#include "measurement/study/study.h"
#include "sim_core/base/error.h"
#include "sim_core/base/maths.h"
#include "sim_core/base/output.h"
#include "sim_core/base/random.h"
#include "sim_core/signals/half_made.h"
#include "tools/command.h"
#include "tools/commands/analysis.h"

namespace seam::tools {
namespace {

struct CalibrateSettings {
  std::string model;
  std::string out;
  uint64_t seed = 1;
  int frames = 200;
  int points = 120;
  int levels = 5;
  int repeats = 12;
  int width_px = 178;
  int height_px = 144;
};

std::filesystem::path folder_for(const std::filesystem::path& folder) {
  make_output_folder(folder);
  return folder;
}

// The head swings its pan over +-60 degrees in 1.3 s and its tilt a little in 2.1 s: rates, angles
// and image places come in all combinations.
void write_room(const std::filesystem::path& folder, const CalibrateSettings& settings) {
  constexpr double kStart_s = 0.2, kPeriod_s = 0.04, kJointPeriod_s = 0.008;
  const double end_s = kStart_s + settings.frames * kPeriod_s + 0.4;
  std::string joints = "time_s,tilt_rad,pan_rad\n";
  for (int i = 0; i * kJointPeriod_s < end_s; ++i) {
    const double t = i * kJointPeriod_s;
    joints += fmt::format("{:.6f},{:.7f},{:.7f}\n", t,
                          0.1 + 0.2 * maths::sin(2 * maths::kPi * t / 2.1 + 0.4),
                          1.05 * maths::sin(2 * maths::kPi * t / 1.3));
  }
  std::string points = "frame,time_s,point,x_m,y_m,z_m\n";
  const RandomStream places = RandomStream{settings.seed, 0}.child("room");
  for (int frame = 0; frame < settings.frames; ++frame) {
    for (int point = 0; point < settings.points; ++point) {
      // Marks on walls and stands 0.8 to 2.5 m away, over the half of the room that the head can
      // see.
      const auto draw = [&](int k) {
        return uniform(places, static_cast<uint64_t>(3 * point + k));
      };
      const double range = 0.8 + 1.7 * draw(0), bearing = 2.6 * (draw(1) - 0.5),
                   height = 0.9 * range * (draw(2) - 0.6);
      points += fmt::format("{},{:.6f},{},{:.5f},{:.5f},{:.5f}\n", frame,
                            kStart_s + frame * kPeriod_s, point, range * maths::cos(bearing),
                            range * maths::sin(bearing), 0.24 + height);
    }
  }
  write_file_atomically(folder / "joints.csv", joints);
  write_file_atomically(folder / "points.csv", points);
  write_file_atomically(
      folder / "measurement.yaml",
      fmt::format(
          "format: seam-measurement/1\nkind: points\ntitle: Room points seen from a swinging head\n"
          "camera: {{width_px: {}, height_px: {}, frame_period_s: {}}}\n"
          "noise: {{u_px: 0.15, v_px: 0.15}}\ngroup: frame\nfiles: {{points: points.csv, joints: "
          "joints.csv}}\n"
          "{}",
          settings.width_px, settings.height_px, kPeriod_s, measurement::head_rig("[0, 1, 0]")));
}

// Darks first, half of them with four times the exposure (dark current shows there alone), then
// levels of even light, each several times.
void write_flat_fields(const std::filesystem::path& folder, const CalibrateSettings& settings) {
  std::string frames = "frame,file,time_s,exposure_s,illumination\n";
  int frame = 0;
  const auto shoot = [&](double exposure_s, double illumination) {
    for (int repeat = 0; repeat < settings.repeats; ++repeat, ++frame) {
      frames += fmt::format("{},frames/{:04}.png,{:.6f},{:.6f},{:.4f}\n", frame, frame,
                            0.04 * frame, exposure_s, illumination);
    }
  };
  shoot(0.005, 0);
  shoot(0.02, 0);
  for (int level = 1; level <= settings.levels; ++level)
    shoot(0.005, 0.9 * level / settings.levels);
  write_file_atomically(folder / "frames.csv", frames);
  write_file_atomically(
      folder / "measurement.yaml",
      fmt::format(
          "format: seam-measurement/1\nkind: photometry\ntitle: Darks and flat fields\n"
          "camera: {{width_px: {}, height_px: {}, frame_period_s: 0.04, channels: grey, bits: 8}}\n"
          "group: frame\nfiles: {{frames: frames.csv}}\n",
          settings.width_px, settings.height_px));
}

// Everything is made here and moved to its place when all of it is there, so that a model that
// cannot give one of the sets leaves nothing behind.
class Unfinished {
 public:
  explicit Unfinished(const std::filesystem::path& out)
      : out_(out),
        out_is_new_(!std::filesystem::exists(out)),
        path_(out / ".unfinished"),
        half_made_(path_) {
    make_output_folder(path_);
  }
  ~Unfinished() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
    // Goes only where it is empty.
    if (out_is_new_) std::filesystem::remove(out_, ignored);
  }
  Unfinished(const Unfinished&) = delete;
  Unfinished& operator=(const Unfinished&) = delete;

  const std::filesystem::path& path() const { return path_; }
  void finish() const {
    for (const auto& made : std::filesystem::directory_iterator(path_)) {
      const std::filesystem::path place = out_ / made.path().filename();
      std::filesystem::remove_all(place);
      std::filesystem::rename(made.path(), place);
    }
  }

 private:
  std::filesystem::path out_;
  bool out_is_new_;
  std::filesystem::path path_;
  HalfMade half_made_;
};

void calibrate(const CalibrateSettings& settings) {
  const effects::Model truth = read_model(settings.model);
  const std::filesystem::path out = settings.out;
  const Unfinished made(out);
  write_room(folder_for(made.path() / "protocols/room"), settings);
  write_flat_fields(folder_for(made.path() / "protocols/flat_fields"), settings);
  for (const char* set : {"flat_fields", "room"}) {
    const auto protocol = measurement::MeasurementSet::open(made.path() / "protocols" / set);
    measurement::measure_set(truth, protocol,
                             {.seed = settings.seed, .noise = true, .out = made.path() / set},
                             app::instruments());
  }
  made.finish();
  std::printf("%s\n%s\n", (out / "room").c_str(), (out / "flat_fields").c_str());
  std::printf("Next: seam discover --model YOUR_MODEL --data %s --out calibrated.yaml\n",
              (out / "room").c_str());
}

}  // namespace

void add_camera_calibrate(app::Command app) {
  app::Command command = app.add_subcommand(
      "camera-calibrate", "Makes the measurement sets that calibrate a camera's model");
  auto settings = std::make_shared<CalibrateSettings>();
  command.add_option("--model", settings->model, "The true camera, a seam-model/1 file").required();
  command
      .add_option("--out", settings->out,
                  "Folder for the sets room/ and flat_fields/, and their protocols/")
      .required();
  command.add_option("--seed", settings->seed, "Seed of places and noise").show_default();
  command.add_option("--frames", settings->frames, "Frames of the room")
      .range(4, 10000)
      .show_default();
  command.add_option("--points", settings->points, "Marks in the room")
      .range(4, 1000)
      .show_default();
  command.add_option("--levels", settings->levels, "Levels of light beside the darks")
      .range(1, 100)
      .show_default();
  command.add_option("--repeats", settings->repeats, "Frames at each level")
      .range(2, 1000)
      .show_default();
  command.add_option("--width", settings->width_px, "Image width, pixels")
      .range(8, 4096)
      .show_default();
  command.add_option("--height", settings->height_px, "Image height, pixels")
      .range(8, 4096)
      .show_default();
  command.footer(
      "The sets are made by `seam measure`'s code from the protocols beside them, which say what "
      "was done; follow them\n"
      "in a laboratory to calibrate a real camera.\n"
      "Examples:\n"
      "  seam camera-calibrate --model models/ers210_full.yaml --out calibration --frames 50 "
      "--points 40\n"
      "  seam discover --model models/ideal_camera.yaml --data calibration/room --out "
      "calibrated.yaml");
  command.callback([settings] { calibrate(*settings); });
}

}  // namespace seam::tools
