#include "app/session/frame_files.h"

#include <fmt/format.h>

#include <cmath>

#include "sim_core/base/error.h"
#include "sim_core/base/image.h"
#include "sim_core/input/file_names.h"
#include "sim_core/system/thread.h"

namespace seam::app {

namespace {

constexpr size_t kMaxWaiting = 64;

// Unit quaternion (w, x, y, z), w >= 0, of a rotation matrix (Shepperd's method: divides by the
// largest component).
std::array<double, 4> quaternion_of(const Mat3& R) {
  const auto m = [&R](int row, int column) { return R[column][row]; };
  const double trace = m(0, 0) + m(1, 1) + m(2, 2);
  const double squares[4] = {trace, m(0, 0), m(1, 1), m(2, 2)};
  int largest = 0;
  for (int i = 1; i < 4; ++i)
    if (squares[i] > squares[largest]) largest = i;
  std::array<double, 4> q{};
  if (largest == 0) {
    const double s = 2 * std::sqrt(1 + trace);
    q = {s / 4, (m(2, 1) - m(1, 2)) / s, (m(0, 2) - m(2, 0)) / s, (m(1, 0) - m(0, 1)) / s};
  } else {
    const int i = largest - 1, j = (i + 1) % 3, k = (i + 2) % 3;
    const double s = 2 * std::sqrt(1 + m(i, i) - m(j, j) - m(k, k));
    q[0] = (m(k, j) - m(j, k)) / s;
    q[1 + i] = s / 4;
    q[1 + j] = (m(j, i) + m(i, j)) / s;
    q[1 + k] = (m(k, i) + m(i, k)) / s;
  }
  if (q[0] < 0)
    for (double& component : q) component = -component;
  return q;
}

// Whether a file of this name stands in a folder of frames: frames.csv, ROBOT_NNNNNN.png.
bool is_of_a_run(const std::string& name) {
  if (name == "frames.csv") return true;
  if (!name.ends_with(".png")) return false;
  const std::string_view stem = std::string_view(name).substr(0, name.size() - 4);
  const size_t robot_end = stem.find_last_not_of("0123456789");
  return robot_end != stem.npos && robot_end > 0 && stem[robot_end] == '_' &&
         stem.size() - robot_end > 6;
}

}  // namespace

FrameFiles::FrameFiles(const std::filesystem::path& folder, bool overwrite) : folder_(folder) {
  make_output_folder(folder);
  std::vector<std::filesystem::path> earlier;
  for (const auto& entry : std::filesystem::directory_iterator(folder))
    if (is_of_a_run(entry.path().filename().string())) earlier.push_back(entry.path());
  if (!earlier.empty() && !overwrite)
    throw InputError(fmt::format(
        "{}: holds the frames of another run ({}); give another folder, or --force to replace them",
        folder.string(), earlier.front().filename().string()));
  csv_ = OutputFile(folder / "frames.csv");
  for (const std::filesystem::path& file : earlier) std::filesystem::remove(file);
  csv_.write("file,robot,frame,stamp_ns,row,row_start_ns,row_end_ns,x_m,y_m,z_m,qw,qx,qy,qz\n");
  thread_ = start_thread([this] { write_pictures(); });
}

FrameFiles::~FrameFiles() {
  if (thread_.joinable()) stop_writing();
}

void FrameFiles::stop_writing() {
  {
    const std::lock_guard lock(mutex_);
    ending_ = true;
  }
  changed_.notify_all();
  thread_.join();
}

void FrameFiles::on_frame(SimTime, const FrameJob& job, const Frame& frame) {
  const std::string name = fmt::format("{}_{:06}.png", frame.robot, frame.frame_index);
  write_rows(name, job, frame);
  ++written_;
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [&] { return pictures_.size() < kMaxWaiting; });
  if (!error_.empty()) throw InputError(error_);
  pictures_.push_back({path_inside(folder_, name), frame.width_px, frame.height_px, frame.rgb});
  changed_.notify_all();
}

void FrameFiles::write_rows(const std::string& name, const FrameJob& job, const Frame& frame) {
  fmt::memory_buffer out;
  for (size_t r = 0; r < job.schedule.rows.size() && r < job.row_cameras.size(); ++r) {
    const RowWindow& row = job.schedule.rows[r];
    const Pose& X_WC = job.row_cameras[r];
    const auto q = quaternion_of(X_WC.R);
    fmt::format_to(std::back_inserter(out), "{},{},{},{},{},{},{},{},{},{},{},{},{},{}\n", name,
                   frame.robot, frame.frame_index, frame.stamp.ns(), r, row.start.ns(),
                   row.end.ns(), X_WC.p.x, X_WC.p.y, X_WC.p.z, q[0], q[1], q[2], q[3]);
  }
  csv_.write({out.data(), out.size()});
}

void FrameFiles::write_pictures() {
  while (true) {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return ending_ || !pictures_.empty(); });
    if (pictures_.empty()) return;
    const Picture picture = std::move(pictures_.front());
    pictures_.pop_front();
    changed_.notify_all();
    lock.unlock();
    Image image{.width_px = picture.width_px, .height_px = picture.height_px, .channels = 3};
    image.samples.assign(picture.rgb.begin(), picture.rgb.end());
    try {
      write_png(picture.file, image);
    } catch (const std::exception& error) {
      lock.lock();
      if (error_.empty()) error_ = error.what();
    }
  }
}

void FrameFiles::on_end(SimTime, scheduler::EndReason, uint64_t) {
  stop_writing();
  if (!error_.empty()) throw InputError(error_);
  csv_.commit();
}

}  // namespace seam::app
