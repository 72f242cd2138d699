#include <nanobind/stl/map.h>
#include <nanobind/stl/string.h>
#include <skybody/build_info.h>
#include <skybody/git_describe.h>
#include <skybody/version.h>

#include <map>
#include <string>

#include "core/base/simd/isa.h"
#include "core/base/system/installation.h"
#include "core/version.h"
#include "python/native/bindings.h"

namespace skybody::python {
namespace {

std::map<std::string, std::string> versions() {
  return {{"skybody", version()},
          {"git", SKYBODY_GIT_DESCRIBE},
          {"build", SKYBODY_BUILD_TYPE},
          {"compiler", SKYBODY_COMPILER},
          {"simbody", SKYBODY_SIMBODY_VERSION},
          {"simbody asserts", SKYBODY_SIMBODY_NDEBUG ? "off" : "on"},
          {"libraries", SKYBODY_LIBRARY_VERSIONS},
          {"instruction set", name(best_isa())}};
}

}  // namespace

void bind_versions(nb::module_& m) {
  m.def(
      "versions", &versions,
      "What results may depend on: versions of Skybody, Simbody, compiler and libraries, how they "
      "were\nbuilt, and the instruction set that kernels use here (all sets give the same bits).");
  m.def(
      "library_folder", [] { return library_folder().string(); },
      "The folder of libskybody: of a build, of an installation or of the wheel `libskybody`.");
  m.attr("__version__") = version();
  m.attr("built_for") = SKYBODY_VERSION;  // the library that is loaded may be of another version
}

}  // namespace skybody::python
