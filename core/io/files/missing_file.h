// Messages about files that do not exist.
#pragma once

#include <string>
#include <vector>

namespace skybody {

/// The path with its misspelt parts corrected, if that file exists; else empty. A corrected name
/// has the extension of the given one, or nearly so (.yml and .yaml).
std::string similar_file(const std::string& file);

/// "did you mean `x`?" with a file of a similar name, else with the nearest of `names`, else the
/// remedy.
/// @param file    path of the missing file
/// @param names   names accepted in place of a path
std::string missing_file_hint(const std::string& file, const std::string& remedy,
                              const std::vector<std::string>& names = {});

/// "the file `x` does not exist; HINT". Empty if there is something of that name, or if it cannot
/// be a name: read_file() then gives the reason.
std::string missing_file(const std::string& file, const std::string& remedy,
                         const std::vector<std::string>& names = {});

}  // namespace skybody
