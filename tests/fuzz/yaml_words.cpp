#include "tests/fuzz/yaml_words.h"

#include "core/io/yaml/scenario_fields.h"
#include "tests/fuzz/plugin_source.h"

namespace skybody::fuzz {
namespace {

using namespace std::string_literals;

/// YAML syntax, text that is not valid UTF-8, names of missing files, and values of keys.
const std::vector<std::string> kFixedWords = {
    "&a ",
    "*a",
    "<<: *a\n",
    "? ",
    "- ",
    "---\n",
    "...\n",
    "%YAML 1.2\n",
    "!!binary ",
    "!!int ",
    "!<tag:x> ",
    "|\n  ",
    ">-\n  ",
    "[",
    "]",
    "{",
    "}",
    ": ",
    "# ",
    "'",
    "\"",
    "\t",
    "\r\n",
    "\xff\xfe",
    "\xef\xbb\xbf",
    "\xc3",
    "\xe2\x80\xa8",
    "\0"s,
    "\"\\x00\"",
    "~",
    "null",
    "yes",
    "include: ",
    "#file a.yaml\n",
    "a.yaml",
    "[a.yaml, a.yaml]",
    "input.yaml",
    "hover.yaml",
    "/dev/zero",
    "/dev/null",
    "/proc/self/mem",
    "/",
    "..",
    "/etc/hostname",
    "models/qdrone2",
    "models/qdrone2/qdrone2.urdf",
    "models/qdrone2_payload/qdrone2_payload.urdf",
    "models/qdrone2_boom/qdrone2_boom.urdf",
    "models/racer/rotors.yaml",
    "none",
    "hover",
    "auto",
    "simbody",
    "tree",
    "rk4",
    "cvode",
    "arkode",
    "semi_implicit_euler",
    "midpoint",
    "adams",
    "erk",
    "dirk",
    "quad",
    "base_link",
    "bob",
    "rod_joint",
    "motors",
    "obstacles: [{name: wall, box: [0.1, 0.1, 0.1], position: [0, 0, 1]}]\n",
    "obstacles: [{name: pole, cylinder: [0.1, 0.2]}, {name: ball, sphere: 0.5}]\n",
    "sensors: [{plugin: imu, parameters: {link: base_link}}]\n",
    "contact: {ground: false}\n",
    "gravity: [0, 0, 0]\n"};

void add_keys(const MapSpec& spec, std::vector<std::string>& words) {
  for (const Field& field : spec.fields) words.push_back(field.value.name);
}

}  // namespace

std::vector<std::string> yaml_words() {
  std::vector<std::string> words = kFixedWords;
  for (const MapSpec* spec :
       {&scenario_fields(), &stepping_fields(), &solver_fields(), &contact_fields(),
        &robot_fields(), &pose_fields(), &disturbance_fields(), &joint_fields(), &obstacle_fields(),
        &observed_fields(), &plugin_use_fields(), &rotors_file_fields(), &rotor_fields()}) {
    add_keys(*spec, words);
  }
  for (std::string& word : plugin_words()) words.push_back(std::move(word));
  return words;
}

}  // namespace skybody::fuzz
