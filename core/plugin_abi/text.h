// Numbers in messages.
#pragma once

#include "core/base/system/number_text.h"  // IWYU pragma: export
