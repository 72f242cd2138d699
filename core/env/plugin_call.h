// Calls of plugins' step functions. The engine calls them only here.
#pragma once

#include <algorithm>
#include <optional>
#include <string>

#include "core/base/math/math_double.h"
#include "core/base/simd/fp_environment.h"
#include "core/base/system/plugin_call_trace.h"
#include "core/env/group_workspace.h"
#include "core/env/plugin_instance.h"
#include "core/env/state_group.h"
#include "core/model/located_error.h"

namespace skybody {

/// Throws a LocatedError at the line that names the plugin.
/// @param predicate  the predicate of the message, such as "throws `x`"
[[noreturn]] inline void throw_plugin_error(const PluginInstance& plugin,
                                            const std::string& predicate) {
  throw LocatedError(plugin.mark, "plugin `" + plugin.plugin + "` (" + plugin.name + ") " +
                                      predicate + "; this is a mistake in the plugin");
}

/// Sizes and buffers of a call, for checked mode.
struct CallSizes {
  int input = 0;
  int output = 0;
  int info = 0;
  const char* word = "output";   ///< the author's word for the output
  double* written = nullptr;     ///< of one lane: `output` values that the call must write
  double* informed = nullptr;    ///< of one lane: `info` values that the call must write
  const double* kept = nullptr;  ///< of one lane: `output` values that it may leave unchanged
};

/// The difference between this thread's floating-point mode and the required one, on which the bits
/// of all trajectories depend, such as "rounding"; empty: no difference.
inline std::string changed_fp_mode() {
  std::string parts;
  if (has_standard_fp_environment()) return parts;
  const auto add = [&parts](bool is_changed, const char* part) {
    if (is_changed) parts += (parts.empty() ? "" : ", ") + std::string(part);
  };
#ifdef __SSE2__
  const std::uint32_t changed = _mm_getcsr() ^ kStandardMxcsr;
  add((changed & 0x6000u) != 0, "rounding");
  add((changed & 0x8040u) != 0, "flushing of denormals to zero");
  add((changed & 0x1f80u) != 0, "traps at exceptions");
#else
  add(true, "rounding");
#endif
  return parts;
}

/// Sizes of a call with no values after the buffer.
inline CallSizes no_sizes() { return {}; }

/// One call in checked mode, on groups of one lane.
class CheckedCall {
 public:
  CheckedCall(const PluginInstance& plugin, SkybodyChecks& checks, const CallSizes& sizes)
      : plugin_(plugin), checks_(checks), sizes_(sizes), phase_(plugin.file, phase_of(plugin)) {
    checks.bodies_before = plugin.needs_bodies_before ? checks.bodies : 0;
    checks.contacts = plugin.needs_contacts ? checks.bodies : 0;
    const auto pairs = static_cast<int>(plugin.contact_pairs.size());
    const auto reactions = static_cast<int>(plugin.joint_reactions.size());
    checks.contact_pairs = pairs > 0 ? plugin.memory.first_contact_pair + pairs : 0;
    checks.joint_reactions = reactions > 0 ? plugin.memory.first_joint_reaction + reactions : 0;
    const int offered = plugin.sensor.requested();
    checks.offered = offered > 0 ? plugin.memory.first_offered + offered : 0;
    checks.buffer = plugin.memory.buffer_words;
    checks.scratch = plugin.memory.scratch;
    checks.memo = plugin.memory.memo;
    checks.input = sizes.input;
    checks.output = sizes.output;
    checks.info = sizes.info;
    checks.what = nullptr;
    mark(sizes.written, sizes.output);
    mark(sizes.informed, sizes.info);
  }

  /// @throws LocatedError if the plugin touched values that it may not touch, left one unwritten,
  ///   gave a NaN, or changed the floating-point mode
  void finish() const {
    check_fp_mode();
    if (checks_.what != nullptr) blame_touch();
    check(sizes_.written, sizes_.output, sizes_.word);
    check(sizes_.informed, sizes_.info, "info");
    check_numbers();
  }

 private:
  /// A NaN that no computation produces.
  static constexpr std::uint64_t kUnwritten = 0x7ff45eed0badf00dull;
  static double unwritten() { return bit_cast_real(kUnwritten); }
  static std::string phase_of(const PluginInstance& plugin) {
    return "in a step of `" + plugin.name + "`";
  }

  static void mark(double* values, int count) {
    if (values != nullptr) std::fill_n(values, count, unwritten());
  }
  /// @param values  null: no values to check
  void check(const double* values, int count, const char* word) const {
    for (int k = 0; values != nullptr && k < count; ++k) {
      if (bit_cast_word(values[k]) != kUnwritten) continue;
      throw_plugin_error(plugin_, "has not written " + std::string(word) + " value " +
                                      std::to_string(k) + " of " + std::to_string(count));
    }
  }

  /// Rejects NaN in values that others compute with. Infos are for people and may be NaN.
  void check_numbers() const {
    const double* const values = sizes_.written != nullptr ? sizes_.written : sizes_.kept;
    for (int k = 0; values != nullptr && k < sizes_.output; ++k) {
      if (values[k] == values[k]) continue;
      throw_plugin_error(plugin_, "gives NaN as " + std::string(sizes_.word) + " value " +
                                      std::to_string(k) + " of " + std::to_string(sizes_.output));
    }
  }

  void check_fp_mode() const {
    const std::string changed = changed_fp_mode();
    if (changed.empty()) return;
    set_fp_environment();  // the error report below computes, too
    throw_plugin_error(
        plugin_, "changes the floating-point mode in a step (" + changed +
                     "), on which the bits of all flights rest: what a method changes it puts "
                     "back before it returns");
  }

  [[noreturn]] void blame_touch() const {
    const std::string touched = checks_.what;
    std::string allowed = checks_.size == 0 ? "none" : "0 to " + std::to_string(checks_.size - 1);
    if (touched == "held input") allowed += ", what configure() has not named by `holds()`";
    if (touched == "robot reward") allowed += ", unless configure() calls `robot_rewards()`";
    throw_plugin_error(plugin_,
                       "asks for " + (touched == "output" ? std::string(sizes_.word) : touched) +
                           " value " + std::to_string(checks_.index) + "; allowed: " + allowed);
  }

  const PluginInstance& plugin_;
  SkybodyChecks& checks_;
  CallSizes sizes_;
  PluginPhase phase_;
};

/// Calls one step function of an instance.
/// @param view   of the group
/// @param sizes  sizes() returns the sizes of the arguments after the buffer; called in checked
///   mode only
/// @throws LocatedError if the plugin throws; in checked mode also as CheckedCall
template <class Function, class Sizes, class... Arguments>
void call_plugin(Function* function, const PluginInstance& plugin, StateGroup& group,
                 const SkybodyLanes& view, const Sizes& sizes, Arguments... arguments) {
  std::optional<CheckedCall> checked;
  if (view.checks != nullptr) checked.emplace(plugin, *view.checks, sizes());
  SkybodyLanes own;
  if (plugin.memory.memo > 0) {
    own = view;
    own.memo = group.memo(plugin.memory.first_memo);
  }
  try {
    function(plugin.self.get(), plugin.memory.memo > 0 ? &own : &view,
             group.plugin_bits(plugin.memory.state), group.plugin_reals(plugin.memory.buffer),
             arguments...);
  } catch (const std::exception& error) {
    throw_plugin_error(plugin, "throws in a step: " + std::string(error.what()));
  } catch (...) {
    throw_plugin_error(plugin, "throws in a step something that is no std::exception");
  }
  if (checked) checked->finish();
}

}  // namespace skybody
