// The header for plugin authors.
#pragma once

#include "core/base/math/distribution.h"
#include "core/base/math/jet.h"
#include "core/base/math/math.h"
#include "plugins/api/export.h"
#include "plugins/api/plugin.h"
#include "plugins/api/reference_point.h"
