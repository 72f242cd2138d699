// Folds similar warnings into one, instead of one for each element.
#pragma once

#include "core/io/yaml/diagnostics.h"

namespace skybody {

/// Folds warnings of one kind into the first of them, which then lists the lines of the others.
/// Warnings are of one kind if they concern one file and their texts differ only in names in `` and
/// numbers. Errors stay unchanged. A list from which errors were omitted, because there were too
/// many, is returned unchanged.
Diagnostics fold_warnings(const Diagnostics& diagnostics);

}  // namespace skybody
