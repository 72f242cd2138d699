#include "tests/fuzz/areas.h"

namespace skybody::fuzz {

const std::vector<AreaRow>& area_rows() {
  const auto bytes = byte_mutators(), text = text_mutators();
  // Text mutators are listed twice, since most random byte changes give invalid YAML or XML.
  static const std::vector<AreaRow> rows = {
      {"scenario", make_scenario_area, {text, text, bytes}},
      {"override", make_override_area, {text, text, bytes}},
      {"urdf", make_urdf_area, {text, text, bytes}},
      {"mesh", make_mesh_area, {text, text, bytes}},
      {"picture", make_picture_area, {bytes}},
      {"rotors", make_rotors_area, {text, text, bytes}},
      {"policy", make_policy_area, {bytes}},
      {"replay", make_replay_area, {bytes}},
      {"state", make_state_area, {bytes}},
      {"action", make_action_area, {text, text, bytes}},
      {"plugin", make_plugin_area, {bytes}},
  };
  return rows;
}

}  // namespace skybody::fuzz
