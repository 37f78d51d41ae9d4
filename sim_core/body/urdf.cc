#include "sim_core/body/urdf.h"

#include <fmt/format.h>
#include <tinyxml2.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <functional>
#include <optional>
#include <set>

#include "sim_core/base/error.h"
#include "sim_core/base/files.h"
#include "sim_core/base/maths.h"
#include "sim_core/input/file_names.h"
#include "sim_core/input/shown_text.h"

namespace seam {
namespace {

using tinyxml2::XMLElement;

constexpr size_t kMostBytes = 16 << 20;
constexpr size_t kMostLinks = 256;
// The widest range of a joint, as robot files may have it; a wheel that turns on and on has this.
constexpr double kWidest_rad = 7;
constexpr double kUsualSpeed_radps = 10;  // Of a joint that states none.

double linear(double srgb) {
  return srgb <= 0.04045 ? srgb / 12.92 : maths::exp(2.4 * maths::log((srgb + 0.055) / 1.055));
}

class UrdfReader {
 public:
  UrdfReader(const FileName& file, const std::map<std::string, std::string>& packages)
      : file_(file), packages_(packages), path_(path_inside(file.folder, file.name)) {}

  RobotBody read(const std::string& text) {
    tinyxml2::XMLDocument document;
    if (document.Parse(text.data(), text.size()) != tinyxml2::XML_SUCCESS)
      fail(document.ErrorLineNum(), "found no XML: {}", document.ErrorName());
    const XMLElement* const root = document.RootElement();
    if (!root || std::string_view(root->Name()) != "robot")
      fail(root ? root->GetLineNum() : 1, "found no <robot>, expected a URDF file");
    refuse_xacro(*root);
    body_.name = attribute(*root, "name");
    for (const XMLElement& material : all(*root, "material")) read_material(material);
    for (const XMLElement& joint : all(*root, "joint")) read_joint(joint);
    order_links(*root);
    for (const XMLElement& link : all(*root, "link")) read_link(link);
    body_.mass_kg = std::clamp(mass_kg_, 0.01, 1000.0);
    return std::move(body_);
  }

 private:
  template <typename... Values>
  [[noreturn]] void fail(int line, fmt::format_string<Values...> text, Values&&... values) const {
    throw InputError(fmt::format("{}, line {}: {}", path_.string(), line,
                                 shown(fmt::format(text, std::forward<Values>(values)...))));
  }

  template <typename... Values>
  void note(int line, fmt::format_string<Values...> text, Values&&... values) {
    body_.notes.push_back(fmt::format("{}, line {}: {}", path_.string(), line,
                                      shown(fmt::format(text, std::forward<Values>(values)...))));
  }

  // xacro leaves its namespace on <robot>: only what it would have replaced is unexpanded.
  void refuse_xacro(const XMLElement& element) const {
    const auto refuse = [&](const std::string& found) {
      fail(element.GetLineNum(),
           "found {}, which is xacro, expected URDF: expand it with `xacro FILE`", found);
    };
    if (std::string_view(element.Name()).starts_with("xacro:"))
      refuse(fmt::format("<{}>", element.Name()));
    const auto look = [&](const char* text) {
      for (const char* const opening : {"${", "$("})
        if (text && std::strstr(text, opening)) refuse(fmt::format("'{}'", text));
    };
    for (auto* value = element.FirstAttribute(); value; value = value->Next()) look(value->Value());
    for (auto* node = element.FirstChild(); node; node = node->NextSibling()) {
      if (node->ToText()) look(node->Value());
      if (node->ToElement()) refuse_xacro(*node->ToElement());
    }
  }

  static std::vector<std::reference_wrapper<const XMLElement>> all(const XMLElement& in,
                                                                   const char* name) {
    std::vector<std::reference_wrapper<const XMLElement>> found;
    for (const XMLElement* e = in.FirstChildElement(name); e; e = e->NextSiblingElement(name))
      found.push_back(*e);
    return found;
  }
  std::string attribute(const XMLElement& element, const char* name) const {
    const char* const text = element.Attribute(name);
    if (!text) fail(element.GetLineNum(), "<{}> has no {}", element.Name(), name);
    return text;
  }
  const XMLElement& child(const XMLElement& element, const char* name) const {
    const XMLElement* const found = element.FirstChildElement(name);
    if (!found) fail(element.GetLineNum(), "<{}> has no <{}>", element.Name(), name);
    return *found;
  }

  // `count` numbers of an attribute.
  std::vector<double> numbers(const XMLElement& element, const char* name, size_t count) const {
    const std::string text = attribute(element, name);
    std::vector<double> values;
    const char* at = text.data();
    const char* const end = at + text.size();
    while (true) {
      while (at < end && std::isspace(static_cast<unsigned char>(*at)) != 0) ++at;
      if (at < end && *at == '+') ++at;
      if (at == end) break;
      double value = 0;
      const auto [next, error] = std::from_chars(at, end, value);
      const bool ends = next == end || std::isspace(static_cast<unsigned char>(*next)) != 0;
      if (error != std::errc() || !ends || !std::isfinite(value) || std::abs(value) > 1e6)
        fail(element.GetLineNum(), "{}=\"{}\": expected {} finite numbers", name, text, count);
      values.push_back(value);
      at = next;
    }
    if (values.size() != count)
      fail(element.GetLineNum(), "{}=\"{}\": found {} numbers, expected {}", name, text,
           values.size(), count);
    return values;
  }
  double number(const XMLElement& element, const char* name, double otherwise) const {
    return element.Attribute(name) ? numbers(element, name, 1).front() : otherwise;
  }
  double not_negative(const XMLElement& element, const char* name) const {
    const double value = numbers(element, name, 1).front();
    if (!(value >= 0)) fail(element.GetLineNum(), "{}=\"{}\": expected at least 0", name, value);
    return value;
  }
  Vec3 vector(const XMLElement& element, const char* name, const Vec3& otherwise) const {
    if (!element.Attribute(name)) return otherwise;
    const std::vector<double> v = numbers(element, name, 3);
    return {v[0], v[1], v[2]};
  }
  // Of <origin>: where it is and how it is turned, as far as it says.
  std::pair<Vec3, Vec3> origin(const XMLElement& element) const {
    const XMLElement* const found = element.FirstChildElement("origin");
    if (!found) return {Vec3(0.0), Vec3(0.0)};
    return {vector(*found, "xyz", Vec3(0.0)), vector(*found, "rpy", Vec3(0.0))};
  }

  std::optional<Rgb> colour_of(const XMLElement& material) const {
    const XMLElement* const colour = material.FirstChildElement("color");
    if (!colour) return std::nullopt;
    const std::vector<double> rgba = numbers(*colour, "rgba", 4);
    Rgb rgb;
    for (size_t c = 0; c < 3; ++c) rgb[c] = linear(std::clamp(rgba[c], 0.0, 1.0));
    return rgb;
  }
  void read_material(const XMLElement& material) {
    if (const auto rgb = colour_of(material)) colours_[attribute(material, "name")] = *rgb;
  }

  void read_joint(const XMLElement& joint) {
    TreeLink link;
    link.name = attribute(child(joint, "child"), "link");
    link.parent = attribute(child(joint, "parent"), "link");
    link.joint = attribute(joint, "name");
    std::tie(link.translate_m, link.rotate_rad) = origin(joint);
    const std::string type = attribute(joint, "type");
    const bool turns_on = type == "continuous";
    if (turns_on || type == "revolute")
      link.motion = JointMotion::turn;
    else if (type == "prismatic")
      link.motion = JointMotion::slide;
    else if (type != "fixed")
      fail(joint.GetLineNum(),
           "joint '{}' is of type '{}', expected revolute, continuous, prismatic or fixed",
           link.joint, type);
    if (link.motion != JointMotion::fixed) read_motion(joint, turns_on, link);
    for (const TreeLink& other : hung_) {
      if (other.name == link.name)
        fail(joint.GetLineNum(), "link '{}' hangs on two joints, '{}' and '{}'", link.name,
             other.joint, link.joint);
      if (other.joint == link.joint)
        fail(joint.GetLineNum(), "two joints are called '{}'", link.joint);
    }
    if (hung_.size() >= kMostLinks) fail(joint.GetLineNum(), "more than {} joints", kMostLinks);
    hung_.push_back(std::move(link));
  }

  void read_motion(const XMLElement& joint, bool turns_on, TreeLink& link) const {
    if (const XMLElement* const axis = joint.FirstChildElement("axis"))
      link.axis = vector(*axis, "xyz", link.axis);
    if (const XMLElement* const mimic = joint.FirstChildElement("mimic")) {
      link.mimics = attribute(*mimic, "joint");
      link.mimic_factor = number(*mimic, "multiplier", 1);
      link.mimic_offset_rad = number(*mimic, "offset", 0);
    }
    const XMLElement* const limit = joint.FirstChildElement("limit");
    // Files of other programs write 0 for "not known".
    const double speed =
        limit && limit->Attribute("velocity") ? not_negative(*limit, "velocity") : 0;
    link.limits = {-kWidest_rad, kWidest_rad,
                   speed > 0 ? std::min(speed, 100.0) : kUsualSpeed_radps};
    if (turns_on) return;
    if (!limit) fail(joint.GetLineNum(), "joint '{}' has no <limit>", link.joint);
    const double lower = number(*limit, "lower", 0), upper = number(*limit, "upper", 0);
    if (lower > upper)
      fail(limit->GetLineNum(), "joint '{}': lower {} is above upper {}", link.joint, lower, upper);
    link.limits.min_rad = std::clamp(lower, -kWidest_rad, kWidest_rad);
    link.limits.max_rad = std::clamp(upper, -kWidest_rad, kWidest_rad);
    link.start_rad = std::clamp(0.0, link.limits.min_rad, link.limits.max_rad);
  }

  // The root first, each link's children in the order of their joints in the file.
  void order_links(const XMLElement& robot) {
    std::vector<std::string> names;
    for (const XMLElement& link : all(robot, "link")) names.push_back(attribute(link, "name"));
    const std::set<std::string> known(names.begin(), names.end());
    std::set<std::string> hung;
    for (const TreeLink& link : hung_) {
      for (const std::string& name : {link.name, link.parent})
        if (!known.contains(name))
          fail(robot.GetLineNum(), "joint '{}' names the link '{}', which is not there", link.joint,
               name);
      hung.insert(link.name);
    }
    std::vector<TreeLink>& links = body_.tree.links;
    for (const std::string& name : names) {
      if (hung.contains(name)) continue;
      if (!links.empty())
        fail(robot.GetLineNum(), "links '{}' and '{}' hang on nothing, expected one root",
             links.front().name, name);
      links.push_back({.name = name});
    }
    if (links.empty())
      fail(robot.GetLineNum(), "{}",
           names.empty() ? "found no links" : "the joints go in a circle: no link is the root");
    add_children(0);
    if (links.size() < known.size()) {
      for (const std::string& name : names)
        if (place_of(name) == links.size())
          fail(robot.GetLineNum(), "the joints go in a circle: link '{}' does not hang on '{}'",
               name, links.front().name);
    }
  }
  void add_children(size_t place) {
    const std::string name = body_.tree.links[place].name;
    for (const TreeLink& link : hung_) {
      if (link.parent != name) continue;
      body_.tree.links.push_back(link);
      add_children(body_.tree.links.size() - 1);
    }
  }
  size_t place_of(const std::string& name) const {
    const auto& links = body_.tree.links;
    return static_cast<size_t>(std::find_if(links.begin(), links.end(),
                                            [&](const TreeLink& l) { return l.name == name; }) -
                               links.begin());
  }

  void read_link(const XMLElement& link) {
    const size_t place = place_of(attribute(link, "name"));
    if (const XMLElement* const inertial = link.FirstChildElement("inertial"))
      if (const XMLElement* const mass = inertial->FirstChildElement("mass"))
        mass_kg_ += mass->Attribute("value") ? not_negative(*mass, "value") : 0;
    for (const XMLElement& visual : all(link, "visual")) {
      BodyPart part{.link = place, .paint = Paint::own, .rgb = {0.5, 0.5, 0.5}};
      std::tie(part.centre_m, part.rotate_rad) = origin(visual);
      if (const XMLElement* const material = visual.FirstChildElement("material")) {
        const char* const name = material->Attribute("name");
        if (const auto rgb = colour_of(*material))
          part.rgb = *rgb;
        else if (name && colours_.contains(name))
          part.rgb = colours_.at(name);
      }
      const XMLElement& geometry = child(visual, "geometry");
      if (read_geometry(geometry, part))
        body_.parts.push_back(std::move(part));
      else
        note(geometry.GetLineNum(), "the shape of link '{}' has no volume and is left out",
             body_.tree.links[place].name);
    }
  }

  // False where it has no volume: a placeholder, which viewers do not draw either.
  bool read_geometry(const XMLElement& geometry, BodyPart& part) {
    if (const XMLElement* const box = geometry.FirstChildElement("box")) {
      part.shape = Shape::box;
      const std::vector<double> edges = numbers(*box, "size", 3);
      const double least = *std::min_element(edges.begin(), edges.end());
      if (least < 0)
        fail(box->GetLineNum(), "<box> with an edge of {}, expected at least 0", least);
      part.size_m = {edges[0], edges[1], edges[2]};
      return least > 0;
    } else if (const XMLElement* const sphere = geometry.FirstChildElement("sphere")) {
      part.shape = Shape::sphere;
      part.size_m = {not_negative(*sphere, "radius"), 0, 0};
      return part.size_m.x > 0;
    } else if (const XMLElement* const cylinder = geometry.FirstChildElement("cylinder")) {
      part.shape = Shape::cylinder;
      part.size_m = {not_negative(*cylinder, "radius"), 0, not_negative(*cylinder, "length")};
      // Of a URDF's cylinder the origin is the middle.
      const Mat3 R = rotation_zyx(part.rotate_rad.x, part.rotate_rad.y, part.rotate_rad.z);
      part.centre_m -= 0.5 * part.size_m.z * R[2];
      return part.size_m.x > 0 && part.size_m.z > 0;
    } else if (const XMLElement* const mesh = geometry.FirstChildElement("mesh")) {
      part.shape = Shape::mesh;
      return read_mesh(*mesh, part);
    }
    fail(geometry.GetLineNum(), "<geometry> has no box, cylinder, sphere or mesh");
  }

  bool read_mesh(const XMLElement& mesh, BodyPart& part) const {
    const Vec3 scale = vector(mesh, "scale", Vec3(1.0));
    if (scale.x == 0 || scale.y == 0 || scale.z == 0) return false;
    if (!(scale.x > 0) || scale.y != scale.x || scale.z != scale.x)
      fail(mesh.GetLineNum(),
           "scale=\"{} {} {}\": expected the same number of more than 0 along each axis", scale.x,
           scale.y, scale.z);
    part.scale = scale.x;
    const std::string address = attribute(mesh, "filename");
    part.mesh = {mesh_name(mesh, address), file_.folder, ""};
    const std::string why = why_not_inside(file_.folder, part.mesh.name);
    if (!why.empty()) fail(mesh.GetLineNum(), "mesh '{}': {}", address, why);
    if (!std::filesystem::is_regular_file(std::filesystem::path(file_.folder) / part.mesh.name))
      fail(mesh.GetLineNum(), "mesh '{}': found no file '{}' in {}", address, part.mesh.name,
           file_.folder);
    // What is in the colours of its own file stays so.
    if (!part.mesh.name.ends_with(".stl") && !part.mesh.name.ends_with(".STL"))
      part.rgb = {1, 1, 1};
    return true;
  }

  // Relative to the folder.
  std::string mesh_name(const XMLElement& mesh, const std::string& address) const {
    constexpr std::string_view kPackage = "package://";
    std::filesystem::path path;
    if (address.starts_with(kPackage)) {
      const size_t end = address.find('/', kPackage.size());
      const std::string package = address.substr(kPackage.size(), end - kPackage.size());
      const auto found = packages_.find(package);
      if (end == std::string::npos || found == packages_.end())
        fail(mesh.GetLineNum(),
             "mesh '{}': no folder is known for the package '{}', expected it under packages: "
             "{{{}: FOLDER}}",
             address, package, package);
      path = std::filesystem::path(found->second) / address.substr(end + 1);
    } else {
      if (address.find("://") != std::string::npos)
        fail(mesh.GetLineNum(), "mesh '{}': expected a path or package://NAME/PATH", address);
      path = std::filesystem::path(file_.name).parent_path() / address;
    }
    return path.lexically_normal().string();
  }

  const FileName& file_;
  const std::map<std::string, std::string>& packages_;
  const std::filesystem::path path_;
  RobotBody body_;
  double mass_kg_ = 0;
  std::map<std::string, Rgb> colours_;
  std::vector<TreeLink> hung_;  // Links with their joints, in the order of the joints.
};

}  // namespace

RobotBody body_from_urdf(const std::string& text, const FileName& file,
                         const std::map<std::string, std::string>& packages) {
  return UrdfReader(file, packages).read(text);
}

RobotBody body_from_urdf(const FileName& file, const std::map<std::string, std::string>& packages) {
  return body_from_urdf(read_file(path_inside(file.folder, file.name), kMostBytes), file, packages);
}

}  // namespace seam
