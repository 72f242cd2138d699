// A user's error that belongs to a place in a file.
#pragma once

#include <string>
#include <utility>

#include "core/base/error.h"
#include "core/base/printable.h"
#include "core/model/scenario.h"

namespace skybody {

class MarkedError : public Error {
 public:
  MarkedError(SourceMark where, const std::string& message)
      : Error(printable(message)), mark_(std::move(where)) {}
  const SourceMark& mark() const { return mark_; }

 private:
  SourceMark mark_;
};

}  // namespace skybody
