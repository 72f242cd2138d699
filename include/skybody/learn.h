// The header for programs that train in their own process: a learner on a scenario, one rollout and
// its update at a time, and the policy file for `skybody run --policy`. make_learner() makes a
// learner with either algorithm.
#pragma once

#include "core/assemble/compile_scenario.h"
#include "core/io/files/policy_writer.h"
#include "learn/gradient/gradient.h"
#include "learn/hyperparameter_text.h"
#include "learn/learner.h"
#include "learn/make_learner.h"
#include "learn/ppo/ppo.h"
