// Keys of scenario files and rotor files, each declared once. The declarations define reading and
// validation, messages about unknown keys, the JSON schema and the documentation.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/base/math/quat.h"
#include "core/base/math/vec3.h"
#include "core/io/yaml/config_tree.h"
#include "core/io/yaml/diagnostics.h"
#include "core/io/yaml/plugin_catalog.h"
#include "core/model/parameter_spec.h"

namespace skybody {

struct MapSpec;

/// A key: a value, or a map of further keys.
struct Field {
  enum class Kind {
    kValue,       ///< described by `value`
    kMap,         ///< one map with the keys of `map`
    kMapList,     ///< a list of such maps
    kNamedMaps,   ///< a map from names to such maps
    kPlugin,      ///< one plugin use
    kPluginList,  ///< a list of plugin uses
  };

  ParameterSpec value;  ///< name, doc and required apply to every kind
  Kind kind = Kind::kValue;
  const MapSpec* map = nullptr;
  SkybodyKind plugin = SKYBODY_TASK;
  std::string word;         ///< kValue: a text allowed in place of the number
  std::string short_key;    ///< kMapList: a text in place of a map is the value of this key
  bool identifier = false;  ///< kValue: a text that must be valid in a path
};

/// A map with a fixed set of keys.
struct MapSpec {
  std::string name;  ///< for messages and documentation
  std::string doc;
  std::vector<Field> fields;

  const Field* find(const std::string& key) const;
  std::vector<std::string> names() const;
};

/// Builders of fields. Ranges are inclusive.
Field real_field(std::string name, std::string unit, double value, double min, double max,
                 std::string doc);
Field integer_field(std::string name, int value, double min, double max, std::string doc);
Field boolean_field(std::string name, bool value, std::string doc);
Field text_field(std::string name, std::string value, std::string doc);
Field choice_field(std::string name, std::vector<std::string> choices, std::string doc);
Field name_field(std::string doc);
/// A list of one or more texts.
Field list_field(std::string name, std::string doc);
Field vector_field(std::string name, std::string unit, std::vector<double> value, double min,
                   double max, std::string doc);
Field map_field(std::string name, Field::Kind kind, const MapSpec& map, std::string doc);
Field plugin_field(std::string name, Field::Kind kind, SkybodyKind plugin, std::string doc);
Field required(Field field);
/// A list of maps. An entry may be a text: the value of `key`.
Field short_form(std::string key, Field field);

/// Reads the values of one map. Reading a key that the spec does not declare is a bug of Skybody
/// (std::logic_error). After an error a value is its default, so that reading continues.
class MapReader {
 public:
  /// If `node` is null (absent), all values are defaults, and a missing required key is an error at
  /// `owner`. Reports unknown keys. The arguments must outlive the reader.
  MapReader(const ConfigNode* node, const MapSpec& spec, const SourceLocation& owner,
            Diagnostics& diagnostics);

  double real(const std::string& key) const;
  int integer(const std::string& key) const;
  bool boolean(const std::string& key) const;
  std::string text(const std::string& key) const;
  std::vector<std::string> texts(const std::string& key) const;
  Vec3<double> vec3(const std::string& key) const;
  std::vector<double> numbers(const std::string& key) const;
  /// The number, or nullopt if the file has the field's word.
  std::optional<double> real_or_word(const std::string& key) const;

  /// Whether the spec declares the key.
  bool knows(const std::string& key) const { return spec_.find(key) != nullptr; }
  /// The node of `key`, or null.
  const ConfigNode* node(const std::string& key) const;
  /// The location of `key`, or else of the map.
  SourceLocation mark(const std::string& key) const;
  SourceLocation mark() const { return mark_; }

 private:
  const Field& field(const std::string& key) const;
  ParameterValue value(const std::string& key) const;

  const ConfigNode* node_;
  const MapSpec& spec_;
  SourceLocation mark_;
  Diagnostics& diagnostics_;
};

}  // namespace skybody
