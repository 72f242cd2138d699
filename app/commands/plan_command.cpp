// skybody plan: computes a fast line through gates for a vehicle, as a table for `kind: csv`.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "app/arguments.h"
#include "app/commands/command.h"
#include "app/commands/race_line.h"
#include "app/interrupt.h"
#include "app/report/output.h"
#include "app/report/progress_line.h"
#include "app/report/text_table.h"
#include "app/scenario_options.h"
#include "core/env/plugin_setup_tables.h"
#include "core/io/files/missing_file.h"
#include "core/io/files/shipped_files.h"
#include "core/io/yaml/field.h"

namespace skybody {
namespace {

namespace fs = std::filesystem;

constexpr double kFar = 1e5;           // [m]
constexpr double kRowInterval = 0.02;  // [s] between rows of the table

constexpr const char* kPlanFooter =
    "GATES.yaml has `start` and `finish`, at rest, and `gates`, each with `position`, and\n"
    "optionally `direction` (of the passage) and `reach` (largest distance of the passage from\n"
    "the gate's centre). ROBOT is a scenario, a shipped model or a URDF file; the first robot\n"
    "with rotors is used. The search tries random lines, each at the fastest pace that the\n"
    "vehicle can fly with the reserve left, and writes the fastest one. Ctrl-C ends the search\n"
    "and writes the best line so far.\n"
    "Examples:\n"
    "  skybody plan gates.yaml qdrone2 --out race.csv\n"
    "  skybody run hover --reference csv:file=race.csv";

struct PlanOptions {
  LoadOptions load;
  std::string gates;
  fs::path out = "race_line.csv";
  int samples = 20000;
  std::uint64_t seed = 0;
  double reserve = 0.15;
  double max_tilt = 3.0;
  double max_rate = 15.0;
};

const MapSpec& gate_fields() {
  static const MapSpec spec{
      "gate",
      "A gate to pass.",
      {required(
           vector_field("position", "m", {0, 0, 0}, -kFar, kFar, "position of its centre in W")),
       vector_field("direction", "", {0, 0, 0}, -kFar, kFar,
                    "direction of the passage; 0: any, through the centre"),
       real_field("reach", "m", 0, 0, kFar, "largest distance of the passage from the centre")}};
  return spec;
}

const MapSpec& course_fields() {
  static const MapSpec spec{
      "course",
      "The course to fly.",
      {required(vector_field("start", "m", {0, 0, 0}, -kFar, kFar, "start point, at rest")),
       required(vector_field("finish", "m", {0, 0, 0}, -kFar, kFar, "end point, at rest")),
       map_field("gates", Field::Kind::kMapList, gate_fields(), "gates, in order")}};
  return spec;
}

RaceGate read_gate(const ConfigNode& node, Diagnostics& diagnostics) {
  const MapReader reader(&node, gate_fields(), node.mark, diagnostics);
  RaceGate gate{reader.vec3("position"), reader.vec3("direction"), reader.real("reach")};
  const double size = norm(gate.direction);
  if (size > 0.0) gate.direction = gate.direction / size;
  if (gate.reach > 0.0 && size == 0.0) {
    diagnostics.error(reader.mark("reach"),
                      "`reach` is given, but no `direction` across which it would be: add one");
  }
  return gate;
}

RaceCourse read_course(const std::string& file) {
  const std::string problem =
      missing_file(file, "GATES is a YAML file with `start`, `gates` and `finish`");
  if (!problem.empty()) throw Error(problem);
  Diagnostics diagnostics;
  const std::optional<ConfigNode> root = load_config(file, diagnostics);
  diagnostics.throw_if_errors();
  const MapReader reader(&*root, course_fields(), root->mark, diagnostics);
  RaceCourse course{reader.vec3("start"), {}, reader.vec3("finish")};
  if (const ConfigNode* gates = reader.node("gates")) {
    for (const ConfigNode& gate : gates->items) {
      course.gates.push_back(read_gate(gate, diagnostics));
    }
  }
  diagnostics.throw_if_errors();
  Vec3<double> before = course.start;
  const auto check = [&](const Vec3<double>& place, const SourceLocation& mark, const char* what) {
    if (!(norm(place - before) > 1e-3)) {
      diagnostics.error(mark, std::string(what) +
                                  " lies on the place before it; allowed: 0.001 m "
                                  "away or more. Leave one out");
    }
    before = place;
  };
  for (std::size_t g = 0; g < course.gates.size(); ++g) {
    check(course.gates[g].position, reader.node("gates")->items[g].mark, "the gate");
  }
  check(course.finish, reader.mark("finish"), "`finish`");
  diagnostics.throw_if_errors();
  return course;
}

/// A shipped model or a URDF replaces the robot of the scenario `hover`.
void take_model(LoadOptions& load) {
  const auto shipped = find_shipped_model(load.scenario);
  const bool is_urdf = fs::path(load.scenario).extension() == ".urdf";
  if (find_shipped_scenario(load.scenario) || (!shipped && !is_urdf)) return;
  const std::string file = shipped ? shipped->string() : fs::absolute(load.scenario).string();
  load.overrides.insert(load.overrides.begin(), "robots[0].model=\"" + file + "\"");
  load.scenario = "hover";
}

/// The envelope of the first robot with rotors, with rotor thrust reduced by the reserve.
control::FlightEnvelope envelope_of(const CompiledScenario& compiled, const PlanOptions& options) {
  const std::vector<RobotUse>& robots = compiled.scenario().robots;
  const auto found = std::find_if(robots.begin(), robots.end(),
                                  [](const RobotUse& r) { return !r.model.rotors.empty(); });
  if (found == robots.end()) {
    throw Error("no robot of `" + compiled.scenario().name + "` has rotors; name another one");
  }
  const int robot = static_cast<int>(found - robots.begin());
  const SetupTables tables(compiled.world(), compiled.layout());
  SkybodySetup raw = tables.setup("plan", {robot}, {});
  std::vector<SkybodyRotorInfo> rotors(raw.rotors, raw.rotors + raw.rotor_count);
  for (SkybodyRotorInfo& rotor : rotors) {
    rotor.constants[SKYBODY_ROTOR_MAX_SPEED] *= sqrt(1.0 - options.reserve);
  }
  raw.rotors = rotors.data();
  PluginInstance nobody;
  const SkybodyDeclare declare = declare_into(nobody);
  control::FlightEnvelope envelope;
  envelope.configure(Setup(raw, declare), robot, options.max_tilt, options.max_rate);
  return envelope;
}

void write_table(const reference::Spline& line, const std::string& title, const fs::path& file) {
  std::ofstream out(file);
  out << "# " << title << "\nt,x,y,z\n";
  const double length = line.end() - line.begin();
  const int rows = std::max(2, static_cast<int>(length / kRowInterval) + 1);
  for (int k = 0; k <= rows; ++k) {
    const double time = length / rows * k;
    const Vec3<double> p = reference::derivative(line.at<1>(time).point, 0);
    char text[160];
    std::snprintf(text, sizeof text, "%.9g,%.9g,%.9g,%.9g\n", time, p.x, p.y, p.z);
    out << text;
  }
  out.close();
  if (!out) throw Error(file.string() + ": cannot be written");
}

int plan(PlanOptions options) {
  const RaceCourse course = read_course(options.gates);
  take_model(options.load);
  const auto compiled = load_and_warn(options.load);
  const control::FlightEnvelope envelope = envelope_of(*compiled, options);
  const InterruptGuard guard;
  ProgressLine progress;
  int tried = 0;
  const RaceLine line =
      plan_race_line(course, envelope, options.samples, options.seed, [&](int k, double best) {
        tried = k;
        if (progress.is_due()) {
          progress.show("line " + std::to_string(k) + "/" + std::to_string(options.samples) + "  " +
                        std::to_string(100 * k / options.samples) + " %  best " + fixed(best, 3) +
                        " s");
        }
        return InterruptGuard::signal() == 0;
      });
  progress.clear();
  const double time = line.spline.end() - line.spline.begin();
  write_table(line.spline,
              "race line of " + std::to_string(course.gates.size()) + " gates, seed " +
                  std::to_string(options.seed) + ", " + std::to_string(tried) + " lines tried",
              options.out);
  TextTable table({"lines", "first [s]", "best [s]", "peak speed [m/s]"});
  table.add({std::to_string(tried), fixed(line.first_time, 3), fixed(time, 3),
             fixed(line.peak_speed, 2)});
  print(table.to_string());
  std::printf("\ntable    %s\n", options.out.c_str());
  std::fflush(stdout);
  return InterruptGuard::signal() == 0 ? kExitDone : kExitSignal + InterruptGuard::signal();
}

}  // namespace

void add_plan_command(CLI::App& app, Action& chosen) {
  CLI::App* command = app.add_subcommand("plan", "Find a fast line through gates");
  const auto options = std::make_shared<PlanOptions>();
  command->footer(kPlanFooter);
  command->add_option("GATES", options->gates, "YAML file with start, gates and finish")
      ->required()
      ->type_name("");
  command->add_option("ROBOT", options->load.scenario, "A scenario, a shipped model or a URDF file")
      ->required()
      ->type_name("");
  command->add_option("--out", options->out, "Output table (race_line.csv)")->type_name("FILE");
  command->add_option("--samples", options->samples, "Number of lines to try (20000)")
      ->type_name("N")
      ->check(whole_number(1, 1000000));
  command->add_option("--seed", options->seed, "Seed of the random lines (0)")
      ->type_name("S")
      ->check(whole_number(0, UINT64_MAX));
  command
      ->add_option("--reserve", options->reserve,
                   "Share of the rotors' thrust that is reserved for feedback (0.15)")
      ->type_name("SHARE")
      ->check(number_within(0.0, 0.9));
  command->add_option("--max-tilt", options->max_tilt, "Largest tilt [rad] (3)")
      ->type_name("ANGLE")
      ->check(number_within(0.01, 3.141592653589793));
  command->add_option("--max-rate", options->max_rate, "Largest body rate [rad/s] (15)")
      ->type_name("RATE")
      ->check(number_within(0.01, 1e4));
  add_plugin_path(*command, options->load);
  command->callback([options, &chosen] { chosen = [options] { return plan(*options); }; });
}

}  // namespace skybody
