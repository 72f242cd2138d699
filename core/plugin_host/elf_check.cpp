// The dynamic linker trusts the files that it loads: a page beyond a file's end or a table of zeros
// kills the process. Therefore every offset is compared with the file's size before it is followed.
// The tables that a linker writes last (section headers and their names, at the end of the file)
// must be present: zeros there mean data lost by a copy or a crash.
#include "core/plugin_host/elf_check.h"

#include <elf.h>
#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <optional>
#include <string>
#include <string_view>

#include "core/plugin_abi/abi.h"
#include "core/plugin_host/load_error.h"

namespace skybody {
namespace {

constexpr const char* kAgain = "; build or copy it again";
/// Bytes of the names of all symbols in one library; those of LLVM take 20 MB. More means a damaged
/// size.
constexpr std::uint64_t kMostNameBytes = 64u << 20;

/// A regular file in memory.
class Mapping {
 public:
  explicit Mapping(const std::filesystem::path& file) {
    struct stat status {};
    if (stat(file.c_str(), &status) == 0 && !S_ISREG(status.st_mode)) fail(file, kNoRegularFile);
    // Non-blocking, in case the file has become a pipe whose other end is never opened.
    const int descriptor = open(file.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY);
    if (descriptor < 0) fail(file, "cannot be opened: " + std::string(std::strerror(errno)));
    const bool is_file = fstat(descriptor, &status) == 0 && S_ISREG(status.st_mode);
    if (is_file && status.st_size > 0) {
      size_ = static_cast<std::uint64_t>(status.st_size);
      memory_ = mmap(nullptr, size_, PROT_READ, MAP_PRIVATE, descriptor, 0);
    }
    const std::string reason = std::strerror(errno);
    close(descriptor);
    if (!is_file) fail(file, kNoRegularFile);
    if (memory_ == MAP_FAILED) fail(file, "cannot be read: " + reason);
  }
  ~Mapping() {
    if (memory_ != nullptr) munmap(memory_, size_);
  }
  Mapping(const Mapping&) = delete;
  Mapping& operator=(const Mapping&) = delete;

  std::uint64_t size() const { return size_; }
  bool has(std::uint64_t offset, std::uint64_t bytes) const {
    return offset <= size_ && bytes <= size_ - offset;
  }
  /// Bytes of the file; check them with has() first.
  std::string_view bytes(std::uint64_t offset, std::uint64_t count) const {
    return {static_cast<const char*>(memory_) + offset, count};
  }
  template <class T>
  T read(std::uint64_t offset) const {
    T value;
    std::memcpy(&value, static_cast<const char*>(memory_) + offset, sizeof value);
    return value;
  }

 private:
  [[noreturn]] static void fail(const std::filesystem::path& file, const std::string& message) {
    throw PluginLoadError(LoadFailure::kNotLoadable, file, message);
  }

  void* memory_ = nullptr;
  std::uint64_t size_ = 0;
};

/// The machine that this program was compiled for.
#if defined(__x86_64__)
constexpr std::uint16_t kOwnMachine = EM_X86_64;
constexpr const char* kOwnMachineName = "x86-64";
#elif defined(__aarch64__)
constexpr std::uint16_t kOwnMachine = EM_AARCH64;
constexpr const char* kOwnMachineName = "aarch64";
#else
#error "plugins of this processor have an ELF machine number that is missing here"
#endif

/// One 64-bit ELF file. Each check returns the problem, or an empty text.
class Elf {
 public:
  explicit Elf(const Mapping& file) : file_(file), header_(file.read<Elf64_Ehdr>(0)) {}

  std::string machine_problem() const {
    const bool same = header_.e_ident[EI_CLASS] == ELFCLASS64 &&
                      header_.e_ident[EI_DATA] == ELFDATA2LSB && header_.e_machine == kOwnMachine;
    if (!same) {
      return "is built for another machine (ELF class " +
             std::to_string(header_.e_ident[EI_CLASS]) + ", machine " +
             std::to_string(header_.e_machine) + "), this is " + kOwnMachineName +
             ": build it here";
    }
    if (header_.e_type == ET_DYN) return {};
    return "is an ELF file of type " + std::to_string(header_.e_type) +
           ", not a shared library: build it with skybody_add_plugin";
  }

  /// Tables and segments must lie within the file.
  std::string size_problem() const {
    if (header_.e_phentsize != sizeof(Elf64_Phdr) ||
        (header_.e_shnum > 0 && header_.e_shentsize != sizeof(Elf64_Shdr))) {
      return std::string("is damaged: its header gives impossible sizes") + kAgain;
    }
    std::uint64_t need = std::max(end_of(header_.e_shoff, section_table_bytes()),
                                  end_of(header_.e_phoff, header_.e_phnum * sizeof(Elf64_Phdr)));
    for (int i = 0; need <= file_.size() && i < header_.e_phnum; ++i) {
      need = std::max(need, end_of(segment(i).p_offset, segment(i).p_filesz));
    }
    if (need <= file_.size()) return {};
    return "is cut short: it has " + std::to_string(file_.size()) + " bytes of at least " +
           std::to_string(need) + kAgain;
  }

  /// Section headers and their names lie last: zeros there mean that the end was never written.
  std::string end_problem() const {
    const std::string lost = std::string("has lost its end: ") + "zeros stand where its ";
    for (int i = 1; i < header_.e_shnum; ++i) {
      if (section(i).sh_type == SHT_NULL) return lost + "section headers should be" + kAgain;
    }
    if (header_.e_shnum == 0 || header_.e_shstrndx == SHN_UNDEF) return {};  // stripped
    const bool is_listed = header_.e_shstrndx < header_.e_shnum;
    if (!is_listed || !is_text_table(section(header_.e_shstrndx))) {
      return lost + "names of sections should be" + kAgain;
    }
    return {};
  }

  /// The names of its dynamic symbols, found as the dynamic linker finds them.
  std::optional<std::string_view> symbol_names() const {
    std::uint64_t address = 0, size = 0;
    for (int i = 0; i < header_.e_phnum; ++i) {
      if (segment(i).p_type == PT_DYNAMIC) read_dynamic(segment(i), address, size);
    }
    const std::optional<std::uint64_t> offset = offset_of(address);
    if (!offset || size == 0 || size > kMostNameBytes || !file_.has(*offset, size)) return {};
    return file_.bytes(*offset, size);
  }

 private:
  static std::uint64_t end_of(std::uint64_t offset, std::uint64_t bytes) {
    return offset > UINT64_MAX - bytes ? UINT64_MAX : offset + bytes;
  }
  std::uint64_t section_table_bytes() const { return header_.e_shnum * sizeof(Elf64_Shdr); }
  Elf64_Phdr segment(int i) const {
    return file_.read<Elf64_Phdr>(header_.e_phoff +
                                  static_cast<std::uint64_t>(i) * sizeof(Elf64_Phdr));
  }
  Elf64_Shdr section(int i) const {
    return file_.read<Elf64_Shdr>(header_.e_shoff +
                                  static_cast<std::uint64_t>(i) * sizeof(Elf64_Shdr));
  }

  /// A table of texts begins with an empty text and ends with a zero byte.
  bool is_text_table(const Elf64_Shdr& table) const {
    const std::uint64_t size = table.sh_size;
    if (table.sh_type != SHT_STRTAB || size < 2 || size > kMostNameBytes) return false;
    if (!file_.has(table.sh_offset, size)) return false;
    const std::string_view text = file_.bytes(table.sh_offset, size);
    return text.front() == '\0' && text.back() == '\0' &&
           text.find_first_not_of('\0') != std::string_view::npos;
  }

  void read_dynamic(const Elf64_Phdr& table, std::uint64_t& address, std::uint64_t& size) const {
    for (std::uint64_t at = 0; at + sizeof(Elf64_Dyn) <= table.p_filesz; at += sizeof(Elf64_Dyn)) {
      const auto entry = file_.read<Elf64_Dyn>(table.p_offset + at);
      if (entry.d_tag == DT_NULL) return;
      if (entry.d_tag == DT_STRTAB) address = entry.d_un.d_ptr;
      if (entry.d_tag == DT_STRSZ) size = entry.d_un.d_val;
    }
  }

  /// File offset of the byte at an address.
  std::optional<std::uint64_t> offset_of(std::uint64_t address) const {
    for (int i = 0; i < header_.e_phnum; ++i) {
      const Elf64_Phdr s = segment(i);
      if (s.p_type == PT_LOAD && address >= s.p_vaddr && address - s.p_vaddr < s.p_filesz) {
        return s.p_offset + (address - s.p_vaddr);
      }
    }
    return {};
  }

  const Mapping& file_;
  Elf64_Ehdr header_;
};

bool is_elf(const Mapping& file) {
  return file.has(0, SELFMAG) && file.bytes(0, SELFMAG) == std::string_view(ELFMAG, SELFMAG);
}

void refuse_if(const std::string& problem, const std::filesystem::path& file) {
  if (!problem.empty()) throw PluginLoadError(LoadFailure::kNotLoadable, file, problem);
}

}  // namespace

void check_library_file(const std::filesystem::path& file) {
  const Mapping mapping(file);
  if (!is_elf(mapping)) return;
  if (!mapping.has(0, sizeof(Elf64_Ehdr))) {
    refuse_if("is cut short: it has " + std::to_string(mapping.size()) + " bytes of at least " +
                  std::to_string(sizeof(Elf64_Ehdr)) + kAgain,
              file);
  }
  const Elf elf(mapping);
  refuse_if(elf.machine_problem(), file);
  refuse_if(elf.size_problem(), file);
  refuse_if(elf.end_problem(), file);
  const auto names = elf.symbol_names();
  if (!names) refuse_if(std::string("is damaged: it has no names of symbols") + kAgain, file);
  if (names->find(std::string_view(SKYBODY_LIBRARY_SYMBOL "\0", sizeof(SKYBODY_LIBRARY_SYMBOL))) ==
      std::string_view::npos) {
    throw PluginLoadError(LoadFailure::kNoPlugin, file, kNoPluginSymbol);
  }
}

}  // namespace skybody
