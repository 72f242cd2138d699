// Everything that lab code includes to fly scenarios in its own process: one world (Simulation),
// many under direct control (SimulationPool), many for a learner (VecEnv).
#pragma once

#include "core/assemble/load.h"
#include "core/batch/vec_env.h"
#include "core/simulation/simulation.h"
#include "core/simulation/simulation_pool.h"
