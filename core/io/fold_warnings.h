// One warning for each kind, in place of one for each element.
#pragma once

#include "core/io/diagnostics.h"

namespace skybody {

/// The messages with warnings of one kind folded into the first of them, which then says in which
/// lines the others are. Of one kind are warnings about one file whose texts differ in nothing but
/// names in `` and numbers. Errors stay as they are. A list from which errors were left out, since
/// there were too many, is returned unchanged.
Diagnostics fold_warnings(const Diagnostics& diagnostics);

}  // namespace skybody
