// The shapes of a scenario at the poses of an environment, for the renderer.
#pragma once

#include <skybody/plugin.h>

#include <map>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "plugins/obstacles/placed.h"
#include "render/mesh.h"
#include "render/renderer.h"
#include "render/texture.h"

namespace skybody::sensor {

/// Shapes of robots and obstacles, and the ground. Immutable.
///
/// A moment holds the values that place them: of each listed body its position and quaternion, and
/// its velocities if wanted; of each obstacle its presence, position, quaternion and size.
class WorldShapes {
 public:
  /// A listed body's motion: W axes, velocity of its origin [m/s], angular velocity [rad/s].
  struct Motion {
    Vec3<double> position, velocity, angular_velocity;
  };

  /// What is needed to draw.
  struct Draws {
    bool has_colors = false;  ///< shapes have their textures
    bool has_motion = false;  ///< moments hold velocities
  };

  /// @param mount         world body that carries the camera
  /// @param hidden_robot  robot that is not drawn; -1: none
  /// @throws std::runtime_error for meshes and textures that cannot be drawn, and for too many
  ///   shapes
  WorldShapes(const Setup& setup, int mount, int hidden_robot, bool has_ground, const Draws& draws);

  /// Most shapes of an environment.
  int most() const { return most_; }
  /// The same, and their triangles.
  render::Capacity capacity() const { return {most_, most_triangles_, most_textured_}; }
  /// Doubles of a moment.
  int moment_size() const;
  /// Reads the moment of an environment.
  void capture(const EnvView<double>& env, double* moment) const;
  /// Position and axes (W from body) of the body that carries the camera.
  static void mount(const double* moment, Vec3<double>& position, Mat3<double>& axes);
  /// Motion of a listed body: PlacedShape::body, or 0, which carries the camera. Needs has_motion.
  Motion motion(const double* moment, int body) const;
  /// Writes the shapes that are present. @param shapes  most() places @returns the written ones
  std::span<const render::PlacedShape> place(const double* moment,
                                             render::PlacedShape* shapes) const;

 private:
  /// A shape of a body; its pose is in the body's frame.
  struct Visual {
    std::size_t body;  ///< index in bodies_
    render::PlacedShape shape;
  };
  /// An obstacle with the properties of its shapes.
  struct DrawnObstacle {
    obstacles::Obstacle obstacle;
    render::PlacedShape shape;
  };

  std::size_t list_body(int body);
  int body_values() const;
  void add_visuals(const Setup& setup, int hidden_robot);
  void add_obstacles(const Setup& setup);
  /// Adds a mesh. @returns it, valid as long as this object
  const render::Mesh* add_mesh(const Triangles& triangles, const Vec3<double>& scale);
  /// Puts the picture of a visual on a shape.
  void add_texture(const Setup& setup, const VisualInfo& visual, render::Paint& paint);

  std::vector<int> bodies_;  ///< world body indices, the camera's first
  std::vector<Visual> visuals_;
  std::vector<DrawnObstacle> drawn_obstacles_;
  std::vector<std::unique_ptr<const render::Mesh>> meshes_;
  std::map<std::string, std::unique_ptr<const render::Texture>> textures_;  ///< by file
  bool has_ground_;
  Draws draws_;
  int most_ = 0, most_triangles_ = 0, most_textured_ = 0;
};

}  // namespace skybody::sensor
