#include "core/env/scenario_layout.h"

#include <algorithm>

#include "core/base/system/error.h"
#include "core/env/param_access.h"
#include "core/model/located_error.h"
#include "core/physics/world/world_layout.h"

namespace skybody {
namespace {

/// Gives every block its place. Called once, by lay_out_scenario().
struct ScenarioPlacer {
  ScenarioModel& model;
  const Topology& topology;
  WorldPlan plan;
  const Scenario& scenario = topology.scenario;

  void run() {
    StateLayout& l = plan.layout;
    l.bodies_before.size =
        model.needs_bodies_before ? 13 * static_cast<int>(topology.bodies.size()) : 0;
    l.contacts.size = model.needs_contacts
                          ? SKYBODY_CONTACT_VALUES * static_cast<int>(topology.bodies.size())
                          : 0;
    l.contact_pairs.size = SKYBODY_CONTACT_VALUES * static_cast<int>(model.contact_pairs.size());
    l.joint_reactions.size =
        SKYBODY_REACTION_VALUES * static_cast<int>(model.joint_reactions.size());
    model.observation =
        plan_observation(model.task(), model.plugins[SKYBODY_SENSOR], scenario.observe);
    l.last_observation.size = model.observation.size();
    mark_observed_images();
    for (auto& list : model.plugins) {
      for (PluginInstance& p : list) {
        for (std::size_t i = 0; i < p.effect.holds.size(); ++i) plan.holds[i] |= p.effect.holds[i];
        place_state(p, l.plugin_state.size);
        p.memory.first_memo = l.memo;
        l.memo += p.memory.memo;
      }
    }
    find_readers();
    find_offers();
    list_infos();
    place_outputs(l.plugin_state.size);
    place_held(l.plugin_state.size);
    model.world = std::make_unique<const World>(topology, std::move(plan));
    make_absolute();
  }

  void mark_observed_images() {
    for (const ObservedImage& image : model.observation.images) {
      const ColumnSource source =
          model.observation.columns[static_cast<std::size_t>(image.column)].source;
      model.plugins[SKYBODY_SENSOR][static_cast<std::size_t>(source.sensor)]
          .sensor.has_observed_image = true;
    }
  }

  /// Finds the sensors that other plugins read in every physics step: these are called in every
  /// step.
  void find_readers() {
    for (PluginInstance& sensor : model.plugins[SKYBODY_SENSOR]) {
      const auto is_of_sensor = [&](int first) {
        return first >= sensor.sensor.output &&
               first < sensor.sensor.output + sensor.channel_count();
      };
      for (const auto& list : model.plugins) {
        for (const PluginInstance& p : list) {
          const bool is_called_between = p.kind == SKYBODY_CONTROLLER || p.kind == SKYBODY_EFFECT ||
                                         p.kind == SKYBODY_SENSOR ||
                                         (p.kind == SKYBODY_TASK && p.period > 0);
          if (is_called_between && std::any_of(p.reads.begin(), p.reads.end(), is_of_sensor)) {
            sensor.sensor.is_only_when_read = false;
          }
        }
      }
    }
  }

  /// Finds the words of effects that sensors read.
  void find_offers() {
    for (const PluginInstance& sensor : model.plugins[SKYBODY_SENSOR]) {
      for (const OfferRequest& request : sensor.sensor.requests) {
        const int first = row_of(sensor, request);
        for (int k = 0; k < request.count; ++k) model.offered.push_back(first + k);
      }
    }
  }

  /// Row within plugin_state. The name of an offer begins with that of its plugin.
  int row_of(const PluginInstance& sensor, const OfferRequest& request) const {
    for (const PluginInstance& e : model.plugins[SKYBODY_EFFECT]) {
      for (const Offer& offer : e.effect.offers) {
        const bool is_it = offer.name == request.name && offer.robot == request.robot &&
                           offer.count == request.count;
        if (is_it) return e.memory.buffer + offer.word;
      }
    }
    const std::string robot = scenario.robots[static_cast<std::size_t>(request.robot)].name;
    throw LocatedError(sensor.mark, "sensor `" + sensor.name + "` reads `" + request.name +
                                        "` of robot `" + robot +
                                        "`, and no effect gives it: add the effect `" +
                                        request.name.substr(0, request.name.find('.')) +
                                        "`, or remove the sensor");
  }

  void list_infos() {
    model.info_channels = model.task().task.infos;
    for (const auto& list : model.plugins) {
      for (const PluginInstance& p : list) {
        for (const Report& report : p.reports) {
          model.info_channels.push_back(report.info);
          model.info_channels.back().name = p.name + "." + report.info.name;
        }
      }
    }
    for (const std::string& path : scenario.infos.paths) add_param_infos(path);
  }

  /// Reports randomizable values that the scenario names.
  void add_param_infos(const std::string& path) {
    try {
      for (const int param : find_params(scenario, plan.layout, path)) {
        const auto& all = model.info_params;
        if (std::find(all.begin(), all.end(), param) != all.end()) {
          throw Error("`" + path + "` names " +
                      plan.layout.param_info[static_cast<std::size_t>(param)].path +
                      " a second time: name each value once");
        }
        const EnvParam& info = plan.layout.param_info[static_cast<std::size_t>(param)];
        model.info_params.push_back(param);
        model.info_channels.push_back({info.path, info.unit, 1, info.min, info.max});
      }
    } catch (const Error& error) {
      throw LocatedError(scenario.infos.mark, "`infos`: " + std::string(error.what()));
    }
  }

  static void place_state(PluginInstance& p, int& next) {
    p.memory.state = next;
    p.memory.buffer = next + p.memory.state_words;
    next += p.memory.state_words + p.memory.buffer_words;
  }

  /// Places the last outputs of controllers that others follow and that are not called in every
  /// physics step.
  void place_outputs(int& next) {
    for (const ControllerChain& chain : model.chains) {
      for (int i = chain.first; i + 1 < chain.first + chain.count; ++i) {
        PluginInstance& c = model.plugins[SKYBODY_CONTROLLER][static_cast<std::size_t>(i)];
        if (c.period <= 1) continue;
        c.controller.last_output = {next, c.controller.output_count()};
        next += c.controller.last_output.size;
      }
    }
  }

  /// If several effects contribute to one input, each gets words of its own.
  void place_held(int& next) {
    for (std::size_t i = 0; i < plan.holds.size(); ++i) {
      std::vector<PluginInstance*> holders;
      for (PluginInstance& e : model.plugins[SKYBODY_EFFECT]) {
        if (e.effect.holds[i]) holders.push_back(&e);
      }
      if (holders.size() < 2) continue;
      for (PluginInstance* e : holders) {
        e->effect.held[i] = {next, held_size(plan, static_cast<int>(i))};
        next += e->effect.held[i].size;
      }
    }
  }

  /// Converts places within plugin_state to places within all words.
  void make_absolute() {
    const StateLayout& l = model.layout();
    for (PluginInstance& c : model.plugins[SKYBODY_CONTROLLER]) {
      c.controller.last_output.offset += l.plugin_state.offset;
    }
    for (PluginInstance& e : model.plugins[SKYBODY_EFFECT]) {
      for (std::size_t i = 0; i < e.effect.held.size(); ++i) {
        if (e.effect.held[i].size > 0) {
          e.effect.held[i].offset += l.plugin_state.offset;
        } else if (e.effect.holds[i]) {
          e.effect.held[i] = l.held[i];
        }
      }
    }
  }
};

}  // namespace

void lay_out_scenario(ScenarioModel& model, const Topology& topology, WorldPlan plan) {
  ScenarioPlacer{model, topology, std::move(plan)}.run();
}

}  // namespace skybody
