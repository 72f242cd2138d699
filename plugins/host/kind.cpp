#include "plugins/host/kind.h"

namespace skybody {
namespace {
constexpr std::string_view kNames[] = {"controller", "sensor", "randomizer", "task", "plugin"};
}

std::string_view kind_name(SkybodyKind kind) { return kNames[kind]; }

std::optional<SkybodyKind> kind_from_name(std::string_view name) {
  for (int i = 0; i < SKYBODY_KIND_COUNT; ++i) {
    if (kNames[i] == name) return static_cast<SkybodyKind>(i);
  }
  return std::nullopt;
}

}  // namespace skybody
