#include "core/io/files/policy_checksum.h"

#include "core/base/math/hash.h"
#include "core/io/files/file.h"
#include "core/io/files/hdf5_reader.h"
#include "core/model/located_error.h"

namespace skybody {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kFirstWord = "skybody-policy ";
constexpr std::string_view kHdf5Signature = "\x89HDF\r\n\x1a\n";
// 2^26 float32 weights: a thousand times the networks of docs/training.md.
constexpr std::size_t kLargestFile = 256u << 20;

[[noreturn]] void fail(const fs::path& file, const std::string& message) {
  throw LocatedError({file.string(), 0, 0}, message);
}

std::string read_bytes(const fs::path& file) {
  check_regular_file(file);  // its message gives the remedy for a folder
  std::string bytes;
  const std::string problem = read_regular_file(file.string(), kLargestFile, bytes);
  if (!problem.empty()) fail(file, "the file " + problem);
  return bytes;
}

/// Rejects files without a seal of this format.
void check_format(const fs::path& file, std::string_view bytes) {
  if (bytes.starts_with(kHdf5Signature)) {
    fail(file, "an HDF5 file without the seal of policy format " + std::to_string(kPolicyFormat) +
                   ": export the policy anew");
  }
  if (!bytes.starts_with(kFirstWord)) {
    fail(file, "not a policy file: it does not begin with `skybody-policy " +
                   std::to_string(kPolicyFormat) + "`; " + kPolicyRemedy);
  }
  const std::string_view behind = bytes.substr(kFirstWord.size());
  const std::string_view version = behind.substr(0, behind.find_first_not_of("0123456789"));
  if (version.empty() || version == std::to_string(kPolicyFormat)) return;
  fail(file, "policy format " + std::string(version) + "; this Skybody reads format " +
                 std::to_string(kPolicyFormat) + ": export the policy anew");
}

}  // namespace

std::string policy_seal(std::string_view content) {
  std::string seal = std::string(kFirstWord) + std::to_string(kPolicyFormat) + "\nbytes " +
                     std::to_string(content.size()) + "\nhash " +
                     to_hex(hash_bytes(content.data(), content.size())) + "\n";
  seal.resize(kPolicySealBytes, '\0');
  return seal;
}

std::string read_sealed_policy(const fs::path& file) {
  std::string bytes = read_bytes(file);
  check_format(file, bytes);
  const std::string_view all = bytes;
  if (all.size() < kPolicySealBytes ||
      all.substr(0, kPolicySealBytes) != policy_seal(all.substr(kPolicySealBytes))) {
    fail(file,
         "damaged, cut short or changed: its bytes are not those that its first lines name; take "
         "another copy, or an earlier checkpoint");
  }
  return bytes;
}

}  // namespace skybody
