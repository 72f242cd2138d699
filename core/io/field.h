// Keys of scenario files and rotor files, each declared once: reading with validation, messages
// about unknown keys, the JSON schema and the documentation all come from these declarations.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/base/quat.h"
#include "core/base/vec3.h"
#include "core/io/config_tree.h"
#include "core/io/diagnostics.h"
#include "core/io/plugin_catalog.h"
#include "core/model/parameter_spec.h"

namespace skybody {

struct MapSpec;

/// A key: a value, or a map of further keys.
struct Field {
  enum class Kind {
    kValue,       ///< described by `value`
    kMap,         ///< one map as `map` says
    kMapList,     ///< a list of such maps
    kNamedMaps,   ///< a map from names to such maps
    kPlugin,      ///< one plugin use
    kPluginList,  ///< a list of plugin uses
  };

  ParameterSpec value;  ///< name, doc and required hold for every kind
  Kind kind = Kind::kValue;
  const MapSpec* map = nullptr;
  SkybodyKind plugin = SKYBODY_TASK;
  std::string word;         ///< kValue: this text is allowed in place of the number
  std::string short_key;    ///< kMapList: a text in place of a map is the value of this key
  bool identifier = false;  ///< kValue: a text that can be part of a path
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
/// A list of maps whose entries may be texts, which are the values of `key`.
Field short_form(std::string key, Field field);

/// Reads the values of one map. Asking for a key that the spec does not declare is our bug (throws
/// std::logic_error). After an error a value is its default, so that reading goes on.
class MapReader {
 public:
  /// `node` may be null (absent): everything is its default then, and a missing required key is an
  /// error at `owner`. Unknown keys are reported here. The arguments must outlive the reader.
  MapReader(const ConfigNode* node, const MapSpec& spec, const SourceLocation& owner,
            Diagnostics& diagnostics);

  double real(const std::string& key) const;
  int integer(const std::string& key) const;
  bool boolean(const std::string& key) const;
  std::string text(const std::string& key) const;
  std::vector<std::string> texts(const std::string& key) const;
  Vec3<double> vec3(const std::string& key) const;
  std::vector<double> numbers(const std::string& key) const;
  /// The number, or nothing where the field's word stands instead.
  std::optional<double> real_or_word(const std::string& key) const;

  /// Whether the map has such a key.
  bool knows(const std::string& key) const { return spec_.find(key) != nullptr; }
  /// The node of `key`, or null.
  const ConfigNode* node(const std::string& key) const;
  /// Where `key` was written, or else the map.
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
