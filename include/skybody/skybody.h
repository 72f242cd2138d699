// Everything that lab code includes to fly scenarios in its own process.
#pragma once

#include "core/assemble/simulation.h"
#include "core/assemble/simulation_pool.h"
