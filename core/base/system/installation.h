// The location of this copy of Skybody: its build tree or an install prefix.
#pragma once

#include <filesystem>
#include <string>

namespace skybody {

/// The file of libskybody, with symbolic links resolved; of the program if that holds it.
std::filesystem::path library_file();

/// The folder of library_file().
std::filesystem::path library_folder();

/// A folder of shipped files: share/skybody/NAME of the install prefix, or `source_folder` of the
/// source tree of this build. Empty if neither exists.
std::filesystem::path shipped_data(const std::string& name, const std::string& source_folder);

}  // namespace skybody
