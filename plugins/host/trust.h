// Who may write a library, and so decides which code runs when it is opened.
#pragma once

#include <filesystem>
#include <string>

namespace skybody {

/// Whether somebody other than root and the user of this process may replace `file`. The file, its
/// folder and all folders above must belong to root or the user, and others must not write them.
/// The user's private group (of the user's name, without other members) may. Folders above the
/// file's own may be sticky, as /tmp is: others can add names there, but not replace ours.
/// @param file  a canonical path
/// @returns who may write what, its mode and the remedy; empty: nobody else may
std::string trust_problem(const std::filesystem::path& file);

}  // namespace skybody
