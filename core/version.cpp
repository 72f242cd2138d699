#include "core/version.h"

#include <skybody/version.h>

namespace skybody {

const char* version() { return SKYBODY_VERSION; }

}  // namespace skybody
