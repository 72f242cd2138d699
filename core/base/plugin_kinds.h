/* The kinds of plugins: the one list. Plain C, part of the contract (plugins/api/abi.h).
 *
 * A row: symbol, class that authors derive from, word, folder of the shipped ones, step function (a
 * member of SkybodyKernels). A kind's number is its row: new ones go to the end.
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
