#include "core/base/system/installation.h"

#include <dlfcn.h>

namespace skybody {
namespace fs = std::filesystem;
namespace {

const char kAnchor = 0;  // an address inside libskybody

}  // namespace

fs::path library_file() {
  Dl_info info;
  const bool found = dladdr(&kAnchor, &info) != 0 && info.dli_fname != nullptr;
  const fs::path file = found ? fs::path(info.dli_fname) : fs::path("/proc/self/exe");
  std::error_code not_found;
  const fs::path real = fs::canonical(file, not_found);
  return not_found ? fs::absolute(file) : real;
}

fs::path library_folder() { return library_file().parent_path(); }

fs::path shipped_data(const std::string& name, const std::string& source_folder) {
  std::error_code ignored;
  // From lib/ or lib/ARCHITECTURE/ of a prefix, or from bin/ if the library is linked statically.
  for (const char* up : {"..", "../.."}) {
    const fs::path installed =
        (library_folder() / up / "share" / "skybody" / name).lexically_normal();
    if (fs::is_directory(installed, ignored)) return installed;
  }
  const fs::path source = fs::path(SKYBODY_SOURCE_TREE) / source_folder;
  return fs::is_directory(source, ignored) ? source : fs::path();
}

}  // namespace skybody
