// A loaded scenario as Python holds it.
#pragma once

#include <map>
#include <memory>
#include <string>

#include "core/assemble/load.h"
#include "core/env/compiled_scenario.h"

namespace skybody::python {

/// Shared with every PythonPool and Simulation that was made of it; nothing in it changes.
class LoadedScenario {
 public:
  /// Releases the GIL while it loads. @throws InputError
  explicit LoadedScenario(LoadOptions options);

  const std::shared_ptr<const CompiledScenario>& shared() const { return compiled_; }
  const CompiledScenario& operator*() const { return *compiled_; }
  const CompiledScenario* operator->() const { return compiled_.get(); }
  const LoadOptions& options() const { return options_; }

  /// Versions of the plugins that the scenario uses, by their names.
  std::map<std::string, std::string> plugins() const;
  /// @throws ValueError if nothing randomizable is called so, or it is no vector of `count` values
  void check_vector(const std::string& path, std::size_t count) const;
  /// @throws ValueError if nothing randomizable is called so, or it is a vector without an index
  void check_one_value(const std::string& path) const;
  /// @throws ValueError if nothing randomizable is called so
  const EnvParam& param(const std::string& path) const;

 private:
  LoadOptions options_;
  std::shared_ptr<const CompiledScenario> compiled_;
};

}  // namespace skybody::python
