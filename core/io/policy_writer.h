// Writes policy.h5, the file that `skybody run --policy` flies. docs/policies.md has the format.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "core/io/policy_file.h"

namespace skybody {

/// The bytes of a policy file: equal policies give equal bytes.
/// @param seed  of the training
/// @throws Error if a layer's values are not as many as its sizes ask for, or for fault_of()
std::string policy_bytes(const PolicyFile& policy, std::uint64_t seed);

/// Replaces `file` as a whole.
/// @throws Error with the file and the reason, such as a full disk; the file is then as it was
void write_policy(const std::filesystem::path& file, const PolicyFile& policy, std::uint64_t seed);

}  // namespace skybody
