// Checks which users may write a library, since they control the code that runs when it is opened.
#pragma once

#include <filesystem>
#include <string>

namespace skybody {

/// Whether a user other than root and the owner of this process may replace `file`. Rules:
///   - The file, its folder and all folders above must belong to root or the user, and others must
///     not be able to write them.
///   - The user's private group may write them. It has the user's name (or the user's number where
///     neither has a name) and no other members.
///   - Folders above the file's own may be sticky, as /tmp is: others can add names there, but not
///     replace ours.
///   - In a user namespace without root these folders may belong to the overflow user, which
///     represents root there.
/// @param file  a canonical path
/// @returns a message with the writers, the path, its mode and the remedy; empty: no other user may
///          write it
std::string trust_problem(const std::filesystem::path& file);

}  // namespace skybody
