#include "plugins/host/library.h"

#include <dlfcn.h>
#include <elf.h>

#include <algorithm>
#include <boost/dll/shared_library.hpp>
#include <cstring>
#include <fstream>
#include <iterator>
#include <string>
#include <string_view>

#include "core/base/fp_environment.h"
#include "core/base/hash.h"
#include "plugins/api/structures.h"
#include "plugins/host/descriptor.h"

namespace skybody {
namespace {

constexpr const char* kNoSymbol = "is no plugin: it does not export `" SKYBODY_LIBRARY_SYMBOL
                                  "`; a plugin says SKYBODY_PLUGIN(Class, name, version, doc) once";
constexpr const char* kRebuild = ": rebuild it against this Skybody";

[[noreturn]] void refuse(LoadFailure reason, const std::filesystem::path& file,
                         const std::string& message) {
  throw PluginLoadError(reason, file, message);
}

std::string read_bytes(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

/// How long an ELF file has to be, by its own header and segments; 0 if it is no 64-bit ELF file.
/// The dynamic linker does not look: touching a page beyond the end kills the process.
std::size_t elf_size(const std::string& bytes) {
  Elf64_Ehdr header;
  if (bytes.size() < SELFMAG || std::memcmp(bytes.data(), ELFMAG, SELFMAG) != 0) return 0;
  if (bytes.size() < sizeof header) return sizeof header;
  std::memcpy(&header, bytes.data(), sizeof header);
  std::size_t size = header.e_shoff + std::size_t{header.e_shnum} * header.e_shentsize;
  size = std::max(size, header.e_phoff + header.e_phnum * sizeof(Elf64_Phdr));
  if (header.e_phentsize != sizeof(Elf64_Phdr) || bytes.size() < size) return size;
  for (std::size_t i = 0; i < header.e_phnum; ++i) {
    Elf64_Phdr segment;
    std::memcpy(&segment, bytes.data() + header.e_phoff + i * sizeof segment, sizeof segment);
    size = std::max<std::size_t>(size, segment.p_offset + segment.p_filesz);
  }
  return size;
}

/// Refuses what can be refused without running any of it: a file that is cut short, and a shared
/// library that nowhere holds the name of the symbol that a plugin exports.
void check_file(const std::filesystem::path& file) {
  const std::string bytes = read_bytes(file);
  const std::size_t size = elf_size(bytes);
  if (size > bytes.size()) {
    refuse(LoadFailure::kNotLoadable, file,
           "is cut short: it has " + std::to_string(bytes.size()) + " bytes of at least " +
               std::to_string(size) + "; build or copy it again");
  }
  if (size > 0 && bytes.find(SKYBODY_LIBRARY_SYMBOL) == std::string::npos) {
    refuse(LoadFailure::kNoPlugin, file, kNoSymbol);
  }
}

/// The dynamic linker's own words, without the file name that it begins with.
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

}  // namespace

struct PluginLibrary::Handle {
  boost::dll::shared_library library;
};

PluginLibrary::PluginLibrary(const std::filesystem::path& file)
    : file_(file), handle_(std::make_unique<Handle>()) {
  std::error_code not_found;
  file_ = std::filesystem::canonical(file, not_found);
  if (not_found) refuse(LoadFailure::kNotLoadable, file, "there is no such file");
  check_file(file_);

  {
    const FpEnvironment
        loading;  // start-up code of -Ofast libraries changes the mode; this undoes it
    boost::system::error_code failed;
    handle_->library.load(file_.string(), failed,
                          boost::dll::load_mode::rtld_now | boost::dll::load_mode::rtld_local);
    if (failed || !handle_->library.is_loaded()) {
      refuse(LoadFailure::kNotLoadable, file_,
             "cannot be loaded: " + linker_message(file_) + "; build or copy it again");
    }
  }

  const FpEnvironment checking;
  if (!handle_->library.has(SKYBODY_LIBRARY_SYMBOL)) {
    refuse(LoadFailure::kNoPlugin, file_, kNoSymbol);
  }
  const auto& found = handle_->library.get<const SkybodyPluginLibrary>(SKYBODY_LIBRARY_SYMBOL);
  if (found.magic != SKYBODY_ABI_MAGIC) {
    refuse(LoadFailure::kWrongMagic, file_,
           "is no plugin: `" SKYBODY_LIBRARY_SYMBOL "` begins with " + to_hex(found.magic) +
               " instead of " + to_hex(SKYBODY_ABI_MAGIC) + kRebuild);
  }
  if (found.abi_version != SKYBODY_ABI_VERSION) {
    refuse(LoadFailure::kWrongVersion, file_,
           "was built for plugin API " + std::to_string(found.abi_version) + ", this Skybody has " +
               std::to_string(SKYBODY_ABI_VERSION) + kRebuild);
  }
  check_sizes(file_, found);
  const std::uint64_t probe = found.fp_probe != nullptr ? found.fp_probe() : ~kFpProbeExpected;
  if (probe != kFpProbeExpected) {
    refuse(LoadFailure::kFloatingPoint, file_,
           "was compiled with other floating-point flags (its probe gives " + to_hex(probe) +
               " instead of " + to_hex(kFpProbeExpected) +
               "): link Skybody::plugin_api, and do not use -ffast-math, -Ofast or "
               "-ffp-contract=fast");
  }
  if (found.failure != nullptr) {
    refuse(LoadFailure::kBadDescription, file_,
           "its constructor failed: " + std::string(found.failure));
  }
  if (found.plugin_count == 0 || found.plugins == nullptr) {
    refuse(LoadFailure::kBadDescription, file_, "describes no plugin");
  }
  for (std::uint32_t i = 0; i < found.plugin_count; ++i) {
    const std::string problem =
        found.plugins[i] == nullptr ? "describes no plugin" : descriptor_problem(*found.plugins[i]);
    if (!problem.empty()) refuse(LoadFailure::kBadDescription, file_, problem);
    plugins_.push_back(found.plugins[i]);
  }
}

PluginLibrary::~PluginLibrary() {
  const FpEnvironment unloading;
  handle_.reset();
}

}  // namespace skybody
