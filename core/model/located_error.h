// A user's error with its location in a file.
#pragma once

#include <string>
#include <utility>

#include "core/base/system/error.h"
#include "core/base/system/printable.h"
#include "core/model/scenario.h"

namespace skybody {

class LocatedError : public Error {
 public:
  LocatedError(SourceLocation where, const std::string& message)
      : Error(printable(message)), mark_(std::move(where)) {}
  const SourceLocation& mark() const { return mark_; }

 private:
  SourceLocation mark_;
};

}  // namespace skybody
