// A loaded scenario, for Python.
#pragma once

#include <map>
#include <memory>
#include <string>

#include "core/assemble/compile_scenario.h"
#include "core/env/compiled_scenario.h"

namespace skybody::python {

/// Immutable; shared with every PythonPool and Simulation made from it.
class LoadedScenario {
 public:
  /// Releases the GIL during loading. @throws InputError
  explicit LoadedScenario(LoadOptions options);

  const std::shared_ptr<const CompiledScenario>& shared() const { return compiled_; }
  const CompiledScenario& operator*() const { return *compiled_; }
  const CompiledScenario* operator->() const { return compiled_.get(); }
  const LoadOptions& options() const { return options_; }

  /// Versions of the scenario's plugins, by their names.
  std::map<std::string, std::string> plugins() const;
  /// @throws ValueError if there is no such randomizable value, or it is not a vector of `count`
  ///         values
  void check_vector(const std::string& path, std::size_t count) const;
  /// @throws ValueError if there is no such randomizable value, or it is a vector without an index
  void check_one_value(const std::string& path) const;
  /// @throws ValueError if there is no such randomizable value
  const EnvParam& param(const std::string& path) const;

 private:
  LoadOptions options_;
  std::shared_ptr<const CompiledScenario> compiled_;
};

}  // namespace skybody::python
