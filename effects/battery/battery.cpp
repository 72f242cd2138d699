// Battery: one pack per robot. The rotors' power reduces the voltage, and the voltage limits their
// speed; an empty pack stops them.
#include <vector>

#include "effects/common/rotors.h"

namespace skybody {
namespace {

class Battery : public Effect {
 public:
  static constexpr bool kSmooth = true;

  void configure(const Setup& setup) override {
    dt_ = setup.dt();
    read_curve();
    if (!(initial_charge_.value() > 0.0)) {
      refuse(
          "`initial_charge` is 0, an empty pack whose rotors never turn: allowed are shares of the "
          "capacity above 0, up to 1");
    }
    for (const int robot : effect::robots_with_rotors(setup, robots_.values(), "`battery`")) {
      Pack pack{robot, {}};
      for (const RotorInfo& rotor : setup.rotors_of(robot)) {
        pack.rotors.push_back(
            {static_cast<int>(&rotor - setup.rotors().begin()), rotor.first_param});
      }
      packs_.push_back(pack);
      check_power(setup, robot);
    }
    const auto count = static_cast<int>(packs_.size());
    setup.holds(HeldInput::kRotorLimit);
    setup.buffer(3 * count);
    for (int p = 0; p < count; ++p) {
      const int robot = packs_[static_cast<std::size_t>(p)].robot;
      setup.offers("battery.charge", robot, p);
      setup.offers("battery.voltage", robot, count + p);
      setup.offers("battery.current", robot, 2 * count + p);
    }
    setup.report("charge", "", count, 0);
    setup.report("voltage", "V", count, count);
    setup.report("current", "A", count, 2 * count);
  }

  template <class Real>
  void reset(const EnvView<Real>& env, State<Real>&, Values<Real> buffer) const {
    const auto count = static_cast<int>(packs_.size());
    for (int p = 0; p < count; ++p) {
      const Real charge = initial_charge_(env);
      buffer.set(p, charge);
      buffer.set(count + p, open_circuit(charge));
      buffer.set(2 * count + p, Real(0.0));
    }
  }

  template <class Real>
  void apply(const EnvView<Real>& env, State<Real>&, Held<Real>& held, Values<Real> buffer) const {
    const auto count = static_cast<int>(packs_.size());
    for (int p = 0; p < count; ++p) {
      const Pack& pack = packs_[static_cast<std::size_t>(p)];
      const Real charge = buffer[p];
      const auto is_empty = charge <= 0.0;
      const Load<Real> load = draw(env, pack, open_circuit(charge));
      const Real current = select(is_empty, Real(0.0), load.current);
      const Real voltage = load.open - internal_resistance_(env) * current;
      limit(env, pack, select(is_empty, Real(0.0), voltage), held);
      buffer.set(p, max(charge - current * (dt_ / 3600.0) / capacity_(env), 0.0));
      buffer.set(count + p, voltage);
      buffer.set(2 * count + p, current);
    }
  }

 private:
  struct Rotor {
    int index;        ///< world index
    int first_param;  ///< first of its constants
  };
  struct Pack {
    int robot;
    std::vector<Rotor> rotors;
  };
  /// A linear section of the open-circuit voltage curve.
  struct Section {
    double first;   ///< coordinate at which it begins: 0, 1, ...
    double lowest;  ///< voltage of the pack at its beginning [V]
    double rise;    ///< increase up to the next section [V]
  };
  template <class Real>
  struct Load {
    Real open;     ///< open-circuit voltage of the pack [V]
    Real current;  ///< [A]
  };

  /// Open-circuit voltage of the pack: linear between the given voltages. Each section whose
  /// beginning the charge has reached overrides the one below it, so no lane needs a table lookup.
  template <class Real>
  SKYBODY_INLINE Real open_circuit(const Real& charge) const {
    const Real place = charge * static_cast<double>(sections_.size());
    Real first(sections_[0].first), lowest(sections_[0].lowest), rise(sections_[0].rise);
    for (std::size_t i = 1; i < sections_.size(); ++i) {
      const Section& section = sections_[i];
      const auto is_reached = place > section.first;
      first = select(is_reached, Real(section.first), first);
      lowest = select(is_reached, Real(section.lowest), lowest);
      rise = select(is_reached, Real(section.rise), rise);
    }
    return lowest + rise * clamp(place - first, 0.0, 1.0);
  }

  /// The current at which the pack delivers the power P = I (V - R I); above the largest power V^2
  /// / (4 R), the current of that power.
  template <class Real>
  SKYBODY_INLINE Load<Real> draw(const EnvView<Real>& env, const Pack& pack,
                                 const Real& open) const {
    Real shafts(0.0);
    for (const Rotor& rotor : pack.rotors) {
      const Real w = env.rotor_speed(rotor.index);
      shafts =
          shafts + env.param(rotor.first_param + SKYBODY_ROTOR_MOMENT_CONSTANT) * (w * w * abs(w));
    }
    const Real four_r = 4.0 * internal_resistance_(env);
    const Real asked = shafts / efficiency_(env) + hotel_power_(env);
    // With zero resistance the largest power is infinite.
    const Real power = min(asked, open * open / four_r);
    const Real root = sqrt(max(open * open - four_r * asked, 0.0));
    return {open, 2.0 * power / (open + root)};  // avoids the cancellation of (V - root) / (2 R)
  }

  template <class Real>
  SKYBODY_INLINE void limit(const EnvView<Real>& env, const Pack& pack, const Real& voltage,
                            Held<Real>& held) const {
    const double given = speed_per_volt_.value();
    for (const Rotor& rotor : pack.rotors) {
      const Real per_volt =
          given > 0.0 ? Real(given)
                      : env.param(rotor.first_param + SKYBODY_ROTOR_MAX_SPEED) * per_full_;
      held.limit_speed(rotor.index, Real(0.0), per_volt * voltage);
    }
  }

  void read_curve() {
    const int count = open_circuit_.count();
    if (count < 2) {
      refuse("`open_circuit` has ", count,
             " values; allowed: at least two, the voltage of an empty and of a full cell");
    }
    const auto cells = static_cast<double>(cells_.value());
    double lowest = cells * open_circuit_.value(0);
    for (int i = 1; i < count; ++i) {
      const double from = open_circuit_.value(i - 1), to = open_circuit_.value(i);
      if (to < from) {
        refuse("`open_circuit[", i, "]` is ", to, " V, below the ", from,
               " V before it: voltages rise with the charge, from an empty cell to a full one");
      }
      sections_.push_back({static_cast<double>(i - 1), lowest, cells * (to - from)});
      lowest += sections_.back().rise;
    }
    full_ = cells * open_circuit_.value(count - 1);
    per_full_ = 1.0 / full_;
  }

  /// Rejects a full pack that cannot power hover: usually a wrong number of cells, or milliohms
  /// given as ohms.
  void check_power(const Setup& setup, int robot) const {
    const double speed = effect::hover_speed(setup, robot);
    double needed = hotel_power_.value();
    for (const RotorInfo& rotor : setup.rotors_of(robot)) {
      needed += rotor.constants[SKYBODY_ROTOR_MOMENT_CONSTANT] * speed * speed * speed /
                efficiency_.value();
    }
    const double resistance = internal_resistance_.value();
    if (needed * 4.0 * resistance <= full_ * full_) return;
    refuse("a full pack gives ", full_ * full_ / (4.0 * resistance), " W at most (", full_,
           " V, `internal_resistance` ", resistance, " ohm), and robot `",
           setup.robots()[robot].name, "` takes ", needed,
           " W to hover: lower `internal_resistance`, or raise `cells`");
  }

  TextsParameter robots_{this,
                         words("robots", "robots with a pack, one each; empty: all with rotors")};
  IntegerParameter cells_{this,
                          integer("cells", "", 4, between(1, 1000), "number of cells in series")};
  RealsParameter open_circuit_{
      this,
      list("open_circuit", "V", {3.27, 3.69, 3.73, 3.77, 3.8, 3.84, 3.87, 3.95, 4.02, 4.11, 4.2},
           between(0.1, 100.0),
           "voltage of a cell without current, at equally spaced charges from empty to full")};
  RealParameter capacity_{this, randomizable(real("capacity", "A h", 3.0, between(1e-6, 1e6),
                                                  "capacity of the pack, from full to empty"))};
  RealParameter internal_resistance_{
      this, randomizable(real("internal_resistance", "ohm", 0.02, between(0.0, 1000.0),
                              "internal resistance of the pack"))};
  RealParameter initial_charge_{
      this, randomizable(real("initial_charge", "", 1.0, between(0.0, 1.0),
                              "charge at the beginning of an episode; 1: full"))};
  RealParameter efficiency_{
      this, randomizable(real("efficiency", "", 0.7, between(0.01, 1.0),
                              "aerodynamic power of the rotors over their power from the pack"))};
  RealParameter hotel_power_{this, randomizable(real("hotel_power", "W", 0.0, between(0.0, 1e6),
                                                     "power of all consumers except the rotors"))};
  RealParameter speed_per_volt_{
      this,
      real("speed_per_volt", "rad/(s V)", 0.0, between(0.0, 1e5),
           "largest speed of a rotor per volt; 0: `max_speed` over the voltage of a full pack")};

  double dt_ = 0.0;
  double full_ = 0.0;              ///< open-circuit voltage of the full pack [V]
  double per_full_ = 0.0;          ///< its inverse [1/V]
  std::vector<Section> sections_;  ///< from empty to full
  std::vector<Pack> packs_;
};

}  // namespace
}  // namespace skybody

SKYBODY_PLUGIN(
    skybody::Battery, "battery", "1.0.0",
    "One battery pack per robot [V, A, A h]: voltage sag, discharge, limit of the rotors' speed.");
