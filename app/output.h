// Standard output, which may be a file on a full disk.
#pragma once

#include <string>

namespace skybody {

/// Writes `text`. @throws Error with what the operating system says
void print(const std::string& text);

/// Hands everything that was written to the operating system. @throws Error likewise
void flush_output();

}  // namespace skybody
