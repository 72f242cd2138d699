#include "tests/unit/io/fake_catalog.h"

#include <utility>

namespace skybody {
namespace {

ParameterSpec real(const std::string& name, double value, double min, double max) {
  ParameterSpec spec;
  spec.name = name;
  spec.unit = "rad/s";
  spec.doc = "a number";
  spec.default_numbers = {value};
  spec.min = min;
  spec.max = max;
  return spec;
}

ParameterSpec reals(const std::string& name, std::vector<double> value, int max_count) {
  ParameterSpec spec = real(name, 0.0, -100.0, 100.0);
  spec.min_count = max_count < 0 ? 0 : max_count;
  spec.max_count = max_count;
  spec.default_numbers = std::move(value);
  return spec;
}

ParameterSpec text(const std::string& name, std::vector<std::string> choices) {
  ParameterSpec spec;
  spec.name = name;
  spec.doc = "a word";
  spec.type = ParameterType::kText;
  spec.default_texts = {choices.empty() ? "" : choices.front()};
  spec.choices = std::move(choices);
  return spec;
}

ParameterSpec of_type(ParameterSpec spec, ParameterType type) {
  spec.type = type;
  return spec;
}

ParameterSpec required(ParameterSpec spec) {
  spec.required = true;
  return spec;
}

}  // namespace

FakeCatalog::FakeCatalog() {
  add(SKYBODY_CONTROLLER, "rotor_speed", {real("max_speed", 2300.0, 0.0, 1e5)});
  add(SKYBODY_CONTROLLER, "ctbr",
      {text("apply", {"rotors", "body"}), reals("gain", {1, 1, 1}, 3), reals("list", {}, -1),
       of_type(real("order", 1, 1, 4), ParameterType::kInteger),
       of_type(real("filter", 1, 0, 1), ParameterType::kBoolean)});
  add(SKYBODY_CONTROLLER, "broken", {});
  plugins_[SKYBODY_CONTROLLER]["broken"].failure = "it is truncated";
  add(SKYBODY_SENSOR, "imu", {required(text("robot", {})), text("link", {})});
  add(SKYBODY_RANDOMIZER, "start", {text("robot", {})});
  add(SKYBODY_TASK, "hover", {text("robot", {})});
}

void FakeCatalog::add(SkybodyKind kind, const std::string& name,
                      std::vector<ParameterSpec> parameters) {
  PluginDeclaration declaration;
  declaration.kind = kind;
  declaration.name = name;
  declaration.doc = "does \"" + name + "\"";
  declaration.file = "lib" + name + ".so";
  declaration.parameters = std::move(parameters);
  plugins_[kind][name] = std::move(declaration);
}

const PluginDeclaration* FakeCatalog::find(SkybodyKind kind, const std::string& name) const {
  const auto list = plugins_.find(kind);
  if (list == plugins_.end()) return nullptr;
  const auto found = list->second.find(name);
  return found == list->second.end() ? nullptr : &found->second;
}

std::vector<std::string> FakeCatalog::names(SkybodyKind kind) const {
  std::vector<std::string> list;
  const auto found = plugins_.find(kind);
  if (found == plugins_.end()) return list;
  for (const auto& entry : found->second) list.push_back(entry.first);
  return list;
}

std::vector<std::string> FakeCatalog::names_of_any_kind() const { return {"my_own_law"}; }

}  // namespace skybody
