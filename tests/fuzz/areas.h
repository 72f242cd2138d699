// Factory functions of the areas. The table of areas is in areas.cpp.
#pragma once

#include "tests/fuzz/area.h"

namespace skybody::fuzz {

std::unique_ptr<Area> make_scenario_area(const AreaOptions& options);
std::unique_ptr<Area> make_override_area(const AreaOptions& options);
std::unique_ptr<Area> make_urdf_area(const AreaOptions& options);
std::unique_ptr<Area> make_mesh_area(const AreaOptions& options);
std::unique_ptr<Area> make_picture_area(const AreaOptions& options);
std::unique_ptr<Area> make_rotors_area(const AreaOptions& options);
std::unique_ptr<Area> make_policy_area(const AreaOptions& options);
std::unique_ptr<Area> make_replay_area(const AreaOptions& options);
std::unique_ptr<Area> make_state_area(const AreaOptions& options);
std::unique_ptr<Area> make_action_area(const AreaOptions& options);
std::unique_ptr<Area> make_plugin_area(const AreaOptions& options);

}  // namespace skybody::fuzz
