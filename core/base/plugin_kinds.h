/* The kinds of plugins, in the only list. Plain C, part of the plugin ABI (core/plugin_abi/abi.h).
 *
 * A row: symbol, base class for authors, word, folder of the shipped plugins, step function (a
 * member of SkybodyKernels). A kind's number is its row: append new kinds at the end.
 */
#ifndef SKYBODY_BASE_PLUGIN_KINDS_H
#define SKYBODY_BASE_PLUGIN_KINDS_H

// clang-format off
#define SKYBODY_PLUGIN_KINDS(X)                                      \
  X(CONTROLLER, Controller, controller, controllers,   control)     \
  X(SENSOR,     Sensor,     sensor,     sensors,       sense)       \
  X(RANDOMIZER, Randomizer, randomizer, randomization, randomize)   \
  X(TASK,       Task,       task,       tasks,         evaluate)    \
  X(EFFECT,     Effect,     effect,     effects,       apply)
// clang-format on

enum SkybodyKind {
#define SKYBODY_ROW(symbol, type, word, folder, function) SKYBODY_##symbol,
  SKYBODY_PLUGIN_KINDS(SKYBODY_ROW)
#undef SKYBODY_ROW
      SKYBODY_KIND_COUNT
};

#endif /* SKYBODY_BASE_PLUGIN_KINDS_H */
