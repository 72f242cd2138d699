// Random keys of copies: `fork(rekey)` gives every copy its own random numbers.
#pragma once

#include "core/base/math/hash.h"
#include "core/env/state_group.h"

namespace skybody {

/// Counts in the parent one more copy with its own key. Call it before the copy is made.
inline void count_fork(StateGroup& group, int lane) { ++group.writable(kForks)[lane]; }

/// Gives a fresh copy of a parent (counted by count_fork) its own key: a function of the parent's
/// key and of the number of such copies made so far.
inline void give_fork_key(StateGroup& group, int lane) {
  HashChain key;
  key.update(group.bits(kEnvId)[lane]);
  key.update(group.bits(kForks)[lane]);
  group.writable(kEnvId)[lane] = key.value();
  group.writable(kForks)[lane] = 0;
}

}  // namespace skybody
