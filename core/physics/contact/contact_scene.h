// What of a world can touch what: shapes with the points and edges by which they touch, and pairs
// of bodies with the constants of their law. Made once.
#pragma once

#include <array>
#include <vector>

#include "core/physics/contact/contact.h"
#include "core/physics/contact/placed_shape.h"
#include "core/physics/contact/rims.h"
#include "core/physics/world/world.h"

namespace skybody {

/// By which places a kind of placed touches others, in units of its half sizes.
struct ContactForm {
  std::vector<Vec3<double>> places;
  int point_count = 0;  ///< the first so many of the places touch: corners, rims, centres, ends
  std::vector<std::array<int, 2>> edges;  ///< between places: the edges of a box, the axis of a
                                          ///< cylinder or capsule
  bool is_round = false;                  ///< its edge is as thick as its first half size
};

/// A body's mass is shared by the places on which it touches anything, by at least so many: the
/// corner of a box, which also turns, gives way as a quarter of its mass would.
inline constexpr int kLeastPlaces = 4;

/// The most places that a form has.
inline constexpr int kMostPlaces = 18;

/// The most places where two shapes touch, in a pack whose lanes touch in all ways: of a box on a
/// height field, 12 edges of 8 parts; 18 points, 2 rims and 8 peaks.
inline constexpr int kMostCollidePoints = 12 * 8 + 18 + 2 + 8;

/// That of a box, a cylinder, a sphere or a capsule.
const ContactForm& contact_form(ShapeType type);

/// A placed of a body or an obstacle, by the nominal constants.
struct ContactShape {
  ShapeType type = ShapeType::kSphere;
  const ContactForm* form = nullptr;
  Pose pose;                         ///< in the body's frame; of obstacles in W
  Vec3<double> half{0.0, 0.0, 0.0};  ///< see PlacedShape
  double rounding = 0.0;
  double reach = 0.0;  ///< of its farthest point from its centre [m]; of obstacles that are
                       ///< endless: infinite
  int bristle = -1;    ///< its first bristle: one for each point, then one for each edge; -1: none
  FieldHeights heights = {};  ///< of a height field
};

/// A point of a body that may touch the ground.
struct GroundPoint {
  Vec3<double> at{0.0, 0.0, 0.0};  ///< in the body's frame [m]
  double radius = 0.0;             ///< [m]
  int bristle = 0;
};

/// A body with shapes, bounded by a sphere.
struct ContactBody {
  int body = 0;  ///< world body index
  int robot = 0;
  int first_shape = 0, last_shape = 0;  ///< of ContactScene::shapes, one beyond the last
  Vec3<double> center{0.0, 0.0, 0.0};   ///< of the sphere, in the body's frame [m]
  double radius = 0.0;                  ///< [m]
  double reach = 0.0;                   ///< radius of a sphere about the body's origin [m]
  double give = 0.0;  ///< penetration_limit() of its thinnest placed, for checks of starts [m]
  int first_bristle = 0, last_bristle = 0;  ///< one beyond the last
  std::vector<GroundPoint> points;          ///< of all its shapes, without the rims
  std::vector<GroundRim> rims;              ///< of all its cylinders
  bool is_driven = false;                   ///< forces do not move it
  double leverage = 1.0;  ///< how far its loosest place gives way by turning, as a multiple of the
                          ///< corner of a filled box; at least 1, by the nominal constants
};

/// Constants of the law between two bodies, or a body and what stands still.
struct ContactLaw {
  double stiffness = 0.0;          ///< Hunt-Crossley k [N/m^1.5]
  double bristle_stiffness = 0.0;  ///< k_t [N/m]
  double bristle_damping = 0.0;    ///< c_t [N s/m]
};

/// Two things that may touch.
struct CollisionPair {
  int body = 0;         ///< of ContactScene::bodies
  int other = kGround;  ///< of ContactScene::bodies, the ground or kFirstObstacle - i for the
                        ///< placed i of ContactScene::obstacles
  ContactLaw law;
  bool moves = true;                ///< forces move one of the two
  bool is_unbounded_below = false;  ///< the other is the ground, a plane or a height field: the
                                    ///< body may get into it as deep as the law lets it
};

/// Immutable; refers to the world, which must outlive it.
struct ContactScene {
  explicit ContactScene(const World& world);

  const World& world;
  std::vector<ContactBody> bodies;
  std::vector<ContactShape> shapes;     ///< of the bodies
  std::vector<ContactShape> obstacles;  ///< of the scenario's obstacles, one after another
  std::vector<int> obstacle_owners;     ///< for each of these: the scenario's obstacle
  /// Bodies of one robot do not meet. Those of a body with obstacles follow one another.
  std::vector<CollisionPair> pairs;
  bool has_idle = false;                 ///< there are pairs of which forces move nothing
  int most_near = 0;                     ///< pairs of a body and the ground, or of two shapes
  int most_places = kMostCollidePoints;  ///< of a body with the ground, or of two shapes
};

/// |g| for contact stiffness [m/s^2]: the scenario's, or 9.81 where it has no gravity.
double contact_gravity(const Scenario& scenario);

/// Places of a placed's constants where an obstacle's are drawn.
enum ObstacleConstant : int {
  kShapePosition = 0,   ///< 3 [m], W
  kShapeAxes = 3,       ///< 9, by rows: W from the placed's frame
  kShapeHalf = 12,      ///< 3 [m]
  kShapeRounding = 15,  ///< [m]
  kShapeReach = 16,     ///< of its farthest point from its centre [m]
  kShapeConstantCount = 17
};

/// How many shapes the obstacles have.
int count_obstacle_shapes(const Scenario& scenario);

/// Constants of the obstacles' shapes, one after another.
/// @param params  the parameter block of one environment
/// @param out     kShapeConstantCount values for each placed
/// @throws Error (naming the obstacle) if one that is present has a size of zero or no rotation
void make_obstacle_constants(const World& world, const double* params, double* out);

}  // namespace skybody
