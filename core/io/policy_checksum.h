// The seal of a policy.h5: its first 512 bytes, which name the hash of all bytes behind them.
//
// HDF5 leaves that part of a file (its user block) to others. The seal is checked before HDF5 sees
// the file, because HDF5 crashes or hangs on some damaged files and reads others without complaint.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>

namespace skybody {

/// The format of policy files that is written and read.
inline constexpr int kPolicyFormat = 2;

/// The smallest user block that HDF5 allows.
inline constexpr std::size_t kPolicySealBytes = 512;

/// The seal of a file whose bytes behind the seal are `content`: three lines, then zeros.
std::string policy_seal(std::string_view content);

/// All bytes of a policy file.
/// @throws LocatedError with the file's name: missing, no regular file, no policy, another format,
///         or its bytes are not those that were sealed
std::string read_sealed_policy(const std::filesystem::path& file);

}  // namespace skybody
