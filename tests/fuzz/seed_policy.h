// The policy file that the policy area changes.
#pragma once

#include <filesystem>

namespace skybody::fuzz {

/// Writes a small network with normalization. The only part of the fuzzers that depends on the
/// policy file format.
void write_seed_policy(const std::filesystem::path& file);

}  // namespace skybody::fuzz
