// Random keys of copies: what makes `fork(rekey)` give every copy random numbers of its own.
#pragma once

#include "core/base/hash.h"
#include "core/env/state_group.h"

namespace skybody {

/// Notes in the parent that one more copy with a key of its own is about to be made.
inline void count_fork(StateGroup& group, int lane) { ++group.writable(kForks)[lane]; }

/// Gives a fresh copy of a parent, counted by count_fork, its own key: a function of the parent's
/// key and of how many such copies the parent has made.
inline void give_fork_key(StateGroup& group, int lane) {
  HashChain key;
  key.update(group.bits(kStreamEnv)[lane]);
  key.update(group.bits(kForks)[lane]);
  group.writable(kStreamEnv)[lane] = key.value();
  group.writable(kForks)[lane] = 0;
}

}  // namespace skybody
