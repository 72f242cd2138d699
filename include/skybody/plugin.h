// The header for plugin authors.
#pragma once

#include "core/base/distribution.h"
#include "core/base/jet.h"
#include "core/base/math.h"
#include "plugins/api/export.h"
#include "plugins/api/plugin.h"
#include "plugins/api/reference_point.h"
