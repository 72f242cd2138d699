#include "core/io/yaml/field.h"

#include <algorithm>
#include <stdexcept>
#include <utility>

#include "core/io/files/text.h"
#include "core/io/yaml/parameter_reader.h"
#include "core/io/yaml/ranges.h"

namespace skybody {
namespace {

Field value_field(std::string name, std::string doc, ParameterType type) {
  Field field;
  field.value.name = std::move(name);
  field.value.doc = std::move(doc);
  field.value.type = type;
  return field;
}

}  // namespace

const Field* MapSpec::find(const std::string& key) const {
  for (const Field& field : fields) {
    if (field.value.name == key) return &field;
  }
  return nullptr;
}

std::vector<std::string> MapSpec::names() const {
  std::vector<std::string> list;
  for (const Field& field : fields) list.push_back(field.value.name);
  return list;
}

Field real_field(std::string name, std::string unit, double value, double min, double max,
                 std::string doc) {
  Field field = value_field(std::move(name), std::move(doc), ParameterType::kReal);
  field.value.unit = std::move(unit);
  field.value.default_numbers = {value};
  field.value.min = min;
  field.value.max = max;
  return field;
}

Field integer_field(std::string name, int value, double min, double max, std::string doc) {
  Field field = real_field(std::move(name), "", value, min, max, std::move(doc));
  field.value.type = ParameterType::kInteger;
  return field;
}

Field boolean_field(std::string name, bool value, std::string doc) {
  Field field = value_field(std::move(name), std::move(doc), ParameterType::kBoolean);
  field.value.default_numbers = {value ? 1.0 : 0.0};
  return field;
}

Field text_field(std::string name, std::string value, std::string doc) {
  Field field = value_field(std::move(name), std::move(doc), ParameterType::kText);
  field.value.default_texts = {std::move(value)};
  return field;
}

Field choice_field(std::string name, std::vector<std::string> choices, std::string doc) {
  Field field = text_field(std::move(name), choices.front(), std::move(doc));
  field.value.choices = std::move(choices);
  return field;
}

Field name_field(std::string doc) {
  Field field = text_field("name", "", std::move(doc));
  field.identifier = true;
  return field;
}

Field list_field(std::string name, std::string doc) {
  Field field = value_field(std::move(name), std::move(doc), ParameterType::kText);
  field.value.max_count = -1;
  return field;
}

Field vector_field(std::string name, std::string unit, std::vector<double> value, double min,
                   double max, std::string doc) {
  Field field = real_field(std::move(name), std::move(unit), 0.0, min, max, std::move(doc));
  field.value.min_count = field.value.max_count = static_cast<int>(value.size());
  field.value.default_numbers = std::move(value);
  return field;
}

Field map_field(std::string name, Field::Kind kind, const MapSpec& map, std::string doc) {
  Field field = value_field(std::move(name), std::move(doc), ParameterType::kText);
  field.kind = kind;
  field.map = &map;
  return field;
}

Field plugin_field(std::string name, Field::Kind kind, SkybodyKind plugin, std::string doc) {
  Field field = value_field(std::move(name), std::move(doc), ParameterType::kText);
  field.kind = kind;
  field.plugin = plugin;
  return field;
}

Field required(Field field) {
  field.value.required = true;
  return field;
}

Field short_form(std::string key, Field field) {
  field.short_key = std::move(key);
  return field;
}

MapReader::MapReader(const ConfigNode* node, const MapSpec& spec, const SourceLocation& owner,
                     Diagnostics& diagnostics)
    : node_(node),
      spec_(spec),
      mark_(node != nullptr ? node->mark : owner),
      diagnostics_(diagnostics) {
  if (node_ != nullptr && !node_->is_map()) {
    diagnostics_.error(mark_, "`" + spec_.name + "` is " + node_->describe() +
                                  "; allowed: a map of " + join(spec_.names()));
    node_ = nullptr;
    return;
  }
  if (node_ != nullptr) {
    const std::vector<std::string> names = spec_.names();
    for (const ConfigEntry& entry : node_->entries) {
      if (spec_.find(entry.key) != nullptr) continue;
      diagnostics_.error(entry.key_mark, "unknown key `" + entry.key + "` in `" + spec_.name + "`" +
                                             suggestion(entry.key, names));
    }
  }
  for (const Field& field : spec_.fields) {
    if (!field.value.required || this->node(field.value.name) != nullptr) continue;
    diagnostics_.error(mark_, "`" + spec_.name + "` has no `" + field.value.name +
                                  "`, which is needed: " + field.value.doc);
  }
}

const Field& MapReader::field(const std::string& key) const {
  const Field* found = spec_.find(key);
  if (found == nullptr) throw std::logic_error(spec_.name + " declares no key " + key);
  return *found;
}

const ConfigNode* MapReader::node(const std::string& key) const {
  field(key);
  return node_ == nullptr ? nullptr : node_->find(key);
}

SourceLocation MapReader::mark(const std::string& key) const {
  const ConfigNode* found = node(key);
  return found == nullptr ? mark_ : found->mark;
}

ParameterValue MapReader::value(const std::string& key) const {
  const ParameterSpec& spec = field(key).value;
  const ConfigNode* found = node(key);
  std::optional<ParameterValue> read;
  if (found != nullptr) read = read_value(*found, spec, Broadcast::kNo, diagnostics_);
  return read ? *read : default_value(spec, mark_);
}

double MapReader::real(const std::string& key) const { return value(key).numbers.at(0); }

int MapReader::integer(const std::string& key) const {
  return static_cast<int>(value(key).numbers.at(0));
}

bool MapReader::boolean(const std::string& key) const { return value(key).numbers.at(0) != 0.0; }

std::string MapReader::text(const std::string& key) const {
  const std::string text = value(key).texts.at(0);
  const ConfigNode* found = node(key);
  const bool is_name = found != nullptr && found->is_scalar() && field(key).identifier;
  if (is_name && !is_identifier(text)) {
    diagnostics_.error(found->mark, "`" + key + "` is `" + text +
                                        "`; allowed: letters, digits, '_' and '-', starting with a "
                                        "letter or '_'");
  } else if (is_name && text.size() > kLongestName) {
    diagnostics_.error(found->mark, "`" + key + "` has " + std::to_string(text.size()) +
                                        " letters; allowed: at most " +
                                        std::to_string(kLongestName));
  }
  return text;
}

std::vector<std::string> MapReader::texts(const std::string& key) const { return value(key).texts; }

Vec3<double> MapReader::vec3(const std::string& key) const {
  const std::vector<double> list = numbers(key);
  return {list.at(0), list.at(1), list.at(2)};
}

std::vector<double> MapReader::numbers(const std::string& key) const { return value(key).numbers; }

std::optional<double> MapReader::real_or_word(const std::string& key) const {
  const ConfigNode* found = node(key);
  const std::string& word = field(key).word;
  if (found != nullptr && found->is_scalar() && found->scalar == word) return std::nullopt;
  if (found != nullptr && found->is_scalar() && (found->quoted || !parse_number(found->scalar))) {
    diagnostics_.error(found->mark, "`" + key + "` is " + found->describe() + "; allowed: " +
                                        describe_allowed(field(key).value) + ", or `" + word + "`");
    return field(key).value.default_numbers.at(0);
  }
  return real(key);
}

}  // namespace skybody
