// `seam import mrcal`: .vnl corners and .cameramodel, with its optimization inputs where it has
// them.
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <set>

#include "app/import/draft/calibration.h"
#include "app/import/draft/points_draft.h"
#include "app/import/files/npz.h"
#include "app/import/files/python_literal.h"
#include "app/import/files/source_file.h"
#include "app/import/files/text_table.h"
#include "app/import/kinds/kinds.h"
#include "effects/questions.h"
#include "effects/registry.h"
#include "effects/stages/spline_grid.h"
#include "sim_core/base/error.h"

namespace seam::app {
namespace {

using nlohmann::json;

struct CameraModel {
  std::string file;
  PlainCamera camera;
  bool known_lens = true;
  std::string splines;  // The effect's line, of a lens of splines that is in the catalogue.
  std::string inputs;   // Packed; empty: none.
  size_t index = 0;     // Of this camera in them.
};

std::vector<double> numbers(const json& model, const char* key, const std::string& file) {
  if (!model.contains(key) || !model[key].is_array())
    throw InputError(fmt::format("{}: '{}' is missing, expected a list of numbers", file, key));
  std::vector<double> values;
  for (const json& value : model[key]) {
    if (!value.is_number())
      throw InputError(fmt::format("{}: {}: found {}, expected a number", file, key, value.dump()));
    values.push_back(value.get<double>());
  }
  return values;
}

// The line of the catalogue's lens of splines where the file's control points are as many as its
// own; empty: another lens.
std::string splines_of(std::string_view name, const std::vector<double>& moved) {
  using namespace effects;
  const std::string form =
      fmt::format("LENSMODEL_SPLINED_STEREOGRAPHIC_order=3_Nx={}_Ny={}_fov_x_deg=", kSplineColumns,
                  kSplineRows);
  if (!name.starts_with(form)) return "";
  const std::string_view after = name.substr(form.size());
  int fov_deg = 0;
  const auto [end, error] = std::from_chars(after.data(), after.data() + after.size(), fov_deg);
  if (error != std::errc() || end != after.data() + after.size()) return "";
  const auto& all = catalogue();
  const auto found =
      std::find_if(all.begin(), all.end(), [](const auto& one) { return is_any_lens(*one); });
  if (found == all.end()) return "";
  const EffectDefinition& effect = **found;
  std::vector<double> values = {static_cast<double>(fov_deg)};
  values.insert(values.end(), moved.begin(), moved.end());
  if (values.size() != effect.parameters.size()) return "";
  std::string line;
  for (size_t i = 0; i < values.size(); ++i) {
    const Parameter& parameter = effect.parameters[i];
    if (!(values[i] >= parameter.min && values[i] <= parameter.max)) return "";
    line += fmt::format("{}{}: {}", line.empty() ? "" : ", ", parameter.name, exact(values[i]));
  }
  return fmt::format("  {}: {{{}}}\n", effect.name, line);
}

CameraModel read_model(const std::filesystem::path& path, SetDraft& draft) {
  CameraModel found{.file = path.string()};
  const json model = python_literal(read_source(path), found.file);
  if (!model.is_object() || !model.contains("lensmodel") || !model["lensmodel"].is_string())
    throw InputError(
        fmt::format("{}: 'lensmodel' is missing, expected a .cameramodel", found.file));
  const auto name = model["lensmodel"].get<std::string>();
  const auto k = numbers(model, "intrinsics", found.file);
  const auto size = numbers(model, "imagersize", found.file);
  if (k.size() < 4 || size.size() != 2)
    throw InputError(fmt::format(
        "{}: found {} intrinsics and {} numbers of imagersize, expected 4 or more and 2",
        found.file, k.size(), size.size()));
  PlainCamera& camera = found.camera;
  camera.width_px = static_cast<int>(size[0]), camera.height_px = static_cast<int>(size[1]);
  camera.lens.fx_px = k[0], camera.lens.fy_px = k[1];
  camera.lens.cx_px = k[2], camera.lens.cy_px = k[3];
  const std::vector<double> rest(k.begin() + 4, k.end());
  if (name == "LENSMODEL_PINHOLE" || name.starts_with("LENSMODEL_OPENCV")) {
    take_coefficients(rest, false, found.file + ": " + name, camera.lens, draft);
  } else {
    // Splined, stereographic, CAHVOR: near the axis all are alike.
    found.known_lens = false;
    found.splines = splines_of(name, rest);
  }
  check_camera(camera, found.file);
  if (model.contains("optimization_inputs") && model["optimization_inputs"].is_string())
    found.inputs = model["optimization_inputs"].get<std::string>();
  if (model.contains("icam_intrinsics") && model["icam_intrinsics"].is_number())
    found.index = static_cast<size_t>(std::max(0.0, model["icam_intrinsics"].get<double>()));
  if (!found.known_lens && found.splines.empty())
    draft.warn(
        fmt::format("{}: {} is no lens of the catalogue: what it says beside focal lengths "
                    "and centre is left out",
                    found.file, name));
  return found;
}

// A camera whose numbers are starts, with a lens that sees wide where the file's does.
std::string free_fisheye(const PlainCamera& camera) {
  const Lens& l = camera.lens;
  return fmt::format(
      "  pinhole: {{fx_px: {{value: {}, free: true}}, fy_px: {{value: {}, free: true}}, cx_px: "
      "{{value: {}, free: true}}, cy_px: {{value: {}, free: true}}}}\n"
      "  fisheye: {{k1: {{value: 0.08, free: true}}, k2: {{value: 0, free: true}}}}\n",
      exact(l.fx_px), exact(l.fy_px), exact(l.cx_px), exact(l.cy_px));
}

std::vector<SeenView> views_of_inputs(const CameraModel& model, SetDraft& draft) {
  const std::string where = model.file + ": optimization_inputs";
  const auto arrays = read_npz(base85_decoded(model.inputs, where), where);
  const auto get = [&](const char* name) -> const NpyArray& {
    const auto found = arrays.find(name);
    if (found == arrays.end() || found->second.values.empty())
      throw InputError(fmt::format("{}: {} is missing", where, name));
    return found->second;
  };
  const NpyArray& seen = get("observations_board");
  const NpyArray& indices = get("indices_frame_camintrinsics_camextrinsics");
  const double spacing = get("calibration_object_spacing").values[0];
  if (seen.shape.size() != 4 || seen.size(3) != 3 || indices.size(0) != seen.size(0) ||
      indices.size(1) != 3)
    throw InputError(fmt::format("{}: observations_board and its indices do not fit", where));
  const auto board = board_points(static_cast<int>(seen.size(2)), static_cast<int>(seen.size(1)),
                                  spacing, spacing);
  std::vector<SeenView> views;
  size_t outliers = 0;
  for (size_t i = 0; i < seen.size(0); ++i) {
    if (indices.values[3 * i + 1] != static_cast<double>(model.index)) continue;
    SeenView view{.name = fmt::format("{:g}", indices.values[3 * i])};
    for (size_t p = 0; p < board.size(); ++p) {
      const double* corner = &seen.values[3 * (i * board.size() + p)];
      if (!(corner[2] > 0)) {
        ++outliers;
        continue;
      }
      if (!std::isfinite(corner[0]) || !std::isfinite(corner[1]))
        throw InputError(fmt::format("{}: observation {}: found no finite corner", where, i));
      view.corners.push_back({.point = p,
                              .p_W = board[p],
                              .u_px = corner[0],
                              .v_px = corner[1],
                              .weight = corner[2] * corner[2]});
    }
    views.push_back(std::move(view));
  }
  if (outliers > 0) draft.did(fmt::format("{} corners that mrcal left out are left out", outliers));
  if (views.empty())
    throw InputError(fmt::format("{}: holds no observation of camera {}", where, model.index));
  return views;
}

// The part of a name that names the camera: frame000-cam1.jpg.
std::string camera_in(const std::string& name) {
  const size_t at = name.rfind("cam");
  if (at == std::string::npos) return "";
  size_t end = at + 3;
  while (end < name.size() && (std::isdigit(static_cast<unsigned char>(name[end])) != 0)) ++end;
  return end > at + 3 ? name.substr(at, end - at) : "";
}

// The cameras of all these pictures: by their names, or by folders that hold pictures of the same
// names (left/0001.png, right/0001.png).
std::set<std::string> cameras_of(const std::set<std::string>& pictures) {
  std::set<std::string> cameras, folders, names;
  for (const std::string& picture : pictures) {
    const size_t slash = picture.rfind('/');
    folders.insert(slash == std::string::npos ? "" : picture.substr(0, slash + 1));
    names.insert(slash == std::string::npos ? picture : picture.substr(slash + 1));
    cameras.insert(camera_in(picture));
  }
  return cameras.size() == 1 && names.size() < pictures.size() ? folders : cameras;
}

struct VnlColumns {
  size_t name, x, y;
  int level;
};

VnlColumns columns_of(const TextTable& table) {
  const int name = table.find({"filename", "file", "image"}), x = table.find({"x", "u"}),
            y = table.find({"y", "v"});
  if (name < 0 || x < 0 || y < 0)
    throw InputError(
        fmt::format("{}: expected a line '# filename x y level' above the corners", table.file()));
  return {static_cast<size_t>(name), static_cast<size_t>(x), static_cast<size_t>(y),
          table.find({"level", "weight"})};
}

std::vector<SeenView> views_of_corners(const TextTable& table, const ImportRequest& request,
                                       SetDraft& draft) {
  const VnlColumns columns = columns_of(table);
  const bool weights = table.find({"weight"}) >= 0;
  const auto board = board_of(request, table.file());
  std::set<std::string> pictures;
  for (size_t row = 0; row < table.rows(); ++row) pictures.emplace(table.cell(row, columns.name));
  const auto cameras = cameras_of(pictures);
  std::string wanted = request.camera;
  if (wanted.empty() && cameras.size() > 1) {
    wanted = *cameras.begin();
    draft.did(fmt::format("of the cameras {} the first, {} (--camera)", fmt::join(cameras, ", "),
                          wanted));
  }
  std::vector<SeenView> views;
  std::map<std::string, std::pair<size_t, size_t>> place;  // Of a file: its view, its next corner.
  size_t missing = 0;
  std::set<std::string> blind;
  for (size_t row = 0; row < table.rows(); ++row) {
    const std::string name(table.cell(row, columns.name));
    if (!wanted.empty() && name.find(wanted) == std::string::npos) continue;
    if (table.cell(row, columns.x) == "-" && !place.contains(name) &&
        (row + 1 == table.rows() || table.cell(row + 1, columns.name) != name)) {
      blind.insert(name);  // A picture without a board has one line.
      continue;
    }
    const auto [found, is_new] = place.try_emplace(name, views.size(), 0);
    if (is_new) views.push_back({.name = name});
    auto& [view, point] = found->second;
    if (point >= board.size())
      table.fail(row, columns.name,
                 fmt::format("{} corners a picture, as --board says", board.size()));
    const double u = table.number_or_blank(row, columns.x),
                 v = table.number_or_blank(row, columns.y);
    const double level =
        columns.level < 0 ? 0 : table.number_or_blank(row, static_cast<size_t>(columns.level));
    const size_t here = point++;
    const double weight = columns.level < 0 || std::isnan(level) ? 1
                          : weights                              ? level
                                                                 : std::pow(0.5, level);
    if (std::isnan(u) || std::isnan(v) || !(weight > 0) || (!weights && level < 0)) {
      ++missing;
      continue;
    }
    // mrcal's weights divide the deviation.
    views[view].corners.push_back(
        {.point = here, .p_W = board[here], .u_px = u, .v_px = v, .weight = weight * weight});
  }
  for (const auto& [name, counted] : place) {
    if (counted.second != board.size())
      throw InputError(fmt::format("{}: {} has {} corners, expected the {} of --board",
                                   table.file(), name, counted.second, board.size()));
  }
  if (views.empty())
    throw InputError(fmt::format("{}: found no corners{}", table.file(),
                                 wanted.empty() ? "" : " of camera " + wanted));
  if (missing > 0) draft.did(fmt::format("{} corners were not seen ('-'): left out", missing));
  if (!blind.empty()) draft.did(fmt::format("{} pictures show no board: left out", blind.size()));
  if (columns.level >= 0 && !weights)
    draft.did("corners found at a level of the pyramid below have 2^level times the deviation");
  return views;
}

}  // namespace

void import_mrcal(const ImportRequest& request, SetDraft& draft) {
  std::optional<CameraModel> model;
  std::optional<TextTable> table;
  for (const auto& source : request.sources) {
    if (source.extension() == ".cameramodel") {
      if (model) throw UsageError("mrcal: expected one .cameramodel: a set has one camera");
      model = read_model(source, draft);
    } else {
      if (table) throw UsageError("mrcal: expected one .vnl");
      table = TextTable::read(source);
    }
  }
  if (model) {
    draft.camera.width_px = model->camera.width_px,
    draft.camera.height_px = model->camera.height_px;
  } else if (request.width_px > 0) {
    draft.camera.width_px = request.width_px, draft.camera.height_px = request.height_px;
  } else {
    throw UsageError("mrcal: corners do not say the size of the images: --size WIDTHxHEIGHT");
  }
  const PlainCamera* camera = model && model->known_lens ? &model->camera : nullptr;
  if (table) {
    draft_views(views_of_corners(*table, request, draft), false, camera, table->file(), draft);
  } else if (!model->inputs.empty()) {
    draft_views(views_of_inputs(*model, draft), false, camera, model->file, draft);
  } else {
    draft_protocol({model->camera}, request, draft);
    draft.could_not_know("what it was calibrated from: the model has no optimization_inputs");
  }
  if (!model || model->known_lens) return;
  const Lens& lens = model->camera.lens;
  if (!model->splines.empty()) {
    draft.effects =
        fmt::format("  pinhole: {{fx_px: {}, fy_px: {}, cx_px: {}, cy_px: {}}}\n",
                    exact(lens.fx_px), exact(lens.fy_px), exact(lens.cx_px), exact(lens.cy_px)) +
        model->splines;
    draft.did_instead("the nominal model is the calibration as it stands, a lens of splines");
    return;
  }
  draft.effects = free_fisheye(model->camera);
  draft.did_instead(
      "the nominal model has the file's focal lengths and centre and a fisheye, all free");
}

}  // namespace seam::app
