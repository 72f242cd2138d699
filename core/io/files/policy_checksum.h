// The seal of a policy.h5: its first 512 bytes, with a hash of all following bytes.
//
// HDF5 reserves this part of a file (its user block) for applications. The seal is checked before
// HDF5 opens the file, because HDF5 crashes or hangs on some damaged files and reads others without
// an error.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>

namespace skybody {

/// The format version of policy files, for reading and writing.
inline constexpr int kPolicyFormat = 2;

/// Advice for files that are no policies.
inline constexpr const char* kPolicyRemedy = "give a policy.h5, which `skybody train` writes";

/// The smallest user block that HDF5 allows.
inline constexpr std::size_t kPolicySealBytes = 512;

/// The seal of a file with the bytes `content` after the seal: three lines, then zeros.
std::string policy_seal(std::string_view content);

/// Reads all bytes of a policy file.
/// @throws LocatedError with the file's name if it is missing, not a regular file, not a policy, of
///         another format, or its bytes differ from the sealed ones
std::string read_sealed_policy(const std::filesystem::path& file);

}  // namespace skybody
