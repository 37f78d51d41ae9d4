// `seam contact-sheet DIR... --out F`: folders of frames (`seam run --frames`) on one sheet, one
// row a folder, or with --by-robot one frame of each robot; the frames are those taken near the
// middle of the camera's swing, where it turns fastest.
#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <map>

#include "render/pictures/pictures.h"
#include "sim_core/base/error.h"
#include "sim_core/base/files.h"
#include "sim_core/base/maths.h"
#include "sim_core/base/output.h"
#include "tools/command.h"

namespace seam::tools {
namespace {

struct SheetSettings {
  std::vector<std::string> folders;
  std::string out;
  int count = 4;
  int enlarge = 2;
  bool by_robot = false;
};

struct FilmedFrame {
  std::string file;
  std::string robot;
  double first_yaw = 0, last_yaw = 0,
         middle_yaw = 0;  // Of the optical axis, at first, last and middle row; rad.
  double seconds = 0;     // Between the first and the last row.
};

std::vector<std::string> cells_of(const std::string& line) {
  std::vector<std::string> cells(1);
  for (const char letter : line) {
    if (letter == ',')
      cells.emplace_back();
    else if (letter != '\r')
      cells.back() += letter;
  }
  return cells;
}

class FramesTable {
 public:
  explicit FramesTable(const std::filesystem::path& file)
      : file_(file.string()), text_(read_file(file, 1 << 28)) {
    size_t begin = 0;
    while (begin < text_.size()) {
      const size_t end = std::min(text_.find('\n', begin), text_.size());
      if (end > begin) rows_.push_back(cells_of(text_.substr(begin, end - begin)));
      begin = end + 1;
    }
    if (rows_.empty()) throw InputError(fmt::format("{}: found nothing, expected a header", file_));
    for (size_t i = 0; i < rows_[0].size(); ++i) columns_[rows_[0][i]] = i;
  }
  size_t rows() const { return rows_.size() - 1; }
  const std::string& text(size_t row, const std::string& column) const {
    const auto found = columns_.find(column);
    if (found == columns_.end())
      throw InputError(fmt::format("{}:1: found no column '{}'", file_, column));
    if (rows_[row + 1].size() <= found->second) {
      throw InputError(fmt::format("{}:{}: found {} cells, expected {}", file_, row + 2,
                                   rows_[row + 1].size(), rows_[0].size()));
    }
    return rows_[row + 1][found->second];
  }
  double number(size_t row, const std::string& column) const {
    const std::string& cell = text(row, column);
    double value = 0;
    const auto [end, error] = std::from_chars(cell.data(), cell.data() + cell.size(), value);
    if (error != std::errc() || end != cell.data() + cell.size() || !std::isfinite(value)) {
      throw InputError(
          fmt::format("{}:{}: {}: found '{}', expected a number", file_, row + 2, column, cell));
    }
    return value;
  }

 private:
  std::string file_;
  std::string text_;
  std::vector<std::vector<std::string>> rows_;
  std::map<std::string, size_t> columns_;
};

// Direction of the camera's z axis over the ground.
double yaw_of(const FramesTable& table, size_t row) {
  const double w = table.number(row, "qw"), x = table.number(row, "qx"),
               y = table.number(row, "qy"), z = table.number(row, "qz");
  return maths::atan2(2 * (y * z - w * x), 2 * (x * z + w * y));
}

std::vector<FilmedFrame> read_frames(const std::filesystem::path& folder) {
  const FramesTable table(folder / "frames.csv");
  std::vector<FilmedFrame> frames;
  for (size_t row = 0; row < table.rows();) {
    size_t end = row;
    while (end < table.rows() && table.text(end, "file") == table.text(row, "file")) ++end;
    FilmedFrame frame{.file = (folder / table.text(row, "file")).string(),
                      .robot = table.text(row, "robot"),
                      .first_yaw = yaw_of(table, row)};
    frame.middle_yaw =
        frame.first_yaw + maths::wrap_angle(yaw_of(table, (row + end) / 2) - frame.first_yaw);
    frame.last_yaw = frame.first_yaw + maths::wrap_angle(yaw_of(table, end - 1) - frame.first_yaw);
    frame.seconds =
        (table.number(end - 1, "row_start_ns") - table.number(row, "row_start_ns")) * 1e-9;
    frames.push_back(frame);
    row = end;
  }
  if (frames.empty())
    throw InputError(fmt::format("{}: found no frames", (folder / "frames.csv").string()));
  return frames;
}

// Those taken nearest the middle of the swing first.
void sort_by_distance_from_centre(std::vector<FilmedFrame>& frames) {
  double least = 1e9, most = -1e9;
  for (const FilmedFrame& frame : frames) {
    least = std::min(least, frame.middle_yaw), most = std::max(most, frame.middle_yaw);
  }
  const double centre = 0.5 * (least + most);
  std::stable_sort(frames.begin(), frames.end(), [&](const FilmedFrame& a, const FilmedFrame& b) {
    return std::abs(a.middle_yaw - centre) < std::abs(b.middle_yaw - centre);
  });
}

render::Panel panel_of(const std::string& name, const FilmedFrame& frame, int enlarge) {
  const double degrees = (frame.last_yaw - frame.first_yaw) * 180 / maths::kPi;
  const std::string motion = frame.seconds > 0
                                 ? fmt::format("{:+.0f} deg/s, turned {:+.1f} deg in the frame",
                                               degrees / frame.seconds, degrees)
                                 : std::string("all rows at one instant");
  return {fmt::format("{}: {}", name, motion), render::enlarged(read_png(frame.file), enlarge)};
}

std::vector<render::Panel> panels_of(const std::string& folder, const SheetSettings& settings) {
  std::vector<FilmedFrame> frames = read_frames(folder);
  std::vector<render::Panel> panels;
  if (settings.by_robot) {
    std::vector<std::string> robots;
    std::map<std::string, std::vector<FilmedFrame>> frames_of;
    for (FilmedFrame& frame : frames) {
      if (!frames_of.contains(frame.robot)) robots.push_back(frame.robot);
      // Turning left, or at rest, so that all slant the same way.
      auto& own = frames_of[frame.robot];
      if (frame.last_yaw >= frame.first_yaw) own.push_back(std::move(frame));
    }
    for (const std::string& robot : robots) {
      auto& own = frames_of[robot];
      if (own.empty()) continue;
      sort_by_distance_from_centre(own);
      panels.push_back(panel_of(robot, own.front(), settings.enlarge));
    }
    return panels;
  }
  sort_by_distance_from_centre(frames);
  const std::string name = std::filesystem::path(folder).lexically_normal().filename().string();
  for (int i = 0; i < settings.count; ++i) {
    if (i < static_cast<int>(frames.size())) {
      panels.push_back(panel_of(name.empty() ? folder : name, frames[i], settings.enlarge));
    } else {
      panels.push_back(
          {"", Image{.width_px = 1, .height_px = 1, .channels = 3, .samples = {245, 245, 245}}});
    }
  }
  return panels;
}

}  // namespace

void add_contact_sheet(app::Command app) {
  app::Command command =
      app.add_subcommand("contact-sheet", "Frames of several runs on one sheet, one row a run");
  auto settings = std::make_shared<SheetSettings>();
  command.add_option("DIR", settings->folders, "Folders that `seam run --frames` wrote").required();
  command.add_option("--out", settings->out, "The sheet, a PNG file").required();
  command.add_flag("--by-robot", settings->by_robot, "One frame of each robot, in rows of --count");
  command.add_option("--count", settings->count, "Frames of each run").range(1, 32).show_default();
  command.add_option("--enlarge", settings->enlarge, "How many times as large")
      .range(1, 8)
      .show_default();
  command.footer("Example: seam contact-sheet rolling instantaneous --out sheet.png");
  command.callback([settings] {
    OutputRules rules;
    for (const std::string& folder : settings->folders) {
      rules.inputs.push_back(std::filesystem::path(folder) / "frames.csv");
      for (const FilmedFrame& frame : read_frames(folder)) rules.inputs.emplace_back(frame.file);
    }
    OutputFile out(settings->out, rules);
    std::vector<render::Panel> panels;
    for (const std::string& folder : settings->folders) {
      for (render::Panel& panel : panels_of(folder, *settings)) panels.push_back(std::move(panel));
    }
    out.fill(encode_png(render::contact_sheet(panels, settings->count)));
    const size_t runs = settings->folders.size();
    std::printf("%s: %zu frames of %zu %s\n", settings->out.c_str(), panels.size(), runs,
                runs == 1 ? "run" : "runs");
  });
}

}  // namespace seam::tools
