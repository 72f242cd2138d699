// Creates a vehicle from its size and the scaling laws of the randomizer `vehicle`.
#pragma once

#include <filesystem>
#include <string>

#include "core/io/yaml/diagnostics.h"
#include "core/plugin_host/new_project.h"

namespace skybody {

/// The given properties.
struct VehicleOptions {
  std::string name = "vehicle";
  std::filesystem::path folder = ".";
  double mass = 0.0;              ///< [kg]
  double arm = 0.0;               ///< distance of a hub from the centre [m]
  double thrust_to_weight = 0.0;  ///< thrust of all rotors at their largest speed over the weight
  int rotors = 4;                 ///< even: half of them turn in each direction
  std::string layout =
      "x";  ///< x: no arm on the x axis, one on either side; plus: one arm along it
};

/// Warnings of unlikely values, with the intended value if a known mistake explains it.
Diagnostics doubts_of_vehicle(const VehicleOptions& options);

/// The files of a vehicle: a URDF, rotors.yaml, a scenario that uses it and a README.
/// @throws Error if the name is invalid, or if no rotors within the ranges of rotor files carry it
///         on such arms
ProjectPart vehicle_part(const VehicleOptions& options);

/// Writes them into the folder `options.folder`/`options.name`. @returns the new folder
/// @throws Error as vehicle_part() and write_new_project()
std::filesystem::path write_new_vehicle(const VehicleOptions& options);

}  // namespace skybody
