// Everything that lab code includes to fly scenarios in its own process.
#pragma once

#include "core/simulation/simulation.h"
#include "core/simulation/simulation_pool.h"
