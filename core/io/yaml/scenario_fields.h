// The keys of a scenario file and of rotors.yaml, each with its unit, default, range and meaning.
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <string>

#include "core/io/yaml/field.h"
#include "core/model/constants.h"

namespace skybody {

/// Largest numbers of entries in lists. Building a world with that many takes about a second; no
/// realistic scenario needs more.
inline constexpr std::size_t kMostRobots = 1000;
inline constexpr std::size_t kMostTeams = 1000;
inline constexpr std::size_t kMostObstacles = 1000;
/// Couplings are solved as one system of equations.
inline constexpr std::size_t kMostCouplings = 64;
inline constexpr std::size_t kMostPluginUses = 1000;
inline constexpr std::size_t kMostRotors = 1000;
inline constexpr std::size_t kMostObserved = 1000;

/// Words of `integrator`, in the order of IntegratorChoice.
inline constexpr std::array<const char*, 5> kIntegratorNames = {"midpoint", "semi_implicit_euler",
                                                                "rk4", "cvode", "arkode"};

/// Words of a coupling's `kind`, in the order of CouplingKind.
inline constexpr std::array<const char*, 4> kCouplingNames = {"rod", "rope", "point", "spring"};

/// "`robots` has 2000 entries; allowed: at most 1000".
std::string too_many_entries(const std::string& key, std::size_t count, std::size_t most);

/// The whole scenario.
const MapSpec& scenario_fields();
const MapSpec& stepping_fields();
/// `solver` of `stepping`.
const MapSpec& solver_fields();
const MapSpec& contact_fields();
/// One entry of `robots`.
const MapSpec& robot_fields();
const MapSpec& pose_fields();
const MapSpec& disturbance_fields();
/// One entry of a robot's `joints`.
const MapSpec& joint_fields();
/// One entry of `teams`.
const MapSpec& team_fields();
/// One entry of `obstacles`.
const MapSpec& obstacle_fields();
/// `height_field` of an obstacle.
const MapSpec& height_field_fields();
/// One entry of `couplings`.
const MapSpec& coupling_fields();
/// One of its `ends`.
const MapSpec& coupling_end_fields();
/// One entry of `observe`.
const MapSpec& observed_fields();
/// One use of a plugin: `plugin`, `name`, `parameters`.
const MapSpec& plugin_use_fields();
/// A rotors file.
const MapSpec& rotors_file_fields();
/// One entry of `rotors` in it; `defaults` has the same keys.
const MapSpec& rotor_fields();

/// Reads those constants whose keys the reader's map declares.
/// @param values  of the constants' owner; each constant is stored at its own index
void read_constants(const MapReader& reader, std::span<const ConstantRow> rows, double* values);

/// Every map above as Markdown tables of its keys.
std::string scenario_reference();

}  // namespace skybody
