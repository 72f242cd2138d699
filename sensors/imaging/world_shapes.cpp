#include "sensors/imaging/world_shapes.h"

#include <algorithm>

#include "sensors/imaging/ground_texture.h"

namespace skybody::sensor {
namespace {

using render::Color;
using render::Label;
using render::PlacedShape;
using render::Solid;

constexpr int kPoseValues = 7;       ///< position, quaternion
constexpr int kMotionValues = 6;     ///< velocity, angular velocity, W axes
constexpr int kObstacleValues = 11;  ///< presence, position, quaternion, size
/// Limit of shapes; the renderer numbers parts of shapes by 16 bits.
constexpr int kMostShapes = 20000;
constexpr int kMostTriangles = 60000;  // of all meshes, likewise

constexpr std::uint16_t kGroundInstance = 1;
constexpr std::uint16_t kFirstRobotInstance = 2;

Vec3<double> vec3_at(const double* p) { return {p[0], p[1], p[2]}; }
Quat<double> quat_at(const double* p) { return {p[0], p[1], p[2], p[3]}; }

Solid solid_of(int kind) {
  switch (kind) {
    case SKYBODY_BOX:
    case SKYBODY_GATE:
      return Solid::kBox;
    case SKYBODY_CYLINDER:
      return Solid::kCylinder;
    case SKYBODY_CAPSULE:
      return Solid::kCapsule;
    case SKYBODY_PLANE:
      return Solid::kPlane;
    case SKYBODY_MESH:
    case SKYBODY_HEIGHT_FIELD:
      return Solid::kMesh;
    default:
      return Solid::kSphere;
  }
}

/// PlacedShape::half from the sizes of a SkybodyShapeKind.
Vec3<double> half_of(Solid solid, const Vec3<double>& size) {
  if (solid == Solid::kBox) return size * 0.5;
  return {size.x, size.x, 0.5 * size.y};
}

Color color_of(int kind) {
  switch (kind) {
    case SKYBODY_GATE:
      return {0.9f, 0.35f, 0.08f};
    case SKYBODY_CYLINDER:
      return {0.45f, 0.3f, 0.18f};
    case SKYBODY_CAPSULE:
      return {0.25f, 0.42f, 0.2f};
    case SKYBODY_SPHERE:
      return {0.2f, 0.4f, 0.65f};
    default:
      return {0.6f, 0.52f, 0.42f};
  }
}

render::Paint paint_of_ground() { return {{0.4f, 0.43f, 0.4f}, {0.58f, 0.6f, 0.56f}, 1.0f}; }

}  // namespace

WorldShapes::WorldShapes(const Setup& setup, int mount, int hidden_robot, bool has_ground,
                         const Draws& draws)
    : has_ground_(has_ground), draws_(draws), most_(has_ground ? 1 : 0) {
  list_body(mount);
  add_visuals(setup, hidden_robot);
  add_obstacles(setup);
  if (most_ > kMostShapes) {
    refuse("the scenario has ", most_, " shapes to draw; at most ", kMostShapes);
  }
}

std::size_t WorldShapes::list_body(int body) {
  const auto found = std::find(bodies_.begin(), bodies_.end(), body);
  if (found != bodies_.end()) return static_cast<std::size_t>(found - bodies_.begin());
  bodies_.push_back(body);
  return bodies_.size() - 1;
}

void WorldShapes::add_visuals(const Setup& setup, int hidden_robot) {
  for (int i = 0; i < setup.visuals().size(); ++i) {
    const VisualInfo& visual = setup.visuals()[i];
    const ShapeInfo& info = visual.shape;
    if (info.robot == hidden_robot) continue;
    PlacedShape shape;
    shape.solid = solid_of(info.kind);
    if (shape.solid == Solid::kMesh) {
      shape.mesh = add_mesh(setup.visual_triangles(i), vec3_at(info.size));
    } else {
      shape.half = half_of(shape.solid, vec3_at(info.size));
    }
    shape.position = vec3_at(info.position);
    shape.axes = to_mat3(quat_at(info.rotation));
    shape.instance = static_cast<std::uint16_t>(kFirstRobotInstance + info.robot);
    shape.label = Label::kRobot;
    for (std::size_t k = 0; k < 3; ++k) {
      shape.paint.color[k] = static_cast<float>(visual.color[k]);
    }
    const bool has_place = shape.mesh == nullptr || shape.mesh->texture() != nullptr;
    if (draws_.has_colors && *visual.texture != '\0' && has_place) {
      add_texture(setup, visual, shape.paint);
    }
    const std::size_t body = list_body(info.body);
    shape.body = static_cast<std::int32_t>(body);
    visuals_.push_back({body, shape});
    ++most_;
  }
}

void WorldShapes::add_obstacles(const Setup& setup) {
  int instance = kFirstRobotInstance + setup.robots().size();
  for (const obstacles::Obstacle& obstacle : obstacles::find_with_fields(setup, "the sensor")) {
    const bool is_gate = obstacle.kind == SKYBODY_GATE,
               is_field = obstacle.kind == SKYBODY_HEIGHT_FIELD,
               is_ground = obstacle.kind == SKYBODY_PLANE || is_field;
    PlacedShape shape;
    shape.solid = solid_of(obstacle.kind);
    shape.instance = static_cast<std::uint16_t>(instance++);
    shape.label = is_gate ? Label::kGate : is_ground ? Label::kGround : Label::kObstacle;
    shape.paint.color = color_of(obstacle.kind);
    if (is_ground) shape.paint = paint_of_ground();
    if (is_field) {
      shape.mesh = add_mesh(setup.obstacle_triangles(obstacle.index), {1.0, 1.0, 1.0});
    }
    drawn_obstacles_.push_back({obstacle, shape});
    most_ += is_gate ? obstacles::kBars : 1;
  }
}

const render::Mesh* WorldShapes::add_mesh(const Triangles& triangles, const Vec3<double>& scale) {
  most_triangles_ += triangles.count;
  if (most_triangles_ > kMostTriangles) {
    refuse("the scenario has ", most_triangles_, " triangles to draw, or more; allowed: at most ",
           kMostTriangles, "; use simpler meshes");
  }
  const auto count = static_cast<std::size_t>(triangles.count);
  const std::span corners(triangles.corners, 9 * count);
  const std::span points(triangles.texture, triangles.texture != nullptr ? 6 * count : 0);
  return meshes_.emplace_back(std::make_unique<render::Mesh>(corners, scale, points)).get();
}

void WorldShapes::add_texture(const Setup& setup, const VisualInfo& visual, render::Paint& paint) {
  const auto [found, is_new] = textures_.try_emplace(visual.texture);
  if (is_new) {
    const std::string subject = std::string("the body `") + visual.shape.name + "`";
    found->second = texture_of(setup, visual.texture, subject);
  }
  paint.texture = found->second.get();
  ++most_textured_;
}

int WorldShapes::body_values() const {
  return kPoseValues + (draws_.has_motion ? kMotionValues : 0);
}

int WorldShapes::moment_size() const {
  return body_values() * static_cast<int>(bodies_.size()) +
         kObstacleValues * static_cast<int>(drawn_obstacles_.size());
}

void WorldShapes::capture(const EnvView<double>& env, double* moment) const {
  const auto put = [&moment](auto... values) { ((*moment++ = values), ...); };
  const auto put_pose = [&put](const Vec3<double>& p, const Quat<double>& q) {
    put(p.x, p.y, p.z, q.w, q.x, q.y, q.z);
  };
  for (const int index : bodies_) {
    const BodyMotion<double> body = env.body(index);
    put_pose(body.position, body.rotation);
    if (!draws_.has_motion) continue;
    const Vec3<double> v = body.velocity, w = rotate(body.rotation, body.angular_velocity);
    put(v.x, v.y, v.z, w.x, w.y, w.z);
  }
  for (const DrawnObstacle& drawn : drawn_obstacles_) {
    const obstacles::PlacedObstacle<double> placed = obstacles::place(env, drawn.obstacle);
    put(placed.present ? 1.0 : 0.0);
    put_pose(placed.position, placed.rotation);
    put(placed.size.x, placed.size.y, placed.size.z);
  }
}

void WorldShapes::mount(const double* moment, Vec3<double>& position, Mat3<double>& axes) {
  position = vec3_at(moment);
  axes = to_mat3(quat_at(moment + 3));
}

WorldShapes::Motion WorldShapes::motion(const double* moment, int body) const {
  const double* const values = moment + body_values() * body;
  return {vec3_at(values), vec3_at(values + kPoseValues), vec3_at(values + kPoseValues + 3)};
}

std::span<const PlacedShape> WorldShapes::place(const double* moment, PlacedShape* shapes) const {
  PlacedShape* next = shapes;
  if (has_ground_) {
    PlacedShape ground;
    ground.solid = Solid::kPlane;
    ground.axes = to_mat3(Quat<double>{1.0, 0.0, 0.0, 0.0});
    ground.instance = kGroundInstance;
    ground.label = Label::kGround;
    ground.paint = paint_of_ground();
    *next++ = ground;
  }
  const double* bodies = moment;
  for (const Visual& visual : visuals_) {
    const double* pose = bodies + static_cast<std::size_t>(body_values()) * visual.body;
    const Mat3<double> axes = to_mat3(quat_at(pose + 3));
    *next = visual.shape;
    next->position = vec3_at(pose) + axes * visual.shape.position;
    next->axes = axes * visual.shape.axes;
    ++next;
  }
  const double* values = moment + static_cast<std::size_t>(body_values()) * bodies_.size();
  for (const DrawnObstacle& drawn : drawn_obstacles_) {
    const double* const v = values;
    values += kObstacleValues;
    if (v[0] == 0.0) continue;
    const Vec3<double> position = vec3_at(v + 1), size = vec3_at(v + 8);
    PlacedShape shape = drawn.shape;
    shape.axes = to_mat3(normalized(quat_at(v + 4)));
    if (drawn.obstacle.kind == SKYBODY_GATE) {
      for (int k = 0; k < obstacles::kBars; ++k) {
        const obstacles::Bar<double> bar = obstacles::bar_of_gate(size, k);
        shape.position = position + shape.axes * bar.position;
        shape.half = bar.half;
        *next++ = shape;
      }
      continue;
    }
    shape.position = position;
    shape.half = half_of(shape.solid, size);
    *next++ = shape;
  }
  return {shapes, next};
}

}  // namespace skybody::sensor
