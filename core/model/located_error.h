// A user's error with its location in a file.
#pragma once

#include <string>
#include <utility>

#include "core/base/system/error.h"
#include "core/base/system/printable.h"
#include "core/model/scenario.h"

namespace skybody {

/// what() is "file:line:column: message", or the message alone if the file is unknown.
class LocatedError : public Error {
 public:
  LocatedError(SourceLocation where, const std::string& message)
      : Error(printable((where.file.empty() ? "" : to_string(where) + ": ") + message)),
        mark_(std::move(where)),
        message_(printable(message)) {}
  const SourceLocation& mark() const { return mark_; }
  const std::string& message() const { return message_; }  ///< without the location

 private:
  SourceLocation mark_;
  std::string message_;
};

}  // namespace skybody
