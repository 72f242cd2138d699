#include "core/plugin_host/library.h"

#include <dlfcn.h>

#define BOOST_DLL_USE_STD_FS  // without Boost.Filesystem
#include <boost/dll/shared_library.hpp>
#include <string>

#include "core/base/math/hash.h"
#include "core/base/simd/fp_environment.h"
#include "core/base/system/plugin_call_trace.h"
#include "core/plugin_abi/structures.h"
#include "core/plugin_host/descriptor.h"
#include "core/plugin_host/elf_check.h"

namespace skybody {
namespace {

constexpr std::uint32_t kMostPlugins = 1000;  // far beyond any library
constexpr const char* kRebuild = ": rebuild it against this Skybody";

[[noreturn]] void refuse(LoadFailure reason, const std::filesystem::path& file,
                         const std::string& message) {
  throw PluginLoadError(reason, file, message);
}

/// The dynamic linker's message, without the file name at its beginning.
std::string linker_message(const std::filesystem::path& file) {
  const char* text = dlerror();
  std::string message = text != nullptr ? text : "the dynamic linker gives no reason";
  const std::string prefix = file.string() + ": ";
  if (message.compare(0, prefix.size(), prefix) == 0) message.erase(0, prefix.size());
  return message;
}

void check_sizes(const std::filesystem::path& file, const SkybodyPluginLibrary& found) {
  const struct {
    const char* structure;
    std::uint32_t theirs;
    std::size_t ours;
  } sizes[] = {
      {"SkybodyPluginLibrary", found.library_size, sizeof(SkybodyPluginLibrary)},
      {"SkybodyPlugin", found.plugin_size, sizeof(SkybodyPlugin)},
      {"SkybodyKernels", found.kernels_size, sizeof(SkybodyKernels)},
      {"SkybodySetup", found.setup_size, sizeof(SkybodySetup)},
      {"SkybodyDeclare", found.declare_size, sizeof(SkybodyDeclare)},
      {"SkybodyLanes", found.lanes_size, sizeof(SkybodyLanes)},
      {"SkybodyParameter", found.parameter_size, sizeof(SkybodyParameter)},
  };
  for (const auto& s : sizes) {
    if (s.theirs == s.ours) continue;
    refuse(LoadFailure::kWrongSize, file,
           "its " + std::string(s.structure) + " has " + std::to_string(s.theirs) +
               " bytes, this Skybody's has " + std::to_string(s.ours) + kRebuild);
  }
  if (found.structures != plugin_export::structures_hash()) {
    refuse(LoadFailure::kWrongSize, file,
           std::string("its plugin structures differ from this Skybody's") + kRebuild);
  }
}

/// Checks the library's description of itself, in the order in which its parts can be trusted.
void check_header(const std::filesystem::path& file, const SkybodyPluginLibrary& found) {
  if (found.magic != SKYBODY_ABI_MAGIC) {
    refuse(LoadFailure::kWrongMagic, file,
           "is no plugin: `" SKYBODY_LIBRARY_SYMBOL "` begins with " + to_hex(found.magic) +
               " instead of " + to_hex(SKYBODY_ABI_MAGIC) + kRebuild);
  }
  if (found.abi_version != SKYBODY_ABI_VERSION) {
    refuse(LoadFailure::kWrongVersion, file,
           "was built for plugin API " + std::to_string(found.abi_version) + ", this Skybody has " +
               std::to_string(SKYBODY_ABI_VERSION) + kRebuild);
  }
  check_sizes(file, found);
  const std::uint64_t probe = found.fp_probe != nullptr ? found.fp_probe() : ~kFpProbeExpected;
  if (probe != kFpProbeExpected) {
    refuse(LoadFailure::kFloatingPoint, file,
           "was compiled with other floating-point flags (its probe gives " + to_hex(probe) +
               " instead of " + to_hex(kFpProbeExpected) +
               "): link Skybody::plugin_api, and do not use -ffast-math, -Ofast or "
               "-ffp-contract=fast");
  }
  if (found.failure != nullptr) {
    refuse(LoadFailure::kBadDescription, file,
           "its constructor failed: " + std::string(found.failure));
  }
  if (found.plugin_count == 0 || found.plugins == nullptr) {
    refuse(LoadFailure::kBadDescription, file, "describes no plugin");
  }
  if (found.plugin_count > kMostPlugins) {
    refuse(LoadFailure::kBadDescription, file,
           "says that it holds " + std::to_string(found.plugin_count) +
               " plugins; allowed: at most " + std::to_string(kMostPlugins));
  }
}

}  // namespace

/// Unloads the library in its destructor, also if the constructor of PluginLibrary throws.
struct PluginLibrary::Handle {
  explicit Handle(std::filesystem::path path) : file(std::move(path)) {}
  ~Handle() {
    const FpEnvironment unloading;
    const PluginPhase phase(file, "while it is unloaded");
    library.unload();
  }
  Handle(const Handle&) = delete;
  Handle& operator=(const Handle&) = delete;

  /// An exception of the library's start-up code ends the process here. It cannot pass through the
  /// dynamic linker, whose lock would stay held.
  bool load() noexcept { return open(); }

  std::filesystem::path file;
  boost::dll::shared_library library;

 private:
  /// Not inlined: if a noexcept function has cleanup of its own, the process ends without the
  /// exception's text.
  [[gnu::noinline]] bool open() {
    std::error_code failed;
    library.load(file, failed, boost::dll::load_mode::rtld_now | boost::dll::load_mode::rtld_local);
    return !failed && library.is_loaded();
  }
};

PluginLibrary::PluginLibrary(const std::filesystem::path& file) : file_(file) {
  std::error_code not_found;
  file_ = std::filesystem::canonical(file, not_found);
  if (not_found) refuse(LoadFailure::kNotLoadable, file, "there is no such file");
  {
    const PluginPhase phase(file_, "while its file is checked");
    check_library_file(file_);  // a file that shrinks during the check causes SIGBUS
  }
  handle_ = std::make_unique<Handle>(file_);

  const PluginPhase phase(file_, "while it is loaded");
  {
    const FpEnvironment
        loading;  // start-up code of -Ofast libraries changes the mode; this restores it
    if (!handle_->load()) {
      refuse(LoadFailure::kNotLoadable, file_,
             "cannot be loaded: " + linker_message(file_) + "; build or copy it again");
    }
  }

  const FpEnvironment checking;
  if (!handle_->library.has(SKYBODY_LIBRARY_SYMBOL)) {
    refuse(LoadFailure::kNoPlugin, file_, kNoPluginSymbol);
  }
  const auto& found = handle_->library.get<const SkybodyPluginLibrary>(SKYBODY_LIBRARY_SYMBOL);
  check_header(file_, found);
  for (std::uint32_t i = 0; i < found.plugin_count; ++i) {
    const std::string problem =
        found.plugins[i] == nullptr ? "describes no plugin" : descriptor_problem(*found.plugins[i]);
    if (!problem.empty()) refuse(LoadFailure::kBadDescription, file_, problem);
    plugins_.push_back(found.plugins[i]);
  }
}

PluginLibrary::~PluginLibrary() = default;

}  // namespace skybody
