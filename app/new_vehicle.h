// A vehicle to start from, by its size and the scaling laws of the randomizer `vehicle`.
#pragma once

#include <filesystem>
#include <string>

namespace skybody {

/// What is known of it.
struct VehicleOptions {
  std::string name = "vehicle";
  std::filesystem::path folder = ".";
  double mass = 0.0;              ///< [kg]
  double arm = 0.0;               ///< of a hub from the middle [m]
  double thrust_to_weight = 0.0;  ///< all rotors at their largest speed, by the weight
  int rotors = 4;                 ///< even: as many of one sense as of the other
  std::string layout = "x";       ///< x: two arms beside the x axis; plus: one along it
};

/// Writes the folder `options.folder`/`options.name`: a URDF, rotors.yaml, a scenario that flies it
/// and a README. @returns the new folder
/// @throws Error if the name is none, if no rotors that files may have carry it on such arms, if
/// the folder exists, or if it cannot be written
std::filesystem::path write_new_vehicle(const VehicleOptions& options);

}  // namespace skybody
