// Joint controller: sends commands to joint drives, as position, velocity or effort.
#include <cmath>
#include <limits>
#include <vector>

#include "controllers/common/robot.h"

namespace skybody {
namespace {

class Joint : public Controller {
 public:
  static constexpr bool kSmooth = true;

  void configure(const Setup& setup) override {
    control::require_joints(setup, setup.robot(), joints_.values());
    std::vector<double> low, high;
    for (const std::string& name : joints_.values()) {
      const SkybodyJointDrive drive = drive_of(setup, name);
      setup.joint(drive);
      low.push_back(drive.low);
      high.push_back(drive.high);
    }
    count_ = static_cast<int>(low.size());
    setup.input(Signal::kJoint, low, high);
    setup.output(Signal::kJoint, count_);
  }

  template <class Real>
  void control(const EnvView<Real>&, State<Real>&, ConstValues<Real> input,
               Values<Real> output) const {
    for (int i = 0; i < count_; ++i) output.set(i, input[i]);
  }

 private:
  SkybodyJointMode mode() const {
    if (mode_.value() == "position") return SKYBODY_JOINT_POSITION;
    return mode_.value() == "velocity" ? SKYBODY_JOINT_VELOCITY : SKYBODY_JOINT_EFFORT;
  }

  SkybodyJointDrive drive_of(const Setup& setup, const std::string& name) const {
    const BodyInfo& body = setup.joint(setup.robot(), name);
    const bool is_effort = mode() == SKYBODY_JOINT_EFFORT;
    const double limit = effort_limit_.value() > 0.0 ? effort_limit_.value()
                                                     : std::numeric_limits<double>::infinity();
    SkybodyJointDrive drive{setup.index_of(body), 0,     mode(),       stiffness_.value(),
                            damping_.value(),     limit, tau_.value(), low_bound_.value(),
                            high_bound_.value()};
    if (drive.low == drive.high) take_bounds(body, drive);
    if (is_effort && std::isfinite(limit)) {
      drive.low = std::fmax(drive.low, -limit);
      drive.high = std::fmin(drive.high, limit);
    }
    if (!(drive.low < drive.high)) {
      refuse("joint `", name, "` has no range: give `low` and `high`",
             (is_effort ? ", or `effort_limit`" : ""));
    }
    if (mode() == SKYBODY_JOINT_POSITION && drive.stiffness <= 0.0) {
      refuse("`stiffness` is 0: a position drive needs one [N m/rad] or [N/m]");
    }
    if (mode() == SKYBODY_JOINT_VELOCITY && drive.damping <= 0.0) {
      refuse("`damping` is 0: a velocity drive needs one [N m s/rad] or [N s/m]");
    }
    return drive;
  }

  /// Range of position commands: the joint's limits. Of efforts: the drive's limit.
  void take_bounds(const BodyInfo& body, SkybodyJointDrive& drive) const {
    if (mode() == SKYBODY_JOINT_POSITION && body.joint_is_limited != 0) {
      drive.low = body.joint_lower;
      drive.high = body.joint_upper;
    } else if (mode() == SKYBODY_JOINT_EFFORT) {
      drive.low = -drive.effort_limit;
      drive.high = drive.effort_limit;
      if (!std::isfinite(drive.high)) drive.low = drive.high = 0.0;
    }
  }

  TextsParameter joints_{this, words("joints", "names of the joints, in order")};
  TextParameter mode_{
      this, choice("mode", "effort", {"position", "velocity", "effort"}, "meaning of a command")};
  RealParameter stiffness_{this, real("stiffness", "N m/rad or N/m", 0.0, between(0.0, 1e6),
                                      "stiffness of a position drive")};
  RealParameter damping_{this, real("damping", "N m s/rad or N s/m", 0.0, between(0.0, 1e6),
                                    "damping of a position or velocity drive")};
  RealParameter effort_limit_{this, real("effort_limit", "N m or N", 0.0, between(0.0, 1e6),
                                         "largest effort of a drive; 0: no limit")};
  RealParameter tau_{this, real("tau", "s", 0.0, between(0.0, 100.0),
                                "time constant of the first-order lag of commands; 0: none")};
  RealParameter low_bound_{
      this, real("low", "", 0.0, between(-1e6, 1e6),
                 "command for action -1; low = high: the joint's limits, or the effort limit")};
  RealParameter high_bound_{this,
                            real("high", "", 0.0, between(-1e6, 1e6), "command for action +1")};

  int count_ = 0;  ///< number of joints; their drives clamp commands to the bounds
};

}  // namespace
}  // namespace skybody

SKYBODY_PLUGIN(skybody::Joint, "joint", "1.0.0", "Drives joints by position, velocity or effort.");
