#include "core/physics/contact/contact_scene.h"

#include <algorithm>

#include "core/base/math/math.h"
#include "core/base/system/error.h"
#include "core/physics/bodies/kinematics.h"
#include "core/physics/shapes/overlap.h"

namespace skybody {
namespace {

/// Points within this height of the lowest one carry the robot at rest [m].
constexpr double kLevel = 1e-3;
/// Limit of (frequency x dt)^2, summed over all points on which a body rests and over all
/// directions. This is the trace of a matrix, about three times its largest eigenvalue; a step is
/// stable if the eigenvalue is below 4.
constexpr double kLargestSquaredPhase = 4.0;
/// Likewise for bristles: the limit of damping x dt / mass; stable if the eigenvalue is below 2.
constexpr double kLargestDamping = 3.0;

ContactForm make_box() {
  ContactForm form;
  for (int corner = 0; corner < 8; ++corner) {
    const auto sign = [corner](int bit) { return (corner >> bit & 1) != 0 ? 1.0 : -1.0; };
    form.places.push_back({sign(0), sign(1), sign(2)});
  }
  for (int corner = 0; corner < 8; ++corner) {
    for (int bit = 0; bit < 3; ++bit) {
      if ((corner >> bit & 1) == 0) form.edges.push_back({corner, corner | 1 << bit});
    }
  }
  form.point_count = 8;
  return form;
}

ContactForm make_cylinder() {
  ContactForm form;
  for (const double z : {-1.0, 1.0}) {
    for (int i = 0; i < kRimPoints; ++i) {
      const SinCos<double> angle = sincos(i * (kTwoPi / kRimPoints));
      form.places.push_back({angle.cos, angle.sin, z});
    }
  }
  form.point_count = 2 * kRimPoints;
  form.places.push_back({0.0, 0.0, -1.0});
  form.places.push_back({0.0, 0.0, 1.0});
  form.edges.push_back({form.point_count, form.point_count + 1});
  form.is_round = true;
  return form;
}

ContactForm make_capsule() {
  ContactForm form;
  form.places = {{0.0, 0.0, -1.0}, {0.0, 0.0, 1.0}};
  form.point_count = 2;
  form.edges.push_back({0, 1});
  return form;
}

ContactForm make_sphere() {
  ContactForm form;
  form.places.push_back({0.0, 0.0, 0.0});
  form.point_count = 1;
  return form;
}

ContactShape make_contact_shape(const Shape& shape) {
  ContactShape placed;
  placed.type = shape.type;
  placed.form = &contact_form(shape.type);
  placed.pose = shape.pose;
  if (shape.type == ShapeType::kBox) placed.half = 0.5 * shape.size;
  if (shape.type == ShapeType::kCylinder) {
    placed.half = {shape.radius, shape.radius, 0.5 * shape.length};
  }
  if (shape.type == ShapeType::kSphere) placed.rounding = shape.radius;
  if (shape.type == ShapeType::kCapsule) {
    placed.half.z = 0.5 * shape.length;
    placed.rounding = shape.radius;
  }
  placed.reach = bounding_radius(shape);
  return placed;
}

bool has_others(const Scenario& scenario) {
  return !scenario.obstacles.empty() || scenario.robots.size() > 1;
}

/// Number of bristles of a shape.
int bristles_of(const Scenario& scenario, const Shape& shape) {
  const ContactForm& form = contact_form(contact_shape(shape).type);
  const int edges = has_others(scenario) ? static_cast<int>(form.edges.size()) : 0;
  return form.point_count + edges;
}

/// Motion of all bodies with joints at zero and every free base upright at the origin.
std::vector<BodyKinematics<double>> upright_bodies(const World& world) {
  std::vector<double> q(64 + 7 * world.bodies.size(), 0.0), u(q.size(), 0.0);
  for (const WorldBody& body : world.bodies) {
    if (body.model->joint.type == JointType::kBall) q[body.q] = 1.0;
    if (body.model->joint.type == JointType::kFree) q[body.q + 3] = 1.0;
  }
  std::vector<BodyKinematics<double>> bodies(world.bodies.size());
  forward_kinematics(make_tree(world), q.data(), u.data(), bodies.data());
  return bodies;
}

/// Adds the heights of all points of a body.
void add_heights(const ContactBody& body, const BodyKinematics<double>& m,
                 std::vector<double>& heights) {
  for (const GroundPoint& p : body.points) {
    heights.push_back((m.position + m.axes * p.at).z - p.radius);
  }
  for (const GroundRim& rim : body.rims) {
    each_ground_place(rim, m, [&](const Vec3<double>& place, int) { heights.push_back(place.z); });
  }
}

/// Number of heights close to the lowest one.
std::ptrdiff_t count_lowest(const std::vector<double>& heights) {
  const double lowest = *std::min_element(heights.begin(), heights.end());
  return std::count_if(heights.begin(), heights.end(),
                       [&](double z) { return z <= lowest + kLevel; });
}

/// Number of lowest points of an upright robot.
std::ptrdiff_t count_upright_places(const ContactScene& scene, std::size_t robot) {
  const std::vector<BodyKinematics<double>> motion = upright_bodies(scene.world);
  std::vector<double> heights;
  for (const ContactBody& body : scene.bodies) {
    if (body.robot != static_cast<int>(robot)) continue;
    add_heights(body, motion[static_cast<std::size_t>(body.body)], heights);
  }
  return heights.empty() ? 1 : count_lowest(heights);
}

/// The largest number of points on which a body rests on any of its six sides; at least
/// kLeastPlaces.
std::ptrdiff_t most_resting_places(const ContactBody& body) {
  std::ptrdiff_t most = kLeastPlaces;
  for (int side = 0; side < 6; ++side) {
    const double turn = side % 2 == 0 ? 0.5 * kPi : -0.5 * kPi;
    BodyKinematics<double> m{};
    m.axes = to_mat3(side < 2   ? from_rpy(turn, 0.0, 0.0)
                     : side < 4 ? from_rpy(0.0, turn, 0.0)
                                : from_rpy(turn - 0.5 * kPi, 0.0, 0.0));
    std::vector<double> heights;
    add_heights(body, m, heights);
    most = std::max(most, count_lowest(heights));
  }
  return most;
}

/// Rotational mobility of a free body at a point [1/kg]: its response to unit impulses by rotation,
/// summed over three directions. @param arm  from its centre of mass, body axes
double turning_at(const MassProperties& mass, const Vec3<double>& arm) {
  const SymMat3<double> inverted = inverse(mass.inertia);
  return (inverted.xx + inverted.yy + inverted.zz) * dot(arm, arm) - dot(arm, inverted * arm);
}

/// The largest turning_at() of all points of a body.
double most_turning(const MassProperties& mass, const ContactBody& body) {
  double most = 0.0;
  for (const GroundPoint& p : body.points) {
    for (int side = 0; side < 6; ++side) {
      Vec3<double> out{0.0, 0.0, 0.0};
      (side < 2 ? out.x : side < 4 ? out.y : out.z) = side % 2 == 0 ? p.radius : -p.radius;
      most = max(most, turning_at(mass, p.at + out - mass.com));
    }
  }
  for (const GroundRim& rim : body.rims) {
    for (const Vec3<double>& spoke : rim.spokes) {
      most = max(most, turning_at(mass, rim.rim.middle + spoke - mass.com));
    }
  }
  return most;
}

const MassProperties& mass_of(const ContactScene& scene, const ContactBody& body) {
  return scene.world.bodies[static_cast<std::size_t>(body.body)].model->mass;
}

/// Mobility of the most mobile point, rotation and mass together [1/kg]; 0 for driven bodies. A
/// link of a robot with joints cannot rotate freely.
double mobility(const ContactScene& scene, const ContactBody& body) {
  if (body.is_driven) return 0.0;
  const MassProperties& mass = mass_of(scene, body);
  const auto robot = static_cast<std::size_t>(body.robot);
  if (scene.world.layout.robots[robot].body_count > 1) return kLeastPlaces / mass.mass;
  return 3.0 / mass.mass + most_turning(mass, body);
}

/// See ContactBody. The rotational mobility of a corner of a uniform box is 9 / m, whatever its
/// sides. Links of a robot with joints are treated as free. They then get more substeps than
/// necessary, and less damping if the number of substeps is exhausted, never the opposite.
double leverage(const ContactScene& scene, const ContactBody& body) {
  const MassProperties& mass = mass_of(scene, body);
  if (body.is_driven || !(mass.mass > 0.0)) return 1.0;
  return max(most_turning(mass, body) * mass.mass / 9.0, 1.0);
}

/// The sum of mobility() over all points on which a body rests at once [1/kg].
double gives_of(const ContactScene& scene, const ContactBody& body) {
  return static_cast<double>(most_resting_places(body)) * mobility(scene, body);
}

/// Stiffness of the points of each contact body. An upright robot at rest on its n lowest points
/// sinks in by ContactSettings::penetration x0:
///   k = m |g| / (n x0^1.5).
/// The stiffness is limited so that dt resolves the oscillation of the body itself on as many
/// points as it may rest on (gives_of).
std::vector<double> stiffnesses(const ContactScene& scene) {
  const Scenario& scenario = scene.world.scenario;
  const double depth = scenario.contact.penetration, dt = scenario.stepping.dt;
  std::vector<double> wanted;
  for (std::size_t r = 0; r < scenario.robots.size(); ++r) {
    const auto carriers = static_cast<double>(count_upright_places(scene, r));
    wanted.push_back(scenario.robots[r].model.total_mass() * contact_gravity(scenario) /
                     (carriers * pow_3_2(depth)));
  }
  std::vector<double> out;
  for (const ContactBody& body : scene.bodies) {
    const double gives = gives_of(scene, body) * (dt * dt);
    const double most = kLargestSquaredPhase / gives / (1.5 * sqrt(depth));  // infinite if driven
    out.push_back(min(wanted[static_cast<std::size_t>(body.robot)], most));
  }
  return out;
}

/// Newton's method, because libm's cbrt differs between machines.
double cube_root(double a) {
  double root = max(a, 1.0), before = 0.0;
  for (int i = 0; i < 200 && root != before; ++i) {
    before = root;
    root = (2.0 * root + a / (root * root)) / 3.0;
  }
  return root;
}

/// Two springs of power 1.5 in series.
double in_series(double a, double b) {
  const double ratio = cube_root(a / b * (a / b));  // deflection of b relative to a
  return a / pow_3_2(1.0 + ratio);
}

/// Nominal mass per bristle; infinite for bodies that forces do not move.
double nominal_share(const ContactScene& scene, const ContactBody& body) {
  if (body.is_driven) return kInfinity;
  return mass_of(scene, body).mass / kLeastPlaces;
}

/// @param share     mass per bristle
/// @param gives     sum of gives_of() of the bodies
ContactLaw make_law(const Scenario& scenario, double stiffness, double share, double gives) {
  ContactLaw law;
  law.stiffness = stiffness;
  law.bristle_stiffness = 1.5 * stiffness * sqrt(scenario.contact.penetration);
  if (share == kInfinity) return law;
  const double most = kLargestDamping / (gives * scenario.stepping.dt);
  law.bristle_damping = min(sqrt(law.bristle_stiffness * share), most);
  return law;
}

void add_rim(const ContactShape& placed, double end, ContactBody& body) {
  const auto turn = [&](const Vec3<double>& v) { return rotate(placed.pose.rotation, v); };
  const int first = end < 0.0 ? 0 : kRimPoints;
  GroundRim rim;
  rim.rim = {placed.pose.position + turn({0.0, 0.0, end * placed.half.z}), turn({0.0, 0.0, 1.0}),
             placed.half.x};
  for (int k = 0; k < kRimPoints; ++k) {
    const auto place = static_cast<std::size_t>(k);
    const Vec3<double>& at = placed.form->places[static_cast<std::size_t>(first) + place];
    rim.spokes[place] = turn({at.x * placed.half.x, at.y * placed.half.y, 0.0});
  }
  rim.bristle = placed.bristle + first;
  body.rims.push_back(rim);
}

/// Adds the points of a shape that may touch the ground.
void add_ground_places(const ContactShape& placed, ContactBody& body) {
  if (placed.type == ShapeType::kCylinder) {
    for (const double end : {-1.0, 1.0}) add_rim(placed, end, body);
    return;
  }
  for (int k = 0; k < placed.form->point_count; ++k) {
    const Vec3<double> at =
        multiply_elements(placed.half, placed.form->places[static_cast<std::size_t>(k)]);
    body.points.push_back({placed.pose.position + rotate(placed.pose.rotation, at), placed.rounding,
                           placed.bristle + k});
  }
}

void add_bodies(ContactScene& scene) {
  const World& world = scene.world;
  int bristles = 0;
  for (std::size_t i = 0; i < world.bodies.size(); ++i) {
    const WorldBody& model = world.bodies[i];
    ContactBody body;
    body.body = static_cast<int>(i);
    body.robot = model.robot;
    body.first_shape = static_cast<int>(scene.shapes.size());
    body.is_driven =
        model.parent < 0 && world.drives[static_cast<std::size_t>(model.robot)] != DriveKind::kNone;
    body.give = kInfinity;
    body.first_bristle = bristles;
    Vec3<double> low{kInfinity, kInfinity, kInfinity}, high{-kInfinity, -kInfinity, -kInfinity};
    for (const Shape& shape : model.model->collisions) {
      ContactShape placed = make_contact_shape(contact_shape(shape));
      placed.bristle = bristles;
      add_ground_places(placed, body);
      bristles += bristles_of(world.scenario, shape);
      body.give = min(body.give, penetration_limit(placed.half, placed.rounding));
      const Vec3<double>& p = placed.pose.position;
      const double r = placed.reach;
      low = {min(low.x, p.x - r), min(low.y, p.y - r), min(low.z, p.z - r)};
      high = {max(high.x, p.x + r), max(high.y, p.y + r), max(high.z, p.z + r)};
      scene.shapes.push_back(placed);
    }
    body.last_shape = static_cast<int>(scene.shapes.size());
    body.last_bristle = bristles;
    if (body.first_shape == body.last_shape) continue;
    body.center = 0.5 * (low + high);
    body.leverage = leverage(scene, body);
    for (int s = body.first_shape; s < body.last_shape; ++s) {
      const ContactShape& placed = scene.shapes[static_cast<std::size_t>(s)];
      body.radius = max(body.radius, norm(placed.pose.position - body.center) + placed.reach);
    }
    body.reach = body.radius + norm(body.center);
    scene.bodies.push_back(body);
  }
}

void add_pairs(ContactScene& scene) {
  const Scenario& scenario = scene.world.scenario;
  const std::vector<double> stiffness = stiffnesses(scene);
  std::vector<double> all_give;
  for (const ContactBody& body : scene.bodies) all_give.push_back(gives_of(scene, body));
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    const double share = nominal_share(scene, scene.bodies[i]);
    const double gives = all_give[i];
    const ContactLaw law = make_law(scenario, stiffness[i], share, gives);
    const int body = static_cast<int>(i);
    const bool moves = !scene.bodies[i].is_driven;
    if (scenario.contact.ground) scene.pairs.push_back({body, kGround, law, moves, true});
    for (std::size_t k = 0; k < scene.obstacles.size(); ++k) {
      scene.pairs.push_back({body, kFirstObstacle - static_cast<int>(k), law, moves,
                             is_unbounded_below(scene.obstacles[k].type)});
    }
    for (std::size_t k = i + 1; k < scene.bodies.size(); ++k) {
      if (scene.bodies[k].robot == scene.bodies[i].robot) continue;
      const double other = nominal_share(scene, scene.bodies[k]);
      const double both = 1.0 / (1.0 / share + 1.0 / other);
      const double softer = in_series(stiffness[i], stiffness[k]);
      scene.pairs.push_back({body, static_cast<int>(k),
                             make_law(scenario, softer, both, gives + all_give[k]),
                             moves || !scene.bodies[k].is_driven, false});
    }
  }
}

/// Number of pairs of shapes in a pair of bodies.
int count_pairs(const ContactScene& scene, const CollisionPair& pair) {
  if (pair.other == kGround) return 1;
  const auto obstacle_shapes_of = [&](int body) {
    const ContactBody& b = scene.bodies[static_cast<std::size_t>(body)];
    return b.last_shape - b.first_shape;
  };
  return obstacle_shapes_of(pair.body) * (pair.other >= 0 ? obstacle_shapes_of(pair.other) : 1);
}

}  // namespace

const ContactForm& contact_form(ShapeType type) {
  static const ContactForm box = make_box(), cylinder = make_cylinder(), sphere = make_sphere(),
                           capsule = make_capsule();
  if (type == ShapeType::kBox) return box;
  if (type == ShapeType::kCapsule) return capsule;
  return type == ShapeType::kCylinder ? cylinder : sphere;
}

double contact_gravity(const Scenario& scenario) {
  const double g = norm(scenario.gravity());
  return g > 0.0 ? g : 9.81;
}

int count_bristles(const Topology& topology) {
  int count = 0;
  for (const WorldBody& body : topology.bodies) {
    for (const Shape& shape : body.model->collisions) {
      count += bristles_of(topology.scenario, shape);
    }
  }
  return topology.scenario.contact.ground || has_others(topology.scenario) ? count : 0;
}

ContactScene::ContactScene(const World& w) : world(w) {
  if (count_bristles(world) == 0) return;
  add_bodies(*this);
  double reach = 0.0;
  for (const ContactShape& placed : shapes) reach = max(reach, placed.reach);
  // The search before a step covers a larger distance: the way of one step at 20 m/s, and a
  // millimetre.
  reach += 1e-3 + 20.0 * world.scenario.stepping.dt;
  int owner = 0;
  for (const Obstacle& obstacle : world.scenario.obstacles) {
    for (const Shape& shape : obstacle_shapes_of(obstacle)) {
      obstacles.push_back(make_contact_shape(shape));
      if (shape.heights) obstacles.back().heights = {shape.heights.get(), reach};
      if (shape.type == ShapeType::kMesh) obstacles.back().rounding = kNoShape;
      obstacle_owners.push_back(owner);
    }
    ++owner;
  }
  add_pairs(*this);
  for (const CollisionPair& pair : pairs) {
    has_idle |= !pair.moves;
    most_near += count_pairs(*this, pair);
  }
  for (const ContactBody& body : bodies) {
    const std::size_t places = body.points.size() + (kRimPoints + 1) * body.rims.size();
    most_places = std::max(most_places, static_cast<int>(places));
  }
}

}  // namespace skybody
