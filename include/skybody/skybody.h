// The header for programs that run scenarios in their own process: one environment under direct
// control (Simulation), many of them (SimulationPool), many for a learner (Pool).
#pragma once

#include "core/assemble/compile_scenario.h"
#include "core/batch/pool.h"
#include "core/simulation/simulation.h"
#include "core/simulation/simulation_pool.h"
