// The one way in which the engine calls a plugin's step functions.
#pragma once

#include <string>

#include "core/env/group_work.h"
#include "core/env/plugin_instance.h"
#include "core/env/state_group.h"
#include "core/model/marked_error.h"

namespace skybody {

/// @throws MarkedError, at the line that names the plugin, if it touched values beyond those that
/// it may
inline void report_misuse(const PluginInstance& plugin, const SkybodyChecks& checks) {
  if (checks.what == nullptr) return;
  throw MarkedError(plugin.mark,
                    "plugin `" + plugin.plugin + "` (" + plugin.name + ") asks for " + checks.what +
                        " value " + std::to_string(checks.index) + "; allowed: " +
                        (checks.size == 0 ? "none" : "0 to " + std::to_string(checks.size - 1)) +
                        "; this is a mistake in the plugin");
}

/// Sizes of what a call hands over, for checked mode.
struct CallSizes {
  int input = 0;
  int output = 0;
  int info = 0;
};

/// Of a call that hands over nothing behind the buffer.
inline CallSizes no_sizes() { return {}; }

/// Calls one step function of an instance.
/// @param view   of the group
/// @param sizes  sizes() gives those of the arguments behind the buffer; asked in checked mode only
template <class Function, class Sizes, class... Arguments>
void call_plugin(Function* function, const PluginInstance& plugin, StateGroup& group,
                 const SkybodyLanes& view, const Sizes& sizes, Arguments... arguments) {
  if (view.checks != nullptr) {
    const CallSizes size = sizes();
    view.checks->bodies_before = plugin.needs_bodies_before ? view.checks->bodies : 0;
    view.checks->contacts = plugin.needs_contacts ? view.checks->bodies : 0;
    const auto pairs = static_cast<int>(plugin.contact_pairs.size());
    const auto reactions = static_cast<int>(plugin.joint_reactions.size());
    view.checks->contact_pairs = pairs > 0 ? plugin.first_contact_pair + pairs : 0;
    view.checks->joint_reactions = reactions > 0 ? plugin.first_joint_reaction + reactions : 0;
    view.checks->buffer = plugin.buffer_words;
    view.checks->scratch = plugin.scratch;
    view.checks->input = size.input;
    view.checks->output = size.output;
    view.checks->info = size.info;
    view.checks->what = nullptr;
  }
  function(plugin.self.get(), &view, group.plugin_bits(plugin.state),
           group.plugin_reals(plugin.buffer), arguments...);
  if (view.checks != nullptr) report_misuse(plugin, *view.checks);
}

}  // namespace skybody
