#include "core/env/check_writers.h"

#include <map>

#include "core/env/error_location.h"
#include "core/model/located_error.h"

namespace skybody {
namespace {

const std::string& path_of(const Writers& w, int param) {
  return w.layout.param_info[static_cast<std::size_t>(param)].path;
}

/// The setting that makes a randomizer or the task write a parameter.
SourceLocation mark_of(const Writers& w, const PluginInstance& p, int param) {
  const EnvParam& info = w.layout.param_info[static_cast<std::size_t>(param)];
  if (p.kind == SKYBODY_TASK) return mark_of_writer(w.scenario, w.scenario.task, info);
  const auto place = static_cast<std::size_t>(&p - w.randomizers.data());
  return mark_of_writer(w.scenario, w.scenario.randomization[place], info);
}

/// " (line 7)"; empty for a location without a line.
std::string line_of(const SourceLocation& mark) {
  return mark.line == 0 ? "" : " (line " + std::to_string(mark.line) + ")";
}

std::string described(const PluginInstance& first, const std::string& line,
                      const PluginInstance& second) {
  if (first.kind == SKYBODY_RANDOMIZER) {
    return "randomizers `" + first.name + "`" + line + " and `" + second.name + "`";
  }
  return "task `" + first.plugin + "`" + line + " and randomizer `" + second.name + "`";
}

/// The task draws last, after everything else. Parameters other than its own have been read by
/// then.
void check_task(const Writers& w) {
  const Block& own = w.task_params;
  for (const int param : w.task.writes) {
    if (param >= own.offset && param < own.offset + own.size) continue;
    throw LocatedError(w.task.mark, "task `" + w.task.plugin + "` draws " + path_of(w, param) +
                                        ", but a task may draw its own parameters alone");
  }
}

/// Checks that only one plugin draws each value.
void check_single(const Writers& w) {
  std::map<int, const PluginInstance*> writers;
  const auto add = [&](const PluginInstance& p) {
    for (const int param : p.writes) {
      const auto [it, fresh] = writers.emplace(param, &p);
      if (fresh || it->second == &p) continue;
      const bool is_task = it->second->kind == SKYBODY_TASK;
      const std::string line = line_of(mark_of(w, *it->second, param));
      throw LocatedError(
          mark_of(w, p, param),
          described(*it->second, line, p) + " both draw " + path_of(w, param) +
              ": leave it to one of them" +
              (is_task ? "; a task draws no parameter that the scenario gives" : ""));
    }
  };
  add(w.task);
  for (const PluginInstance& randomizer : w.randomizers) add(randomizer);
}

/// Starts are read at resets only: rejects draws of starts during an episode.
void check_starts_in_time(const Writers& w) {
  for (const PluginInstance& r : w.randomizers) {
    if (!r.randomizer.draws_in_time) continue;
    for (const int param : r.writes) {
      if (!w.starts.has(param)) continue;
      throw LocatedError(mark_of(w, r, param),
                         "randomizer `" + r.name + "` draws " + path_of(w, param) +
                             " at a time within the episode, but a start is read at "
                             "resets alone: draw it with `when: reset`");
    }
  }
}

}  // namespace

void check_writers(const Writers& writers) {
  check_task(writers);
  check_single(writers);
  check_starts_in_time(writers);
}

}  // namespace skybody
