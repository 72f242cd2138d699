// Building blocks for authors of tasks: named parts of observations, histories, flight limits,
// verdicts, reward terms, draws. docs/task_kit.md builds a task with them.
#pragma once

#include "plugins/task_kit/attitude.h"
#include "plugins/task_kit/drawn_target.h"
#include "plugins/task_kit/flight_limits.h"
#include "plugins/task_kit/goal_shaping.h"
#include "plugins/task_kit/hausdorff.h"
#include "plugins/task_kit/history.h"
#include "plugins/task_kit/nearest_obstacles.h"
#include "plugins/task_kit/obstacles.h"
#include "plugins/task_kit/parts.h"
#include "plugins/task_kit/robot_parts.h"
#include "plugins/task_kit/shaping.h"
#include "plugins/task_kit/spawn.h"
#include "plugins/task_kit/verdict.h"
