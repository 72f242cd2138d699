#include "core/io/yaml/scenario_reader.h"

#include <algorithm>
#include <filesystem>
#include <unordered_set>

#include "core/base/math/hash.h"
#include "core/base/system/suggestion.h"
#include "core/io/files/file.h"
#include "core/io/files/height_field_reader.h"
#include "core/io/files/picture_reader.h"
#include "core/io/files/text.h"
#include "core/io/yaml/config_tree.h"
#include "core/io/yaml/coupling_reader.h"
#include "core/io/yaml/field.h"
#include "core/io/yaml/observed_reader.h"
#include "core/io/yaml/plausibility_limits.h"
#include "core/io/yaml/plugin_use_reader.h"
#include "core/io/yaml/robot_reader.h"
#include "core/io/yaml/scenario_fields.h"

namespace skybody {
namespace {

/// Results of the audit of integrators (docs/results/integrators.md): the largest error among the
/// shipped scenarios that are not stiff by design. tests/python/test_integrators.py compares.
struct Audit {
  double largest_dt;  ///< [s]
  const char* error;  ///< after one second of flight with this dt
};
Audit audit_of(IntegratorChoice integrator) {
  if (integrator == IntegratorChoice::kSemiImplicitEuler) return {0.001, "8 mm and 0.5 degrees"};
  return {0.004, "1 mm and 0.1 degrees"};  // the largest dt in the audit
}

/// Keys for an obstacle's shape; each obstacle has exactly one.
const std::vector<std::string> kObstacleShapes = {"box",  "sphere", "cylinder",    "capsule",
                                                  "gate", "plane",  "height_field"};

class ScenarioReader {
 public:
  ScenarioReader(const ConfigNode& root, const std::string& file, const PluginCatalog& catalog,
                 InputBudget& budget, Diagnostics& diagnostics)
      : root_(root),
        catalog_(catalog),
        diagnostics_(diagnostics),
        budget_(budget),
        robots_(catalog, budget, diagnostics) {
    scenario_.file = file;
  }

  Scenario read() {
    const MapReader reader(&root_, scenario_fields(), root_.mark, diagnostics_);
    scenario_.name = reader.text("name");
    if (scenario_.name.empty()) scenario_.name = stem_of(scenario_.file);
    read_stepping(reader);
    read_constants(reader, kWorldConstants, scenario_.constants.data());
    warn_if_implausible(PlausibilityLimit::kGravity, scenario_.gravity().z, "`gravity[2]`", {},
                        reader.mark("gravity"), diagnostics_);
    read_contact(reader);
    read_robots(reader);
    read_teams(reader);
    read_obstacles(reader);
    read_couplings(reader);
    scenario_.sensors = uses(reader, "sensors", SKYBODY_SENSOR);
    scenario_.effects = uses(reader, "effects", SKYBODY_EFFECT);
    scenario_.observe = read_observed(reader.node("observe"), diagnostics_);
    if (reader.node("infos") != nullptr && !reader.node("infos")->is_null()) {
      scenario_.infos = {reader.texts("infos"), reader.mark("infos")};
    }
    scenario_.randomization = uses(reader, "randomization", SKYBODY_RANDOMIZER);
    if (const ConfigNode* task = reader.node("task")) {
      scenario_.task = read_plugin_use(*task, SKYBODY_TASK, catalog_, diagnostics_);
    }
    scenario_.read_picture = read_picture;
    scenario_.text = to_yaml(root_);
    scenario_.hash = hash();
    return std::move(scenario_);
  }

 private:
  static std::string stem_of(const std::string& file) {
    return std::filesystem::path(file).stem().string();
  }

  std::vector<PluginUse> uses(const MapReader& reader, const std::string& key, SkybodyKind kind) {
    return read_plugin_uses(reader.node(key), kind, catalog_, diagnostics_);
  }

  void read_stepping(const MapReader& scenario) {
    const MapReader reader(scenario.node("stepping"), stepping_fields(), root_.mark, diagnostics_);
    Stepping& stepping = scenario_.stepping;
    stepping.dt = reader.real("dt");
    stepping.action_repeat = reader.integer("action_repeat");
    stepping.horizon = reader.integer("horizon");
    const std::string dynamics = reader.text("dynamics");
    if (dynamics == "simbody") stepping.dynamics = DynamicsChoice::kSimbody;
    if (dynamics == "tree") stepping.dynamics = DynamicsChoice::kTree;
    stepping.dynamics_mark = reader.mark("dynamics");
    stepping.integrator = integrator_called(reader.text("integrator"));
    check_dt(reader);
    read_solver(reader);
  }

  void check_dt(const MapReader& reader) {
    const Stepping& stepping = scenario_.stepping;
    const Audit audit = audit_of(stepping.integrator);
    if (stepping.dt <= audit.largest_dt) return;
    const bool is_euler = stepping.integrator == IntegratorChoice::kSemiImplicitEuler;
    diagnostics_.warning(reader.mark("dt"),
                         "`dt` is " + format_number(stepping.dt) +
                             " s; the audit in docs/results/integrators.md supports up to " +
                             format_number(audit.largest_dt) + " s with `" +
                             reader.text("integrator") + "` (errors below " + audit.error +
                             " after a second of flight): take a smaller one" +
                             (is_euler ? ", or the default integrator with at most 0.004 s" : ""));
  }

  static IntegratorChoice integrator_called(const std::string& name) {
    const auto found = std::find(kIntegratorNames.begin(), kIntegratorNames.end(), name);
    if (found == kIntegratorNames.end()) return IntegratorChoice::kMidpoint;  // rejected before
    return static_cast<IntegratorChoice>(found - kIntegratorNames.begin());
  }

  void read_solver(const MapReader& stepping_reader) {
    Stepping& stepping = scenario_.stepping;
    const ConfigNode* node = stepping_reader.node("solver");
    if (node != nullptr && node->is_null()) node = nullptr;  // `--set stepping.solver=null`
    const MapReader reader(node, solver_fields(), root_.mark, diagnostics_);
    SolverSettings& solver = stepping.solver;
    solver.relative_tolerance = reader.real("relative_tolerance");
    solver.absolute_tolerance = reader.real("absolute_tolerance");
    solver.max_steps = reader.integer("max_steps");
    const std::string integrator = stepping_reader.text("integrator");
    if (!is_error_controlled(stepping.integrator)) {
      if (node == nullptr) return;
      diagnostics_.error(reader.mark(),
                         "`solver` is given, but `integrator` is `" + integrator +
                             "`, whose steps are fixed; allowed with `cvode` and "
                             "`arkode`: choose one of them, or leave `solver` out (`null`)");
      return;
    }
    solver.method = solver_method(reader, integrator);
  }

  /// The requested method, which must be one of the integrator's two methods.
  SolverMethod solver_method(const MapReader& reader, const std::string& integrator) {
    const std::string name = reader.text("method");
    if (integrator == "cvode") {
      if (name == "adams" || name == "auto") return SolverMethod::kAdams;
      if (name == "bdf") return SolverMethod::kBdf;
    } else {
      if (name == "dirk") return SolverMethod::kDirk;
      if (name == "erk" || name == "auto") return SolverMethod::kErk;
    }
    const bool is_cvode = integrator == "cvode";
    diagnostics_.error(reader.mark("method"),
                       "`method` is `" + name + "`, which " + integrator +
                           " does not have; allowed with it: auto, " +
                           (is_cvode ? "adams, bdf" : "erk, dirk") +
                           "; `integrator: " + (is_cvode ? "arkode" : "cvode") + "` has it");
    return SolverMethod::kBdf;
  }

  void read_contact(const MapReader& scenario) {
    const MapReader reader(scenario.node("contact"), contact_fields(), root_.mark, diagnostics_);
    ContactSettings& contact = scenario_.contact;
    contact.ground = reader.boolean("ground");
    contact.penetration = reader.real("penetration");
    contact.redraws = reader.integer("redraws");
    read_constants(reader, kWorldConstants, scenario_.constants.data());
  }

  /// The maps of a list; errors for other values, and for more than `most` entries.
  const std::vector<ConfigNode>& list_of(const MapReader& scenario, const std::string& key,
                                         bool may_be_empty, std::size_t most) {
    static const std::vector<ConfigNode> none;
    const ConfigNode* node = scenario.node(key);
    if (node == nullptr || (may_be_empty && node->is_null())) return none;
    if (node->is_sequence() && node->items.size() > most) {
      diagnostics_.error(node->mark, too_many_entries(key, node->items.size(), most));
      return none;
    }
    if (node->is_sequence() && (may_be_empty || !node->items.empty())) return node->items;
    const std::string what = node->is_sequence() ? "an empty list" : node->describe();
    const std::string allowed = may_be_empty ? "a list of maps" : "a list of at least one map";
    diagnostics_.error(node->mark, "`" + key + "` is " + what + "; allowed: " + allowed);
    return none;
  }

  void read_robots(const MapReader& scenario) {
    std::unordered_set<std::string> names;
    for (const ConfigNode& item : list_of(scenario, "robots", false, kMostRobots)) {
      check_unique(item, "robot", names);
      std::optional<RobotUse> robot = robots_.read(item);
      if (robot) scenario_.robots.push_back(std::move(*robot));
    }
  }

  void check_unique(const ConfigNode& item, const std::string& what,
                    std::unordered_set<std::string>& names) {
    const ConfigNode* name = item.find("name");
    if (name == nullptr || !name->is_scalar() || names.insert(name->scalar).second) return;
    diagnostics_.error(name->mark,
                       "a second " + what + " called `" + name->scalar + "`; names must differ");
  }

  void read_teams(const MapReader& scenario) {
    std::unordered_set<std::string> names;
    std::vector<std::string> robots;
    for (const RobotUse& robot : scenario_.robots) robots.push_back(robot.name);
    for (const ConfigNode& item : list_of(scenario, "teams", true, kMostTeams)) {
      check_unique(item, "team", names);
      const MapReader reader(&item, team_fields(), item.mark, diagnostics_);
      TeamUse team;
      team.name = reader.text("name");
      team.controllers = uses(reader, "controllers", SKYBODY_CONTROLLER);
      const ConfigNode* given = reader.node("controllers");
      const bool is_none = given != nullptr && given->is_null();
      if (is_none || (given != nullptr && given->is_sequence() && given->items.empty())) {
        diagnostics_.error(given->mark, std::string("`controllers` is ") +
                                            (is_none ? "empty" : "an empty list") +
                                            "; allowed: a list of at least one controller");
      }
      team.robots = robots_of(reader, robots);
      scenario_.teams.push_back(std::move(team));
    }
  }

  /// Indices of a team's robots. @param known  names of all robots
  std::vector<int> robots_of(const MapReader& team, const std::vector<std::string>& known) {
    std::vector<int> robots;
    const std::vector<std::string> names = team.texts("robots");
    if (names.size() > kMostRobots) {
      diagnostics_.error(team.mark("robots"),
                         too_many_entries("robots", names.size(), kMostRobots));
      return robots;
    }
    for (std::size_t i = 0; i < names.size(); ++i) {
      const std::string& name = names[i];
      const SourceLocation& mark = team.node("robots")->items[i].mark;
      const auto found = std::find(known.begin(), known.end(), name);
      const auto place = static_cast<int>(found - known.begin());
      if (found == known.end()) {
        diagnostics_.error(mark,
                           "`" + name + "` is not a robot" + suggestion(name, known, "robots"));
      } else if (std::find(robots.begin(), robots.end(), place) != robots.end()) {
        diagnostics_.error(mark, "`" + name + "` is named twice; a team has each robot once");
      } else {
        robots.push_back(place);
      }
    }
    return robots;
  }

  void read_obstacles(const MapReader& scenario) {
    std::unordered_set<std::string> names;
    for (const ConfigNode& item : list_of(scenario, "obstacles", true, kMostObstacles)) {
      check_unique(item, "obstacle", names);
      read_obstacle(item);
    }
  }

  void read_couplings(const MapReader& scenario) {
    std::unordered_set<std::string> names;
    for (const ConfigNode& item : list_of(scenario, "couplings", true, kMostCouplings)) {
      check_unique(item, "coupling", names);
      const auto coupling = read_coupling(item, scenario_.robots, diagnostics_);
      if (coupling) scenario_.couplings.push_back(*coupling);
    }
  }

  void read_obstacle(const ConfigNode& item) {
    const MapReader reader(&item, obstacle_fields(), item.mark, diagnostics_);
    Obstacle obstacle;
    obstacle.name = reader.text("name");
    obstacle.mark = reader.mark();
    obstacle.shape.pose = read_pose(reader);
    std::vector<std::string> shapes;
    for (const std::string& key : kObstacleShapes) {
      if (reader.node(key) != nullptr) shapes.push_back(key);
    }
    if (shapes.size() != 1) {
      const std::string what = shapes.empty() ? "has no shape" : "has " + join(shapes, " and ");
      diagnostics_.error(reader.mark(), "the obstacle `" + obstacle.name + "` " + what +
                                            "; needed: one of " + join(kObstacleShapes));
      return;
    }
    if (shapes[0] == "box" || shapes[0] == "gate") {
      obstacle.shape.type = ShapeType::kBox;
      obstacle.shape.size = reader.vec3(shapes[0]);
      obstacle.is_gate = shapes[0] == "gate";
    } else if (shapes[0] == "sphere") {
      obstacle.shape.type = ShapeType::kSphere;
      obstacle.shape.radius = reader.real("sphere");
    } else if (shapes[0] == "plane") {
      obstacle.shape.type = ShapeType::kPlane;
      if (!reader.boolean("plane")) {
        diagnostics_.error(reader.mark("plane"),
                           "`plane` is false; allowed: true, or another shape");
      }
    } else if (shapes[0] == "height_field") {
      if (!read_height_field(*reader.node("height_field"), budget_, diagnostics_, obstacle.shape)) {
        return;
      }
    } else {
      const std::vector<double> size = reader.numbers(shapes[0]);
      const bool is_capsule = shapes[0] == "capsule";
      obstacle.shape.type = is_capsule ? ShapeType::kCapsule : ShapeType::kCylinder;
      obstacle.shape.radius = size[0];
      obstacle.shape.length = size[1];
    }
    scenario_.obstacles.push_back(obstacle);
  }

  /// Hash over the merged text, the model files and all parameters, defaults included. For a file
  /// in a parameter, the contents are hashed and not the path, as for models and heights.
  std::uint64_t hash() const {
    HashChain chain;
    chain.update(hash_string(scenario_.text));
    chain.update(robots_.files_hash());
    for (const Obstacle& obstacle : scenario_.obstacles) {
      if (!obstacle.shape.heights) continue;
      chain.update(static_cast<double>(obstacle.shape.heights->columns()));
      for (double height : obstacle.shape.heights->heights()) chain.update(height);
    }
    for (const RobotUse& robot : scenario_.robots) {
      add(robot.controllers, SKYBODY_CONTROLLER, chain);
    }
    for (const TeamUse& team : scenario_.teams) add(team.controllers, SKYBODY_CONTROLLER, chain);
    add(scenario_.sensors, SKYBODY_SENSOR, chain);
    add(scenario_.effects, SKYBODY_EFFECT, chain);
    add(scenario_.randomization, SKYBODY_RANDOMIZER, chain);
    add({scenario_.task}, SKYBODY_TASK, chain);
    return chain.value();
  }

  void add(const std::vector<PluginUse>& uses, SkybodyKind kind, HashChain& chain) const {
    for (const PluginUse& use : uses) {
      chain.update(hash_string(use.plugin));
      for (const ParameterValue* value : by_name(use.parameters)) {
        chain.update(hash_string(value->name));
        for (double number : value->numbers) chain.update(number);
        const bool names_files = is_file_parameter(kind, use.plugin, value->name);
        for (const std::string& text : value->texts) {
          chain.update(hash_string(names_files ? contents_of(text) : text));
        }
      }
    }
  }

  /// Parameters in the order of their names: the order in which a plugin declares them does not
  /// change the hash.
  static std::vector<const ParameterValue*> by_name(const std::vector<ParameterValue>& values) {
    std::vector<const ParameterValue*> sorted;
    for (const ParameterValue& value : values) sorted.push_back(&value);
    std::sort(sorted.begin(), sorted.end(),
              [](const ParameterValue* a, const ParameterValue* b) { return a->name < b->name; });
    return sorted;
  }

  bool is_file_parameter(SkybodyKind kind, const std::string& plugin,
                         const std::string& name) const {
    const PluginDeclaration* declaration = catalog_.find(kind, plugin);
    if (declaration == nullptr) return false;
    const std::vector<ParameterSpec>& specs = declaration->parameters;
    return std::any_of(specs.begin(), specs.end(), [&](const ParameterSpec& spec) {
      return spec.name == name && spec.is_file;
    });
  }

  /// A file's contents, or its path if it cannot be read: the plugin that opens it reports why.
  static std::string contents_of(const std::string& file) {
    std::string text;
    const bool is_read = read_regular_file(file, InputBudget::kMostFileText, text).empty();
    return is_read ? text : file;
  }

  const ConfigNode& root_;
  const PluginCatalog& catalog_;
  Diagnostics& diagnostics_;
  InputBudget& budget_;
  RobotReader robots_;
  Scenario scenario_;
};

}  // namespace

std::optional<Scenario> read_scenario(const std::string& file,
                                      const std::vector<std::string>& overrides,
                                      const PluginCatalog& catalog, Diagnostics& diagnostics,
                                      const ScenarioEdit& edit) {
  const int errors_before = diagnostics.error_count();
  InputBudget budget;
  std::optional<ConfigNode> root = load_config(file, diagnostics, budget);
  if (!root) return std::nullopt;
  if (overrides.size() > InputBudget::kMostOverrides) {
    diagnostics.error({file, 0, 0}, std::to_string(overrides.size()) +
                                        " overrides are given; allowed: at most " +
                                        std::to_string(InputBudget::kMostOverrides));
    return std::nullopt;
  }
  for (const std::string& override : overrides) {
    apply_override(*root, override, diagnostics, budget);
  }
  if (edit) edit(*root, diagnostics);
  Scenario scenario = ScenarioReader(*root, file, catalog, budget, diagnostics).read();
  if (diagnostics.error_count() > errors_before) return std::nullopt;
  return scenario;
}

}  // namespace skybody
