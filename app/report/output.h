// Standard output, which may be a file on a full disk, or a pipe whose reader has ended: text for
// it is dropped without an error.
#pragma once

#include <string>

namespace skybody {

/// Writes `text`. @throws Error with the operating system's message
void print(const std::string& text);

/// Flushes all output to the operating system. @throws Error with the operating system's message
void flush_output();

}  // namespace skybody
