// Numbers in messages.
#pragma once

#include "core/base/number_text.h"  // IWYU pragma: export
