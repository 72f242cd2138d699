// Who may write a library, and so decides which code runs when it is opened.
#pragma once

#include <filesystem>
#include <string>

namespace skybody {

/// Whether somebody other than root and the user of this process may replace `file`. The file, its
/// folder and all folders above must belong to root or the user, and others must not write them.
/// The user's private group may: of the user's name, or number where neither has a name, without
/// other members. Folders above the file's own may be sticky, as /tmp is: others can add names
/// there, but not replace ours. In a user namespace without root these may belong to the overflow
/// user, as whom root appears there.
/// @param file  a canonical path
/// @returns who may write what, its mode and the remedy; empty: nobody else may
std::string trust_problem(const std::filesystem::path& file);

}  // namespace skybody
