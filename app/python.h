// The Python that draws pictures, trains and tunes gains.
#pragma once

#include <string>
#include <vector>

namespace skybody {

/// The words that start it: SKYBODY_PYTHON, the one that this program was built with, or `python3`;
/// then -P, lest Python imports from the working folder: a stranger's `numpy.py` would run.
std::vector<std::string> python_command();

/// Sets PYTHONPATH for programs that are started. In a source tree its folder `python` comes first,
/// so that they find the package of this very build; an installed program leaves that to its
/// Python. Empty entries, which mean the working folder, are left out.
void set_python_path();

}  // namespace skybody
