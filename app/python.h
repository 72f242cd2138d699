// The Python interpreter that draws pictures, trains and tunes gains.
#pragma once

#include <string>
#include <vector>

namespace skybody {

/// The command that starts it: SKYBODY_PYTHON, or the one that this program was built with, or
/// `python3`; then -P, which keeps Python from importing from the working folder, where a
/// stranger's `numpy.py` would run.
std::vector<std::string> python_command();

/// Sets environment variables for child programs:
///   - PYTHONPATH: in a source tree its folder `python` comes first, so that child programs find
///     the package of this build; an installed program does not add it. Empty entries, which mean
///     the working folder, are removed.
///   - If memory is limited, NumPy's BLAS gets one thread, unless the user set a number: each
///     thread takes 40 MB.
void set_python_environment();

/// @throws Error if the address space is limited (`ulimit -v`) so much that NumPy's import would
///         end the process with its own message and status
void check_memory_for_python();

}  // namespace skybody
