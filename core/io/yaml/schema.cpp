#include "core/io/yaml/schema.h"

#include <cmath>

#include "core/io/files/json.h"
#include "core/io/files/text.h"
#include "core/io/yaml/field.h"
#include "core/io/yaml/parameter_reader.h"
#include "core/io/yaml/scenario_fields.h"

namespace skybody {
namespace {

std::string reference(const std::string& name) {
  return JsonObject().set_text("$ref", "#/definitions/" + name).text();
}

std::string words(const std::vector<std::string>& texts) {
  std::vector<std::string> list;
  for (const std::string& text : texts) list.push_back(json_string(text));
  return json_array(list);
}

/// The schema of one entry of a value, without its description.
JsonObject entry_schema(const ParameterSpec& spec) {
  JsonObject entry;
  switch (spec.type) {
    case ParameterType::kReal:
      entry.set_text("type", "number");
      break;
    case ParameterType::kInteger:
      entry.set_text("type", "integer");
      break;
    case ParameterType::kBoolean:
      entry.set_text("type", "boolean");
      break;
    case ParameterType::kText:
      entry.set_text("type", "string");
      break;
  }
  if (!spec.choices.empty()) entry.set("enum", words(spec.choices));
  const bool number = spec.type == ParameterType::kReal || spec.type == ParameterType::kInteger;
  if (number && std::isfinite(spec.min)) {
    entry.set(spec.min_exclusive ? "exclusiveMinimum" : "minimum", format_number(spec.min));
  }
  if (number && std::isfinite(spec.max)) entry.set("maximum", format_number(spec.max));
  return entry;
}

/// The default as JSON, or an empty text.
std::string default_json(const ParameterSpec& spec) {
  std::vector<std::string> values;
  for (const std::string& text : spec.default_texts) values.push_back(json_string(text));
  for (double value : spec.default_numbers) {
    if (!std::isfinite(value)) return "";  // JSON has no infinities
    const bool boolean = spec.type == ParameterType::kBoolean;
    values.push_back(boolean ? (value != 0.0 ? "true" : "false") : format_number(value));
  }
  if (spec.required || (spec.is_scalar() && values.empty())) return "";
  return spec.is_scalar() ? values[0] : json_array(values);
}

std::string description_of(const ParameterSpec& spec) {
  std::string text = spec.doc;
  if (!spec.unit.empty()) text += " [" + spec.unit + "]";
  if (spec.randomizable) text += " (randomizable)";
  return text;
}

JsonObject array_schema(const ParameterSpec& spec) {
  JsonObject array;
  array.set_text("type", "array").set("items", entry_schema(spec).text());
  array.set("minItems", std::to_string(spec.min_count));
  if (spec.max_count >= 0) array.set("maxItems", std::to_string(spec.max_count));
  return array;
}

/// The schema of a value. `broadcast`: one number may replace a list of fixed length.
std::string value_schema(const ParameterSpec& spec, const std::string& word, bool broadcast) {
  JsonObject schema;
  schema.set_text("description", description_of(spec));
  const std::string standard = default_json(spec);
  if (!standard.empty()) schema.set("default", standard);
  const JsonObject form = spec.is_scalar() ? entry_schema(spec) : array_schema(spec);
  std::vector<std::string> forms = {form.text()};
  const bool fixed = spec.min_count == spec.max_count && spec.min_count > 1;
  if (broadcast && fixed && spec.type != ParameterType::kText) {
    forms.push_back(entry_schema(spec).text());
  }
  if (!word.empty()) forms.push_back(JsonObject().set_text("const", word).text());
  if (forms.size() == 1) return schema.add(form).text();
  return schema.set("anyOf", json_array(forms)).text();
}

std::string parameters_schema(const std::vector<ParameterSpec>& specs) {
  JsonObject properties;
  std::vector<std::string> required;
  for (const ParameterSpec& spec : specs) {
    properties.set(spec.name, value_schema(spec, "", true));
    if (spec.required) required.push_back(spec.name);
  }
  JsonObject schema;
  schema.set_text("type", "object").set("properties", properties.text());
  schema.set("additionalProperties", "false");
  if (!required.empty()) schema.set("required", words(required));
  return schema.text();
}

/// The schema of one use of a plugin of `kind`, with each plugin's parameters.
std::string plugin_schema(SkybodyKind kind, const PluginCatalog& catalog) {
  std::vector<std::string> cases, docs;
  for (const std::string& name : catalog.names(kind)) {
    const PluginDeclaration* plugin = catalog.find(kind, name);
    if (plugin == nullptr) continue;
    docs.push_back(name + ": " + plugin->doc);
    const std::string is_it =
        JsonObject()
            .set("properties",
                 JsonObject().set("plugin", JsonObject().set_text("const", name).text()).text())
            .text();
    const std::string then =
        JsonObject()
            .set("properties",
                 JsonObject().set("parameters", parameters_schema(plugin->parameters)).text())
            .text();
    cases.push_back(JsonObject().set("if", is_it).set("then", then).text());
  }
  JsonObject properties;
  for (const Field& field : plugin_use_fields().fields) {
    JsonObject property;
    property.set_text("description", field.value.doc);
    if (field.value.name == "plugin") {
      property.set_text("type", "string").set("enum", words(catalog.names(kind)));
    } else {
      property.set_text("type", field.kind == Field::Kind::kMap ? "object" : "string");
    }
    properties.set(field.value.name, property.text());
  }
  JsonObject schema;
  schema.set_text("description", join(docs, "; ")).set_text("type", "object");
  schema.set("properties", properties.text()).set("required", words({"plugin"}));
  schema.set("additionalProperties", "false");
  if (!cases.empty()) schema.set("allOf", json_array(cases));
  return schema.text();
}

/// The schema of one entry of a list of maps.
std::string item_schema(const Field& field) {
  const std::string map = reference(field.map->name);
  if (field.short_key.empty()) return map;
  const std::string text = value_schema(field.map->find(field.short_key)->value, "", false);
  return JsonObject().set("anyOf", json_array({text, map})).text();
}

std::string field_schema(const Field& field) {
  JsonObject schema;
  schema.set_text("description", field.value.doc);
  switch (field.kind) {
    case Field::Kind::kValue:
      return value_schema(field.value, field.word, false);
    case Field::Kind::kMap:
      return schema.set("allOf", json_array({reference(field.map->name)})).text();
    case Field::Kind::kMapList:
      return schema.set_text("type", "array").set("items", item_schema(field)).text();
    case Field::Kind::kNamedMaps:
      return schema.set_text("type", "object")
          .set("additionalProperties", reference(field.map->name))
          .text();
    case Field::Kind::kPlugin:
      return schema.set("allOf", json_array({reference(kind_name(field.plugin))})).text();
    case Field::Kind::kPluginList:
      return schema.set_text("type", "array")
          .set("items", reference(kind_name(field.plugin)))
          .text();
  }
  return schema.text();
}

JsonObject properties_of(const MapSpec& spec) {
  JsonObject properties;
  for (const Field& field : spec.fields) properties.set(field.value.name, field_schema(field));
  return properties;
}

std::vector<std::string> required_of(const MapSpec& spec) {
  std::vector<std::string> names;
  for (const Field& field : spec.fields) {
    if (field.value.required) names.push_back(field.value.name);
  }
  return names;
}

std::string map_schema(const MapSpec& spec) {
  JsonObject schema;
  schema.set_text("description", spec.doc).set_text("type", "object");
  schema.set("properties", properties_of(spec).text()).set("additionalProperties", "false");
  const std::vector<std::string> required = required_of(spec);
  if (!required.empty()) schema.set("required", words(required));
  return schema.text();
}

std::string definitions(const PluginCatalog& catalog) {
  JsonObject list;
  const MapSpec* specs[] = {&stepping_fields(), &contact_fields(),     &pose_fields(),
                            &robot_fields(),    &disturbance_fields(), &joint_fields(),
                            &team_fields(),     &obstacle_fields(),    &height_field_fields(),
                            &observed_fields()};
  for (const MapSpec* spec : specs) list.set(spec->name, map_schema(*spec));
  for (int k = 0; k < SKYBODY_KIND_COUNT; ++k) {
    const auto kind = static_cast<SkybodyKind>(k);
    list.set(kind_name(kind), plugin_schema(kind, catalog));
  }
  return list.text();
}

}  // namespace

std::string scenario_schema(const PluginCatalog& catalog) {
  const MapSpec& spec = scenario_fields();
  const std::string text = R"({"type": "string"})";
  JsonObject include;
  include.set_text("description", "files that this one completes and overrides");
  include.set("anyOf", json_array({text, R"({"type": "array", "items": )" + text + "}"}));
  JsonObject properties = properties_of(spec);
  properties.set("include", include.text());
  JsonObject schema;
  schema.set_text("$schema", "http://json-schema.org/draft-07/schema#");
  schema.set_text("title", "Skybody scenario").set_text("description", spec.doc);
  schema.set_text("type", "object").set("properties", properties.text());
  schema.set("additionalProperties", "false");
  const std::string complete = JsonObject().set("required", words(required_of(spec))).text();
  const std::string partial = JsonObject().set("required", words({"include"})).text();
  schema.set("anyOf", json_array({complete, partial}));
  schema.set("definitions", definitions(catalog));
  return json_indented(schema.text());
}

}  // namespace skybody
