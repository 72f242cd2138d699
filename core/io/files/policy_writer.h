// Writes policy.h5, the file for `skybody run --policy`. docs/policies.md has the format.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "core/io/files/policy_file.h"

namespace skybody {

/// The bytes of a policy file: equal policies give equal bytes.
/// @param seed  of the training
/// @throws Error if a layer's number of values does not match its sizes, or for fault_of()
std::string policy_bytes(const PolicyFile& policy, std::uint64_t seed);

/// Replaces `file` atomically.
/// @throws Error with the file and the reason, such as a full disk; `file` is then unchanged
void write_policy(const std::filesystem::path& file, const PolicyFile& policy, std::uint64_t seed);

}  // namespace skybody
