// Turns exceptions into messages on stderr and exit statuses.
#pragma once

#include <string>

#include "app/command_work.h"

namespace skybody {

/// Writes one message. @returns kExitError
int report_error(const std::string& message);

/// Runs the work; every exception becomes one message.
/// @returns the exit status
int run_and_report(const Action& work);

}  // namespace skybody
