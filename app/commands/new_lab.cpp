#include "app/commands/new_lab.h"

#include "app/commands/new_vehicle.h"
#include "core/plugin_host/new_project.h"

namespace skybody {
namespace {

/// The vehicle to start from; the README tells how to replace it.
VehicleOptions first_vehicle(const std::string& name) {
  VehicleOptions vehicle;
  vehicle.name = name;
  vehicle.mass = 0.45;
  vehicle.arm = 0.11;
  vehicle.thrust_to_weight = 4.0;
  return vehicle;
}

ProjectPart in_folder(ProjectPart part, const char* parent) {
  part.folder = std::filesystem::path(parent) / part.name;
  return part;
}

}  // namespace

std::filesystem::path write_new_lab(const std::string& name, const std::filesystem::path& folder) {
  const ProjectPart law = plugin_part(SKYBODY_CONTROLLER, name + "_law");
  const ProjectPart task = plugin_part(SKYBODY_TASK, name + "_task");
  const ProjectPart vehicle = vehicle_part(first_vehicle(name + "_quad"));
  return write_new_project({{name, {"lab"}, {}},
                            in_folder(vehicle, "vehicles"),
                            in_folder(law, "controllers"),
                            in_folder(task, "tasks")},
                           name, folder);
}

}  // namespace skybody
