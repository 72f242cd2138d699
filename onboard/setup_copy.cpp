#include "onboard/setup_copy.h"

#include <algorithm>
#include <array>
#include <utility>

#include "core/base/constants.h"
#include "core/base/math/hash.h"

namespace skybody::onboard {
namespace {

const SkybodyTriangles kNoTriangles = {nullptr, nullptr, 0, "is not part of a mission"};
const SkybodyPicture kNoPicture = {nullptr, 0, 0, "is not part of a mission"};

const SkybodyTriangles* no_triangles(void*, std::int32_t) { return &kNoTriangles; }
const SkybodyPicture* no_picture(void*, const char*) { return &kNoPicture; }

}  // namespace

template <class Row, class Texts>
void SetupCopy::copy(std::vector<Row>& to, const Row* from, int count, const Texts& texts) {
  to.assign(from, from + count);
  const auto text = [this](const char*& pointer) {
    pointer = keep(pointer != nullptr ? pointer : "");
  };
  for (Row& row : to) texts(row, text);
}

SetupCopy::SetupCopy(const SetupCopy& other) {
  Writer writer;
  const_cast<SetupCopy&>(other).visit(writer);  // which does not change it
  Reader reader(writer.bytes());
  visit(reader);
  link();
}

SetupCopy::SetupCopy(const SkybodySetup& s, std::vector<SetupValue> values)
    : instance_(s.instance), values_(std::move(values)) {
  scalars_.dt = s.dt;
  scalars_.action_repeat = s.action_repeat;
  scalars_.horizon = s.horizon;
  std::copy_n(s.gravity, 3, scalars_.gravity);
  scalars_.first_world_param = s.first_world_param;
  copy(robots_, s.robots, s.robot_count, [](auto& r, auto& text) { text(r.name); });
  copy(bodies_, s.bodies, s.body_count,
       [](auto& r, auto& text) { text(r.name), text(r.joint_name); });
  copy(links_, s.links, s.link_count, [](auto& r, auto& text) { text(r.name); });
  copy(rotors_, s.rotors, s.rotor_count, [](auto& r, auto& text) { text(r.name); });
  copy(sensors_, s.sensors, s.sensor_count,
       [](auto& r, auto& text) { text(r.name), text(r.channel); });
  copy(chains_, s.chains, s.chain_count, [](auto&, auto&) {});
  copy(shapes_, s.shapes, s.shape_count, [](auto& r, auto& text) { text(r.name), text(r.mesh); });
  copy(params_, s.params, s.param_count, [](auto& r, auto& text) { text(r.path), text(r.alias); });
  link();
}

void SetupCopy::link() {
  value_texts_.assign(values_.size(), {});
  value_rows_.assign(values_.size(), {});
  for (std::size_t k = 0; k < values_.size(); ++k) {
    const SetupValue& v = values_[k];
    for (const std::string& text : v.texts) value_texts_[k].push_back(text.c_str());
    const auto count = std::max(v.numbers.size(), v.texts.size());
    value_rows_[k] = {v.numbers.data(), value_texts_[k].data(), static_cast<std::uint32_t>(count),
                      v.env_param, v.is_given};
  }
  SkybodySetup s{};
  s.instance = keep(instance_);
  s.dt = scalars_.dt;
  s.action_repeat = scalars_.action_repeat;
  s.horizon = scalars_.horizon;
  std::copy_n(scalars_.gravity, 3, s.gravity);
  s.first_world_param = scalars_.first_world_param;
  const auto table = [](const auto& rows, auto& pointer, std::int32_t& count) {
    pointer = rows.data();
    count = static_cast<std::int32_t>(rows.size());
  };
  table(robots_, s.robots, s.robot_count);
  table(bodies_, s.bodies, s.body_count);
  table(links_, s.links, s.link_count);
  table(rotors_, s.rotors, s.rotor_count);
  table(sensors_, s.sensors, s.sensor_count);
  table(chains_, s.chains, s.chain_count);
  table(shapes_, s.shapes, s.shape_count);
  table(params_, s.params, s.param_count);
  table(value_rows_, s.values, s.value_count);
  s.visual_triangles = no_triangles;
  s.obstacle_triangles = no_triangles;
  s.picture = no_picture;
  setup_ = s;
}

void SetupCopy::set_gates(const std::vector<std::vector<double>>& gates) {
  const auto is_gate = [](const SkybodyShapeInfo& s) { return s.kind == SKYBODY_GATE; };
  const auto first = std::find_if(shapes_.begin(), shapes_.end(), is_gate);
  if (first == shapes_.end()) throw Error("the mission has no gates that could be replaced");
  const SkybodyShapeInfo model = *first;
  shapes_.erase(std::remove_if(shapes_.begin(), shapes_.end(), is_gate), shapes_.end());
  int obstacle = 0;
  for (const SkybodyShapeInfo& s : shapes_) obstacle = std::max(obstacle, s.obstacle + 1);
  for (std::size_t k = 0; k < gates.size(); ++k) {
    const std::vector<double>& g = gates[k];
    SkybodyShapeInfo shape = model;
    shape.name = keep("gate_" + std::to_string(k + 1));
    shape.obstacle = obstacle++;
    shape.first_param = static_cast<std::int32_t>(params_.size());
    std::copy_n(g.begin(), 3, shape.position);
    std::copy_n(g.begin() + 3, 4, shape.rotation);
    std::copy_n(g.begin() + 7, 3, shape.size);
    shapes_.push_back(shape);
    std::array<double, SKYBODY_OBSTACLE_CONSTANT_COUNT> values{};
    values[SKYBODY_OBSTACLE_PRESENT] = 1.0;
    std::copy_n(g.begin(), 3, values.begin() + SKYBODY_OBSTACLE_POSITION);
    std::copy_n(g.begin() + 3, 4, values.begin() + SKYBODY_OBSTACLE_ROTATION);
    std::copy_n(g.begin() + 7, 3, values.begin() + SKYBODY_OBSTACLE_SIZE);
    for (std::size_t i = 0; i < values.size(); ++i) {
      const char* path = keep(std::string(shape.name) + "[" + std::to_string(i) + "]");
      params_.push_back({path, "", values[i], -1e9, 1e9});
    }
  }
  for (SetupValue& value : values_) {
    if (value.name == "gates") value.texts.clear();  // all, in this order
  }
  link();
}

std::uint64_t SetupCopy::layout() {
  // Not structures_hash(): programs for one instruction set have smaller descriptors of plugins.
  constexpr std::uint64_t kNumbers[] = {
      sizeof(SkybodyRobotInfo),     sizeof(SkybodyBodyInfo),         sizeof(SkybodyLinkInfo),
      sizeof(SkybodyRotorInfo),     sizeof(SkybodySensorInfo),       sizeof(SkybodyChainInfo),
      sizeof(SkybodyShapeInfo),     sizeof(SkybodyEnvParamInfo),     sizeof(Scalars),
      SKYBODY_ROTOR_CONSTANT_COUNT, SKYBODY_OBSTACLE_CONSTANT_COUNT, SKYBODY_SIGNAL_COUNT,
      SKYBODY_ABI_VERSION};
  return hash_bytes(kNumbers, sizeof kNumbers);
}

}  // namespace skybody::onboard
