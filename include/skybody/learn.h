// Everything that lab code includes to train in its own process: a learner on a scenario, one
// rollout and its update at a time, and the policy file that `skybody run --policy` flies.
// make_learner() makes either.
#pragma once

#include "core/assemble/load.h"
#include "core/io/policy_writer.h"
#include "learn/gradient/gradient.h"
#include "learn/hyperparameter_text.h"
#include "learn/learner.h"
#include "learn/make_learner.h"
#include "learn/ppo/ppo.h"
