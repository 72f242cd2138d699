#pragma once

namespace skybody {

// The library's version, as "major.minor.patch".
const char* version();

}  // namespace skybody
