#include "core/plugin_host/trust.h"

#include <grp.h>
#include <pwd.h>
#include <sys/stat.h>
#include <sys/xattr.h>
#include <unistd.h>

#include <cerrno>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <optional>
#include <vector>

namespace skybody {
namespace {

namespace fs = std::filesystem;

/// Buffer for one entry of the user or group database; glibc itself suggests 1 KiB. A larger group
/// does not fit and counts as one with other members.
constexpr std::size_t kDatabaseEntryBytes = 16384;

std::optional<std::string> find_user_name(uid_t user) {
  std::vector<char> memory(kDatabaseEntryBytes);
  passwd entry;
  passwd* found = nullptr;
  getpwuid_r(user, &entry, memory.data(), memory.size(), &found);
  if (found == nullptr) return std::nullopt;
  return found->pw_name;
}

std::string user_name(uid_t user) { return find_user_name(user).value_or(std::to_string(user)); }

/// Whether root exists in this user namespace. Without a map it does.
bool is_root_mapped() {
  std::ifstream map("/proc/self/uid_map");
  std::uint64_t inside = 0, outside = 0, count = 0;
  bool has_lines = false;
  while (map >> inside >> outside >> count) {
    has_lines = true;
    if (inside == 0 && count > 0) return true;
  }
  return !has_lines;
}

/// Owner shown for files of users without a number in this user namespace.
uid_t overflow_user() {
  uid_t user = 65534;  // the kernel's default
  std::ifstream("/proc/sys/kernel/overflowuid") >> user;
  return user;
}

/// Whether a folder above may belong to a root that the user namespace hides: `/` and `/tmp` then
/// belong to the overflow user.
bool may_be_roots(uid_t owner) { return owner == overflow_user() && !is_root_mapped(); }

struct Group {
  std::string name;
  bool is_private = false;  ///< has the user's name (without names: number) and no other members
};

Group read_group(gid_t id, uid_t owner) {
  const std::optional<std::string> user = find_user_name(owner);
  std::vector<char> memory(kDatabaseEntryBytes);
  group entry;
  group* found = nullptr;
  getgrgid_r(id, &entry, memory.data(), memory.size(), &found);
  if (found == nullptr) return {std::to_string(id), !user && id == owner};
  Group result{found->gr_name, user == found->gr_name};
  for (char** member = found->gr_mem; *member != nullptr; ++member) {
    if (user != *member) result.is_private = false;
  }
  return result;
}

/// Whether an access control list grants more than the mode. The mode's group bits are then the
/// list's mask.
bool has_access_list(const fs::path& path) {
  return getxattr(path.c_str(), "system.posix_acl_access", nullptr, 0) > 0;
}

std::string octal(mode_t mode) {
  char text[16];
  std::snprintf(text, sizeof text, "%04o", static_cast<unsigned>(mode & 07777));
  return text;
}

/// Writers of `path` by its mode, other than its owner; empty: none.
std::string other_writers(const fs::path& path, const struct stat& status) {
  if ((status.st_mode & S_IWOTH) != 0) return "everybody";
  if ((status.st_mode & S_IWGRP) == 0) return {};
  if (has_access_list(path)) return "those whom its access control list names";
  const Group group = read_group(status.st_gid, geteuid());
  return group.is_private ? std::string() : "the group `" + group.name + "`";
}

enum class Place { kFile, kFolder, kAncestor };

/// "it", "its folder /lab/plugins", "the folder /lab above it"
std::string describe(Place place, const fs::path& path) {
  if (place == Place::kFile) return "it";
  if (place == Place::kFolder) return "its folder " + path.string();
  return "the folder " + path.string() + " above it";
}

std::string problem_at(Place place, const fs::path& path) {
  struct stat status;
  if (stat(path.c_str(), &status) != 0) {
    return "is not opened: who may write " + describe(place, path) +
           " cannot be found out: " + std::strerror(errno);
  }
  const bool is_ours = status.st_uid == 0 || status.st_uid == geteuid() ||
                       (place == Place::kAncestor && may_be_roots(status.st_uid));
  if (!is_ours) {
    return "is not opened: " + describe(place, path) + " belongs to the user `" +
           user_name(status.st_uid) + "`, not to you or root (mode " + octal(status.st_mode) +
           "); if you trust the library, copy it into a folder of your own";
  }
  const bool is_sticky = (status.st_mode & S_ISVTX) != 0;
  if (place == Place::kAncestor && is_sticky) return {};
  const std::string who = other_writers(path, status);
  if (who.empty()) return {};
  return "is not opened: " + who + " may write " + describe(place, path) + " (mode " +
         octal(status.st_mode) + "); if you trust the library, " +
         (is_sticky ? "move it into a folder of your own" : "chmod go-w " + path.string());
}

}  // namespace

std::string trust_problem(const fs::path& file) {
  Place place = Place::kFile;
  for (fs::path path = file;; path = path.parent_path()) {
    std::string problem = problem_at(place, path);
    if (!problem.empty() || path == path.root_path() || path.empty()) return problem;
    place = place == Place::kFile ? Place::kFolder : Place::kAncestor;
  }
}

}  // namespace skybody
