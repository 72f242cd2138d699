// The header for programs that train in their own process.
//
// A learner on a scenario, one rollout and its update at a time: make_learner(). Presets of a
// scenario: read_preset(). The policy file for `skybody run --policy`: write_policy().
//
// The parts of the learners, for an algorithm of one's own (docs/learners.md): Rollout with its
// RolloutEnvironments, DiscountedReturns, AdvantageEstimator and RunningNormalizer; Network,
// RecurrentNetwork, ImageEncoder and PolicyNetwork with gradients; Adam and TrainedNetwork;
// WeightAverage; draw_noise(), draw_actions() and PolicyLoss.
#pragma once

#include "core/assemble/compile_scenario.h"
#include "core/io/files/policy_writer.h"
#include "learn/common/gaussian.h"
#include "learn/common/normalizer.h"
#include "learn/common/policy_metadata.h"
#include "learn/common/running_moments.h"
#include "learn/common/running_normalizer.h"
#include "learn/gradient/gradient.h"
#include "learn/hyperparameter_text.h"
#include "learn/learner.h"
#include "learn/make_learner.h"
#include "learn/network/adam.h"
#include "learn/network/image_encoder.h"
#include "learn/network/network.h"
#include "learn/network/policy_network.h"
#include "learn/network/recurrent_network.h"
#include "learn/network/trained_network.h"
#include "learn/network/weight_average.h"
#include "learn/ppo/policy_loss.h"
#include "learn/ppo/ppo.h"
#include "learn/preset.h"
#include "learn/rollout/advantage_estimator.h"
#include "learn/rollout/discounted_returns.h"
#include "learn/rollout/rollout.h"
#include "learn/rollout/rollout_environments.h"
