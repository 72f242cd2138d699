// A loaded scenario as Python holds it.
#pragma once

#include <map>
#include <memory>
#include <string>

#include "core/assemble/load.h"
#include "core/env/environment.h"

namespace skybody::python {

/// Shared with every Pool and Simulation that was made of it; nothing in it changes.
class LoadedEnvironment {
 public:
  /// Releases the GIL while it loads. @throws InputError
  explicit LoadedEnvironment(LoadOptions options);

  const std::shared_ptr<const Environment>& shared() const { return environment_; }
  const Environment& operator*() const { return *environment_; }
  const Environment* operator->() const { return environment_.get(); }
  const LoadOptions& options() const { return options_; }

  /// Versions of the plugins that the scenario uses, by their names.
  std::map<std::string, std::string> plugins() const;
  /// @throws ValueError if nothing randomizable is called so
  const EnvParam& param(const std::string& path) const;

 private:
  LoadOptions options_;
  std::shared_ptr<const Environment> environment_;
};

}  // namespace skybody::python
