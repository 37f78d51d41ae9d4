#include "measurement/kinds/kinds.h"

#include <fmt/ranges.h>

#include <algorithm>

#include "measurement/kinds/beginnings.h"
#include "sim_core/base/error.h"
#include "sim_core/input/file_names.h"

// One line a kind; `measurement/kinds/<name>/<name>.cc` defines <name>_kind().
#define SEAM_KINDS(X) \
  X(points)           \
  X(photometry)       \
  X(landmarks)        \
  X(joints)           \
  X(odometry)         \
  X(ranges)           \
  X(frames)           \
  X(outcomes)         \
  X(imu)

namespace seam::measurement {

#define SEAM_DECLARE(name) Kind name##_kind();
SEAM_KINDS(SEAM_DECLARE)
#undef SEAM_DECLARE

const Kind& find_kind(const std::string& name) {
  static const std::vector<Kind> all = {
#define SEAM_LIST(name) name##_kind(),
      SEAM_KINDS(SEAM_LIST)
#undef SEAM_LIST
  };
  for (const Kind& kind : all) {
    if (name == effects::kind_facts(kind.bit).name) return kind;
  }
  throw InputError(fmt::format("measurement sets of kind '{}' are not supported", name));
}

std::unique_ptr<Problem> open_problem(const std::filesystem::path& path,
                                      const Instruments& instruments,
                                      const std::filesystem::path& target) {
  MeasurementSet set = MeasurementSet::open(path);
  set.target = target;
  return open_problem(std::move(set), instruments);
}

MeasurementSet open_set(const std::filesystem::path& folder,
                        const std::filesystem::path& left_out) {
  MeasurementSet set = MeasurementSet::open(folder);
  if (!left_out.empty())
    set.left_out = read_left_out(left_out, set, find_kind(set.kind).observations.file);
  return set;
}

std::unique_ptr<Problem> open_problem(MeasurementSet set, const Instruments& instruments) {
  const Kind& kind = find_kind(set.kind);
  if (!set.target.empty() && kind.bit != effects::kPoints)
    throw InputError(fmt::format("{}: a target file belongs to sets of points, found kind {}",
                                 set.target.string(), set.kind));
  if (is_protocol(set, kind.observations))
    throw InputError(fmt::format(
        "{}: a protocol, in which nothing is measured yet: found no column {}, expected measured "
        "values; seam measure makes them by a model",
        set.folder.string(), fmt::join(kind.observations.measured, ", ")));
  const Concerns concerns = concerns_of(set, kind.observations);
  if (!concerns.errors.empty())
    throw InputError(fmt::format("{}", fmt::join(concerns.errors, "\n")));
  std::unique_ptr<Problem> problem = kind.open(set, instruments);
  problem->say_left_out(set.left_out);
  add_beginnings(kind, std::move(set), instruments, *problem);
  return problem;
}

void measure_set(const Model& truth, const MeasurementSet& protocol, const MeasureOptions& options,
                 const Instruments& instruments) {
  find_kind(protocol.kind).measure(truth, protocol, options, instruments);
}

std::vector<char> left_blank(const CsvTable& table, const std::string& column,
                             const std::vector<std::string>& measured) {
  std::vector<char> blank(table.rows(), 0);
  const bool all_to_be_made =
      std::all_of(measured.begin(), measured.end(), [&](const std::string& name) {
        if (!table.has(name)) return false;
        const std::vector<std::string> cells = table.texts(name);
        return std::all_of(cells.begin(), cells.end(),
                           [](const std::string& cell) { return cell.empty(); });
      });
  if (all_to_be_made || !table.has(column)) return blank;
  for (size_t row = 0; row < table.rows(); ++row) blank[row] = table.cell(row, column).empty();
  return blank;
}

void copy_protocol(const MeasurementSet& protocol, const std::filesystem::path& out,
                   const std::vector<std::string>& except_files) {
  namespace fs = std::filesystem;
  fs::create_directories(out);
  if (fs::equivalent(out, protocol.folder)) {
    throw InputError(
        fmt::format("{}: the protocol itself, expected another folder to write to", out.string()));
  }
  fs::copy_file(protocol.root.file(), written_path(out, "measurement.yaml"),
                fs::copy_options::overwrite_existing);
  for (const auto& [name, relative] : protocol.files) {
    if (std::find(except_files.begin(), except_files.end(), name) != except_files.end()) continue;
    copy_into(out, protocol, relative);
  }
  // A rig's poses may be named by their file alone.
  const auto rig = protocol.root.find("rig");
  const auto poses = rig && rig->is_map() ? rig->find("poses") : std::nullopt;
  if (poses && !protocol.has_file(poses->text())) copy_into(out, protocol, poses->text());
}

void copy_into(const std::filesystem::path& out, const MeasurementSet& protocol,
               const std::string& name) {
  std::filesystem::copy_file(path_inside(protocol.folder, name), written_path(out, name),
                             std::filesystem::copy_options::overwrite_existing);
}

std::filesystem::path written_path(const std::filesystem::path& out, const std::string& name) {
  const std::filesystem::path path = path_inside(out, name);
  std::filesystem::create_directories(path.parent_path());
  return path;
}

}  // namespace seam::measurement
