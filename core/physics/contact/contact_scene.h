// Collision shapes of a world with their contact points and edges, and pairs of bodies with the
// constants of their contact law. Made once.
#pragma once

#include <array>
#include <vector>

#include "core/physics/contact/contact.h"
#include "core/physics/contact/cylinder_rims.h"
#include "core/physics/contact/placed_shape.h"
#include "core/physics/world/world.h"

namespace skybody {

/// The contact points and edges of a type of shape, in units of its half sizes.
struct ContactForm {
  std::vector<Vec3<double>> places;
  int point_count = 0;  ///< number of places that are contact points, first in the list: corners,
                        ///< rims, centres, ends
  std::vector<std::array<int, 2>> edges;  ///< between places: the edges of a box, the axis of a
                                          ///< cylinder or capsule
  bool is_round = false;                  ///< its edge is as thick as its first half size
};

/// Minimum number of points that share a body's mass. The mobility of a box's corner, which also
/// rotates, is that of a quarter of its mass.
inline constexpr int kLeastPlaces = 4;

/// Maximum number of places of a form.
inline constexpr int kMostPlaces = 18;

/// Maximum number of contact points of two shapes, in a pack whose lanes touch in all ways: for a
/// box on a height field, 12 edges of 8 parts; 18 points, 2 rims and 8 peaks.
inline constexpr int kMostCollidePoints = 12 * 8 + 18 + 2 + 8;

/// The form of a box, a cylinder, a sphere or a capsule.
const ContactForm& contact_form(ShapeType type);

/// A shape of a body or an obstacle, with nominal constants.
struct ContactShape {
  ShapeType type = ShapeType::kSphere;
  const ContactForm* form = nullptr;
  Pose pose;                         ///< in the body's frame; in W for obstacles
  Vec3<double> half{0.0, 0.0, 0.0};  ///< see PlacedShape
  double rounding = 0.0;
  double reach = 0.0;  ///< distance of its farthest point from its centre [m]; infinite for
                       ///< unbounded obstacles
  int bristle = -1;    ///< index of its first bristle: one per point, then one per edge; -1: none
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
  int first_shape = 0, last_shape = 0;  ///< in ContactScene::shapes: [first, last)
  Vec3<double> center{0.0, 0.0, 0.0};   ///< of the sphere, in the body's frame [m]
  double radius = 0.0;                  ///< [m]
  double reach = 0.0;                   ///< radius of a sphere about the body's origin [m]
  double give = 0.0;  ///< penetration_limit() of its thinnest shape, for checks of initial states
                      ///< [m]
  int first_bristle = 0, last_bristle = 0;  ///< [first, last)
  std::vector<GroundPoint> points;          ///< of all its shapes, without the rims
  std::vector<GroundRim> rims;              ///< of all its cylinders
  bool is_driven = false;                   ///< forces do not move it
  double leverage = 1.0;  ///< rotational mobility of its most mobile point, as a multiple of the
                          ///< corner of a uniform box; at least 1, from the nominal constants
};

/// Constants of the contact law between two bodies, or a body and the ground or an obstacle.
struct ContactLaw {
  double stiffness = 0.0;          ///< Hunt-Crossley k [N/m^1.5]
  double bristle_stiffness = 0.0;  ///< k_t [N/m]
  double bristle_damping = 0.0;    ///< c_t [N s/m]
};

/// Two bodies, or a body and the ground or an obstacle, that may touch.
struct CollisionPair {
  int body = 0;         ///< of ContactScene::bodies
  int other = kGround;  ///< in ContactScene::bodies, kGround, or kFirstObstacle - i for shape i of
                        ///< ContactScene::obstacles
  ContactLaw law;
  bool moves = true;                ///< forces move at least one of the two
  bool is_unbounded_below = false;  ///< the other is the ground, a plane or a height field:
                                    ///< penetration is limited only by the contact law
};

/// Immutable; refers to the world, which must outlive it.
struct ContactScene {
  explicit ContactScene(const World& world);

  const World& world;
  std::vector<ContactBody> bodies;
  std::vector<ContactShape> shapes;     ///< of the bodies
  std::vector<ContactShape> obstacles;  ///< shapes of the scenario's obstacles, one after another
  std::vector<int> obstacle_owners;     ///< per obstacle shape: index of the scenario's obstacle
  /// Bodies of one robot do not collide. The pairs of one body with obstacles are contiguous.
  std::vector<CollisionPair> pairs;
  bool has_idle = false;  ///< there are pairs that forces do not move
  int most_near = 0;      ///< number of pairs of a body with the ground, and of two shapes
  int most_places = kMostCollidePoints;  ///< maximum number of contact points of a body with the
                                         ///< ground, or of two shapes
};

/// |g| for contact stiffness [m/s^2]: the scenario's, or 9.81 without gravity.
double contact_gravity(const Scenario& scenario);

/// Indices of an obstacle shape's constants; obstacles may be randomized.
enum ObstacleConstant : int {
  kShapePosition = 0,   ///< 3 [m], W
  kShapeAxes = 3,       ///< 9, by rows: W from the shape's frame
  kShapeHalf = 12,      ///< 3 [m]
  kShapeRounding = 15,  ///< [m]
  kShapeReach = 16,     ///< distance of its farthest point from its centre [m]
  kShapeConstantCount = 17
};

/// Number of shapes of all obstacles.
int count_obstacle_shapes(const Scenario& scenario);

/// Constants of the obstacles' shapes, one after another.
/// @param params  the parameter block of one environment
/// @param out     kShapeConstantCount values per shape
/// @throws Error (naming the obstacle) if one that is present has a size of zero or a rotation of
/// norm 0
void make_obstacle_constants(const World& world, const double* params, double* out);

}  // namespace skybody
