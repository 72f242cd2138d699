#include "tests/fuzz/areas.h"
#include "tests/fuzz/model_area.h"

namespace skybody::fuzz {
namespace {

using namespace std::string_literals;

const char* const kShipped[] = {
    "models/qdrone2/qdrone2.urdf",           "models/qdrone2_payload/qdrone2_payload.urdf",
    "models/qdrone2_boom/qdrone2_boom.urdf", "models/crazyflie/crazyflie.urdf",
    "models/firefly/firefly.urdf",           "models/hummingbird/hummingbird.urdf",
    "models/firefly_arm/firefly_arm.urdf"};

/// Joints and shapes that no shipped model has.
const char* const kOwn = R"(<?xml version="1.0"?>
<robot name="crane">
  <link name="world"/>
  <joint name="slide" type="prismatic">
    <parent link="world"/><child link="cart"/><axis xyz="1 0 0"/>
    <limit lower="-1" upper="1" effort="10" velocity="2"/><dynamics damping="0.1"/>
  </joint>
  <link name="cart">
    <inertial><origin xyz="0 0 0.1" rpy="0 0.1 0"/><mass value="2"/>
      <inertia ixx="0.02" ixy="0" ixz="0" iyy="0.02" iyz="0" izz="0.02"/></inertial>
    <collision><geometry><cylinder radius="0.1" length="0.2"/></geometry></collision>
  </link>
  <joint name="turn" type="continuous">
    <parent link="cart"/><child link="arm"/><origin xyz="0 0 0.2" rpy="0 0 1"/><axis xyz="0 1 1"/>
  </joint>
  <link name="arm">
    <inertial><mass value="0.5"/>
      <inertia ixx="0.001" ixy="0" ixz="0" iyy="0.001" iyz="0" izz="0.001"/></inertial>
    <visual><geometry><mesh filename="arm.stl" scale="1 1 1"/></geometry></visual>
    <collision><origin xyz="0 0 0.5"/><geometry><sphere radius="0.05"/></geometry></collision>
    <collision><geometry><box size="0.1 0.1 1"/></geometry></collision>
  </link>
</robot>
)";

const std::vector<std::string> kUrdfWords = {
    "&",
    "&amp;",
    "&#10;",
    "&#0;",
    "&lt;",
    "&quot;",
    "&#xffffffff;",
    "\n",
    "<!--",
    "-->",
    "<![CDATA[",
    "]]>",
    "<?xml?>",
    "<!DOCTYPE x>",
    "</robot>",
    "</link>",
    "<link name=\"a\"/>",
    "<joint/>",
    "fixed",
    "revolute",
    "continuous",
    "prismatic",
    "floating",
    "planar",
    "spherical",
    "world",
    "base_link",
    "rod",
    "bob",
    "mesh filename=\"/etc/hostname\"",
    "file:///etc/hostname",
    "package://x/y.stl",
    "../../../../etc/hostname",
    "/dev/zero",
    "\xff",
    "\0"s,
    "\xe2\x80\xa8",
    "\x1b",
    "parent",
    "child",
    "axis",
    "limit",
    "mimic",
    "inertial",
    "inertia",
    "collision",
    "visual",
    "geometry",
    "box",
    "cylinder",
    "sphere",
    "mesh",
    "origin",
    "mass",
    "transmission",
    "xacro:macro",
    ("<inertial><mass value=\"1\"/><inertia ixx=\"1\" ixy=\"0\" ixz=\"0\" iyy=\"1\" iyz=\"0\" "
     "izz=\"1\"/></inertial>"),
    "<geometry><sphere radius=\"1\"/></geometry>",
    "<mass value=\"1e300\"/>",
    "<mass value=\"5e-324\"/>",
    "<origin xyz=\"1e200 0 0\" rpy=\"0 0 0\"/>"};

constexpr const char* kScenario = R"(robots:
  - name: quad
    model: models/fuzz/input.urdf
    rotors: none
    pose: {position: [0, 0, 1]}
    controllers: [{plugin: wrench, parameters: {max_moment: [1, 1, 1]}}]
task: {plugin: hover}
)";

class UrdfArea : public ModelArea {
 public:
  UrdfArea() : ModelArea("models/fuzz/input.urdf", kScenario) {
    for (const char* name : kShipped) material_.seeds.push_back(shipped(name));
    material_.seeds.emplace_back(kOwn);
    material_.words = kUrdfWords;
  }

  void begin(const std::filesystem::path& folder) override {
    std::filesystem::create_directories(folder / "models/fuzz");
    ModelArea::begin(folder);
  }
};

}  // namespace

std::unique_ptr<Area> make_urdf_area(const AreaOptions&) { return std::make_unique<UrdfArea>(); }

}  // namespace skybody::fuzz
