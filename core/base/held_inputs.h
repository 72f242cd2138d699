/* Held inputs: the values that effects set for one physics step. The only list. Plain C, part of
 * the plugin ABI (core/plugin_abi/abi.h). Held inputs are constant over dt; the engine evaluates
 * velocity-dependent terms whenever the integrator requests forces.
 *
 * A row: symbol, C++ name, member, owner (body, rotor), values per owner, and their meaning.
 * Without an effect the values are neutral: 0, gains 1, limits 0 and infinity, rates NaN.
 */
#ifndef SKYBODY_BASE_HELD_INPUTS_H
#define SKYBODY_BASE_HELD_INPUTS_H

// clang-format off
#define SKYBODY_HELD_INPUTS(X) \
  X(WIND,        Wind,       wind,        body,  3, "velocity of the air around the body, W [m/s]") \
  X(WRENCH,      Wrench,     wrench,      body,  6, "force [N] at the centre of mass, moment [N m], W axes") \
  X(BODY_DRAG,   BodyDrag,   body_drag,   body,  6, "drag at the centre of mass against the air, per body axis: linear [N s/m], and proportional to the total speed [N s^2/m^2]") \
  X(ROTOR_GAIN,  RotorGain,  rotor_gain,  rotor, 4, "factors on thrust, reaction moment, rotor drag, rolling moment") \
  X(ROTOR_LIMIT, RotorLimit, rotor_limit, rotor, 2, "least and greatest speed [rad/s]") \
  X(ROTOR_RATE,  RotorRate,  rotor_rate,  rotor, 1, "acceleration [rad/s^2] in place of the first-order lag; NaN: the lag") \
  X(ROTOR_FLOW,  RotorFlow,  rotor_flow,  rotor, 3, "coefficients of the air at the hub: drag along the axis [N s^2/(m rad)], flapping moment [N s^2/rad], lift by the flow across the axis [N s^2/m^2]")
// clang-format on

/* Indices within a rotor's flow. */
enum SkybodyRotorFlow {
  SKYBODY_FLOW_AXIAL_DRAG = 0,
  SKYBODY_FLOW_FLAPPING = 1,
  SKYBODY_FLOW_LIFT = 2
};

/* Indices within a rotor's gains. */
enum SkybodyRotorGain {
  SKYBODY_GAIN_THRUST = 0,
  SKYBODY_GAIN_MOMENT = 1,
  SKYBODY_GAIN_DRAG = 2,
  SKYBODY_GAIN_ROLLING = 3
};

enum SkybodyHeldInput {
#define SKYBODY_ROW(symbol, type, member, owner, size, doc) SKYBODY_HELD_##symbol,
  SKYBODY_HELD_INPUTS(SKYBODY_ROW)
#undef SKYBODY_ROW
      SKYBODY_HELD_COUNT
};

#endif /* SKYBODY_BASE_HELD_INPUTS_H */
