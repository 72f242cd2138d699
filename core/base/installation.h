// Where this copy of Skybody lies: in its build tree or in an install prefix.
#pragma once

#include <filesystem>
#include <string>

namespace skybody {

/// The folder of libskybody, without symbolic links.
std::filesystem::path library_folder();

/// A folder of shipped files: share/skybody/NAME of the prefix, or `source_folder` of the source
/// tree that this library was built from. Empty if neither exists.
std::filesystem::path shipped_data(const std::string& name, const std::string& source_folder);

}  // namespace skybody
