#include "core/io/yaml/observed_reader.h"

#include <optional>
#include <unordered_set>

#include "core/io/files/text.h"
#include "core/io/yaml/field.h"
#include "core/io/yaml/scenario_fields.h"

namespace skybody {
namespace {

/// Converts `imu.specific_force` into the map {channel: imu.specific_force}.
ConfigNode as_map(const ConfigNode& entry) {
  if (!entry.is_scalar()) return entry;
  ConfigNode map;
  map.kind = ConfigNode::Kind::kMap;
  map.mark = entry.mark;
  map.entries.push_back({"channel", entry.mark, entry});
  return map;
}

bool is_path(const std::string& text) {
  const std::size_t dot = text.find('.');
  return dot != text.npos && dot + 1 < text.size() && is_identifier(text.substr(0, dot));
}

/// The number of a key, or nullopt if it is missing or invalid.
std::optional<double> bound(const MapReader& reader, const std::string& key) {
  if (reader.node(key) == nullptr) return std::nullopt;
  const std::vector<double> numbers = reader.numbers(key);
  return numbers.empty() ? std::nullopt : std::optional(numbers[0]);
}

class ObservedReader {
 public:
  explicit ObservedReader(Diagnostics& diagnostics) : diagnostics_(diagnostics) {}

  void read(const ConfigNode& entry) {
    const ConfigNode map = as_map(entry);
    const MapReader reader(&map, observed_fields(), map.mark, diagnostics_);
    if (reader.node("channel") == nullptr) return;  // the reader has reported it
    ObservedChannel observed;
    observed.mark = reader.mark("channel");
    observed.channel = reader.text("channel");
    observed.name = reader.text("name");
    if (observed.name.empty()) observed.name = observed.channel;
    observed.privileged = reader.boolean("privileged");
    observed.low = bound(reader, "low");
    observed.high = bound(reader, "high");
    check(observed, reader);
    list.push_back(std::move(observed));
  }

  std::vector<ObservedChannel> list;

 private:
  void check(const ObservedChannel& observed, const MapReader& reader) {
    if (!is_path(observed.channel)) {
      diagnostics_.error(observed.mark, "`channel` is `" + observed.channel +
                                            "`; allowed: a sensor and its channel, such as "
                                            "imu.specific_force");
    }
    if (observed.low && observed.high && *observed.low > *observed.high) {
      diagnostics_.error(reader.mark("low"), "`low` is " + format_number(*observed.low) +
                                                 ", above `high`, " +
                                                 format_number(*observed.high) + "; exchange them");
    }
    if (!channels_.insert(observed.channel).second) {
      diagnostics_.error(observed.mark, "`" + observed.channel + "` is observed twice; remove one");
    } else if (!names_.insert(observed.name).second) {
      diagnostics_.error(reader.mark("name"),
                         "a second column called `" + observed.name + "`; names must differ");
    }
  }

  Diagnostics& diagnostics_;
  std::unordered_set<std::string> channels_, names_;
};

}  // namespace

std::vector<ObservedChannel> read_observed(const ConfigNode* node, Diagnostics& diagnostics) {
  if (node == nullptr || node->is_null()) return {};
  if (!node->is_sequence()) {
    diagnostics.error(node->mark, "`observe` is " + node->describe() +
                                      "; allowed: a list such as [imu.specific_force]");
    return {};
  }
  if (node->items.size() > kMostObserved) {
    diagnostics.error(node->mark, too_many_entries("observe", node->items.size(), kMostObserved));
    return {};
  }
  ObservedReader reader(diagnostics);
  for (const ConfigNode& entry : node->items) reader.read(entry);
  return std::move(reader.list);
}

}  // namespace skybody
