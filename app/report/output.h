// Standard output. It may be a file on a full disk, which is an error, or a pipe that its reader
// has closed: then further output is dropped without an error.
#pragma once

#include <string>

namespace skybody {

/// Writes `text`. @throws Error with the operating system's message
void print(const std::string& text);

/// Flushes all output to the operating system. @throws Error with the operating system's message
void flush_output();

}  // namespace skybody
