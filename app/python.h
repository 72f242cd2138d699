// The Python that draws pictures and tunes gains.
#pragma once

#include <filesystem>
#include <string>

namespace skybody {

/// SKYBODY_PYTHON, the one that this program was built with, or `python3`.
std::string python_interpreter();

/// The script that draws flight logs.
std::filesystem::path plot_script();

/// In a source tree: puts its folder `python` first on PYTHONPATH, so that programs that are
/// started find the package of this very build. An installed program leaves that to its Python.
void find_python_package();

}  // namespace skybody
