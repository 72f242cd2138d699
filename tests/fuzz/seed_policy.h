// The policy file that the policy area changes.
#pragma once

#include <filesystem>

namespace skybody::fuzz {

/// Writes a small network with normalization. The one place of the fuzzers that knows the format.
void write_seed_policy(const std::filesystem::path& file);

}  // namespace skybody::fuzz
