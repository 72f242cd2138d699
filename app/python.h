// The Python that draws pictures, trains and tunes gains.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace skybody {

/// The words that start it: SKYBODY_PYTHON, the one that this program was built with, or `python3`;
/// then -P, lest Python imports from the working folder: a stranger's `numpy.py` would run.
std::vector<std::string> python_command();

/// The script that draws flight logs.
std::filesystem::path plot_script();

/// For programs that are started. In a source tree its folder `python` comes first on PYTHONPATH,
/// so that they find the package of this very build; an installed program leaves that to its
/// Python. Empty entries, which mean the working folder, are left out. Where memory is limited,
/// NumPy's BLAS has one thread, if nobody says otherwise: each takes 40 MB.
void set_python_environment();

/// @throws Error where the address space has a limit (`ulimit -v`) with which NumPy's import would
///         end the process with words and a status of its own
void check_memory_for_python();

}  // namespace skybody
