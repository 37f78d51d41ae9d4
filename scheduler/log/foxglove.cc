#include "scheduler/log/foxglove.h"

#include <glm/gtc/quaternion.hpp>
#include <map>

#include "foxglove/image.pb.h"
#include "foxglove/scene.pb.h"
#include "foxglove/transforms.pb.h"
#include "sim_core/base/error.h"
#include "sim_core/base/maths.h"

namespace seam::scheduler {
namespace {

void set(google::protobuf::Timestamp* stamp, SimTime time) {
  // Seconds round down, so that nanoseconds are never negative.
  constexpr int64_t kSecond = 1'000'000'000;
  const int64_t seconds = time.ns() / kSecond - (time.ns() % kSecond < 0 ? 1 : 0);
  stamp->set_seconds(seconds);
  stamp->set_nanos(static_cast<int32_t>(time.ns() - seconds * kSecond));
}

void set(foxglove::Vector3* vector, const Vec3& value) {
  vector->set_x(value.x);
  vector->set_y(value.y);
  vector->set_z(value.z);
}

void set(foxglove::Quaternion* quaternion, const Mat3& rotation) {
  const glm::dquat q = glm::quat_cast(rotation);
  quaternion->set_x(q.x);
  quaternion->set_y(q.y);
  quaternion->set_z(q.z);
  quaternion->set_w(q.w);
}

void set(foxglove::Pose* pose, const Pose& X) {
  set(pose->mutable_position(), X.p);
  set(pose->mutable_orientation(), X.R);
}

// Screens expect sRGB; radiance is linear.
void set(foxglove::Color* color, const Rgb& radiance) {
  const auto display = [](double value) {
    return maths::pow(std::clamp(value, 0.0, 1.0), 1 / 2.2);
  };
  color->set_r(display(radiance[0]));
  color->set_g(display(radiance[1]));
  color->set_b(display(radiance[2]));
  color->set_a(1);
}

bool moves(const Primitive& primitive) {
  switch (primitive.label) {
    case Label::ball:
    case Label::robot_red:
    case Label::robot_blue:
    case Label::robot_body:
    case Label::other:
      return true;
    default:
      return false;
  }
}

void add_sphere(foxglove::SceneEntity& entity, const Pose& X_W, double radius_m, const Rgb& rgb) {
  foxglove::SpherePrimitive* sphere = entity.add_spheres();
  set(sphere->mutable_pose(), X_W);
  set(sphere->mutable_size(), Vec3(2 * radius_m));
  set(sphere->mutable_color(), rgb);
}

void add_cylinder(foxglove::SceneEntity& entity, const Primitive& primitive) {
  foxglove::CylinderPrimitive* cylinder = entity.add_cylinders();
  set(cylinder->mutable_pose(), primitive.X_WO * translation({0, 0, 0.5 * primitive.size.z}));
  set(cylinder->mutable_size(), Vec3(2 * primitive.size.x, 2 * primitive.size.x, primitive.size.z));
  cylinder->set_bottom_scale(1);
  cylinder->set_top_scale(1);
  set(cylinder->mutable_color(), primitive.rgb);
}

void add_box(foxglove::SceneEntity& entity, const Primitive& primitive, const Vec3& size_m) {
  foxglove::CubePrimitive* cube = entity.add_cubes();
  set(cube->mutable_pose(), primitive.X_WO);
  set(cube->mutable_size(), size_m);
  set(cube->mutable_color(), primitive.rgb);
}

void add(foxglove::SceneEntity& entity, const Primitive& primitive) {
  switch (primitive.shape) {
    case Shape::rectangle:
      return add_box(entity, primitive, {primitive.size.x, primitive.size.y, 0.001});
    case Shape::box:
      return add_box(entity, primitive, primitive.size);
    case Shape::sphere:
      return add_sphere(entity, primitive.X_WO, primitive.size.x, primitive.rgb);
    case Shape::cylinder:
      return add_cylinder(entity, primitive);
    case Shape::capsule:
      add_cylinder(entity, primitive);
      add_sphere(entity, primitive.X_WO, primitive.size.x, primitive.rgb);
      return add_sphere(entity, primitive.X_WO * translation({0, 0, primitive.size.z}),
                        primitive.size.x, primitive.rgb);
    case Shape::mesh:  // Its file stays with whoever has the scenario.
      return;
  }
}

void add_transform(foxglove::FrameTransforms& transforms, SimTime time, const std::string& parent,
                   const std::string& child, const Pose& X) {
  foxglove::FrameTransform* transform = transforms.add_transforms();
  set(transform->mutable_timestamp(), time);
  transform->set_parent_frame_id(parent);
  transform->set_child_frame_id(child);
  set(transform->mutable_translation(), X.p);
  set(transform->mutable_rotation(), X.R);
}

}  // namespace

std::string compressed_image(SimTime time, const std::string& frame_id, std::string png) {
  foxglove::CompressedImage image;
  set(image.mutable_timestamp(), time);
  image.set_frame_id(frame_id);
  image.set_format("png");
  image.set_data(std::move(png));
  return image.SerializeAsString();
}

std::string picture_of(std::string_view bytes) {
  foxglove::CompressedImage image;
  if (!image.ParseFromArray(bytes.data(), static_cast<int>(bytes.size())) ||
      image.format() != "png") {
    throw InputError("found bytes that are no foxglove.CompressedImage with a PNG");
  }
  return std::move(*image.mutable_data());
}

std::string frame_transforms(const World& world, SimTime time) {
  foxglove::FrameTransforms transforms;
  for (size_t robot = 0; robot < world.scenario().robots.size(); ++robot) {
    const std::string& id = world.scenario().robots[robot].id;
    add_transform(transforms, time, "world", id, world.robot(robot, time).X_WB);
    const Pose X_WC = world.camera_link_pose(robot, time) * rotation(link_to_camera_axes());
    add_transform(transforms, time, "world", id + "/camera", X_WC);
  }
  return transforms.SerializeAsString();
}

std::string scene_update(const World& world, SimTime time, bool all) {
  std::vector<Primitive> primitives;
  world.primitives_at(time, primitives);
  std::map<uint16_t, foxglove::SceneEntity> entities;  // By object.
  for (const Primitive& primitive : primitives) {
    if (!all && !moves(primitive)) continue;
    foxglove::SceneEntity& entity = entities[primitive.object_id];
    set(entity.mutable_timestamp(), time);
    entity.set_frame_id("world");
    entity.set_id("object-" + std::to_string(primitive.object_id));
    add(entity, primitive);
  }
  foxglove::SceneUpdate update;
  for (auto& [id, entity] : entities) update.add_entities()->Swap(&entity);
  return update.SerializeAsString();
}

}  // namespace seam::scheduler
