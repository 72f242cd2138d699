// MuJoCo's mj_step in C, one world with R quadrotors on one core.
//
// The fastest documented settings for this work: no shapes, and the flags that disable unused
// features (contacts, constraints, passive forces, sensors, clamping, warm starts); body frames at
// the centres of mass, so that MuJoCo uses a diagonal mass matrix; the rotors' wrench passed as
// qfrc_applied. A second row applies thrusts through MuJoCo's own actuators (motors at sites), as
// most models do.
#include <mujoco/mujoco.h>

#include <memory>

#include "research/peers/step_bench.h"

namespace skybody::bench {
namespace {

enum class Rotors { kWrench, kMotors };

std::string text(double value) {
  char buffer[32];
  std::snprintf(buffer, sizeof buffer, "%.17g", value);
  return buffer;
}

std::string vector_text(double x, double y, double z) {
  return "\"" + text(x) + " " + text(y) + " " + text(z) + "\"";
}

/// The world as MJCF.
std::string describe(int robots, Rotors rotors) {
  const Quadrotor& quad = kQuadrotor;
  std::string bodies, motors;
  for (int robot = 0; robot < robots; ++robot) {
    const double place = quad.spacing * robot;
    bodies += "<body pos=" + vector_text(place, place, quad.height) +
              "><freejoint/><inertial mass=\"" + text(quad.mass) + "\" pos=\"0 0 0\" diaginertia=" +
              vector_text(quad.inertia[0], quad.inertia[1], quad.inertia[2]) + "/>";
    for (int k = 0; rotors == Rotors::kMotors && k < quad.rotors; ++k) {
      const std::string name = "\"rotor" + std::to_string(robot) + "_" + std::to_string(k) + "\"";
      bodies +=
          "<site name=" + name + " pos=" + vector_text(quad.hub[k][0], quad.hub[k][1], 0) + "/>";
      motors += "<motor site=" + name + " gear=\"0 0 1 0 0 " +
                text(-quad.direction[k] * quad.moment_ratio) + "\"/>";
    }
    bodies += "</body>";
  }
  return "<mujoco><option timestep=\"" + text(quad.dt) +
         "\" gravity=" + vector_text(0, 0, -quad.g) +
         " integrator=\"Euler\"><flag contact=\"disable\" constraint=\"disable\" "
         "passive=\"disable\" sensor=\"disable\" clampctrl=\"disable\" warmstart=\"disable\"/>"
         "</option><worldbody>" +
         bodies + "</worldbody><actuator>" + motors + "</actuator></mujoco>";
}

struct Delete {
  void operator()(mjModel* model) const { mj_deleteModel(model); }
  void operator()(mjData* data) const { mj_deleteData(data); }
};

std::unique_ptr<mjModel, Delete> load(const std::string& description) {
  const char* name = "world.xml";
  mjVFS files;
  mj_defaultVFS(&files);
  mj_makeEmptyFileVFS(&files, name, static_cast<int>(description.size()));
  std::memcpy(files.filedata[0], description.data(), description.size());
  char error[500] = "";
  std::unique_ptr<mjModel, Delete> model(mj_loadXML(name, &files, error, sizeof error));
  mj_deleteVFS(&files);
  if (!model) {
    std::fprintf(stderr, "MuJoCo cannot read its world: %s\n", error);
    std::exit(1);
  }
  return model;
}

template <Rotors kRotors>
class MujocoWorld {
 public:
  explicit MujocoWorld(int robots)
      : robots_(robots),
        model_(load(describe(robots, kRotors))),
        data_(mj_makeData(model_.get())) {}

  void start() {
    std::copy_n(model_->qpos0, model_->nq, data_->qpos);
    std::fill_n(data_->qvel, model_->nv, 0.0);
  }

  void step(const double* thrusts, double* states) {
    if constexpr (kRotors == Rotors::kMotors) {
      std::copy_n(thrusts, 4 * robots_, data_->ctrl);
    } else {
      for (int robot = 0; robot < robots_; ++robot) apply(robot, rotor_wrench(thrusts + 4 * robot));
    }
    mj_step(model_.get(), data_.get());
    for (int robot = 0; robot < robots_; ++robot, states += kStates) {
      std::copy_n(data_->qpos + 7 * robot, 7, states);
      std::copy_n(data_->qvel + 6 * robot, 6, states + 7);
    }
  }

 private:
  /// A free joint takes forces in world axes and moments in body axes.
  void apply(int robot, const Wrench& wrench) {
    const double* q = data_->qpos + 7 * robot + 3;
    double* force = data_->qfrc_applied + 6 * robot;
    force[0] = 2 * (q[1] * q[3] + q[0] * q[2]) * wrench.thrust;
    force[1] = 2 * (q[2] * q[3] - q[0] * q[1]) * wrench.thrust;
    force[2] = (1 - 2 * (q[1] * q[1] + q[2] * q[2])) * wrench.thrust;
    std::copy_n(wrench.moment, 3, force + 3);
  }

  int robots_;
  std::unique_ptr<mjModel, Delete> model_;
  std::unique_ptr<mjData, Delete> data_;
};

template <Rotors kRotors>
void measure(const char* mode, const Effort& effort) {
  const std::string engine = std::string("MuJoCo ") + mj_versionString();
  const Peer peer{"mujoco_cpp", mj_versionString(), engine.c_str(),
                  "no contact; no rotor lag; thrusts as commands; no observation, reward or ends"};
  for (const int robots : effort.robots()) {
    MujocoWorld<kRotors> world(robots);
    print_row(peer, mode, world, robots, effort);
  }
}

int run(int count, char** words) {
  const Effort effort = parse(count, words);
  measure<Rotors::kWrench>("mj_step in C, wrench by qfrc_applied", effort);
  measure<Rotors::kMotors>("mj_step in C, motors at sites", effort);
  return 0;
}

}  // namespace
}  // namespace skybody::bench

int main(int count, char** words) { return skybody::bench::run(count, words); }
