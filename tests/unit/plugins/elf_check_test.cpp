// Libraries that are refused without running any of their code.
#include "core/plugin_host/elf_check.h"

#include <elf.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/stat.h>

#include <fstream>
#include <iterator>

#include "core/plugin_host/load_error.h"
#include "tests/unit/plugins/small_world.h"

namespace skybody {
namespace {

using std::filesystem::path;
using testing::EndsWith;
using testing::HasSubstr;
using testing::StartsWith;

class ElfCheck : public testing::Test {
 protected:
  ElfCheck() : file(folder.path() / "x.so") {
    std::filesystem::copy_file(test::good_plugins() / "lane_controller.so", file);
  }

  /// The message about the file, without its name; empty: none.
  std::string refusal() const {
    try {
      check_library_file(file);
    } catch (const PluginLoadError& e) {
      const std::string text = e.what(), name = file.string() + ": ";
      EXPECT_THAT(text, StartsWith(name));
      return text.substr(name.size());
    }
    return {};
  }
  /// Sets the file to zero from there to the end.
  void zero_from(std::uintmax_t at) const {
    const std::uintmax_t size = std::filesystem::file_size(file);
    std::filesystem::resize_file(file, at);
    std::filesystem::resize_file(file, size);
  }
  void write(std::streamoff at, const std::string& bytes) const {
    std::fstream out(file, std::ios::in | std::ios::out | std::ios::binary);
    out.seekp(at);
    out << bytes;
  }
  Elf64_Ehdr header() const {
    Elf64_Ehdr header;
    std::ifstream(file, std::ios::binary).read(reinterpret_cast<char*>(&header), sizeof header);
    return header;
  }

  const test::Folder folder;
  const path file;
};

TEST_F(ElfCheck, AcceptsAPlugin) { EXPECT_EQ(refusal(), ""); }

TEST_F(ElfCheck, RefusesEveryZeroedTail) {
  const std::uintmax_t size = std::filesystem::file_size(file);
  // One section header, the whole table, the names before it, half of the file.
  for (const std::uintmax_t at : {size - sizeof(Elf64_Shdr), std::uintmax_t{header().e_shoff},
                                  std::uintmax_t{header().e_shoff} - 200, size / 2}) {
    std::filesystem::copy_file(test::good_plugins() / "lane_controller.so", file,
                               std::filesystem::copy_options::overwrite_existing);
    zero_from(at);
    EXPECT_THAT(refusal(), StartsWith("has lost its end: zeros stand where its ")) << at;
  }
}

TEST_F(ElfCheck, RefusesOtherMachinesAndPrograms) {
  write(offsetof(Elf64_Ehdr, e_machine), "\xb7");  // EM_AARCH64
  EXPECT_EQ(refusal(),
            "is built for another machine (ELF class 2, machine 183), this is x86-64: build it "
            "here");
  write(offsetof(Elf64_Ehdr, e_machine), std::string(1, EM_X86_64));
  write(EI_CLASS, std::string(1, ELFCLASS32));
  EXPECT_THAT(refusal(), HasSubstr("another machine (ELF class 1"));
  write(EI_CLASS, std::string(1, ELFCLASS64));
  write(offsetof(Elf64_Ehdr, e_type), std::string(1, ET_EXEC));
  EXPECT_THAT(refusal(), StartsWith("is an ELF file of type 2, not a shared library"));
}

TEST_F(ElfCheck, RefusesImpossibleOffsetsAndSizes) {
  for (const std::size_t field : {offsetof(Elf64_Ehdr, e_shoff), offsetof(Elf64_Ehdr, e_phoff)}) {
    write(static_cast<std::streamoff>(field) + 4, std::string(4, '\xff'));
    EXPECT_THAT(refusal(), StartsWith("is cut short: ")) << field;
    write(static_cast<std::streamoff>(field) + 4, std::string(4, '\0'));
  }
  EXPECT_EQ(refusal(), "");
  write(offsetof(Elf64_Ehdr, e_phentsize), "\x01");
  EXPECT_THAT(refusal(), StartsWith("is damaged: its header gives impossible sizes"));
}

TEST_F(ElfCheck, RefusesPipesAndDevicesAtOnce) {
  std::filesystem::remove(file);
  ASSERT_EQ(mkfifo(file.c_str(), 0600), 0);
  EXPECT_EQ(refusal(), "is no regular file, but a device, a pipe or a folder");
  std::filesystem::remove(file);
  std::filesystem::create_symlink("/dev/zero", file);
  EXPECT_EQ(refusal(), "is no regular file, but a device, a pipe or a folder");
}

/// Peak memory of this process [kB].
long peak_kilobytes() {
  rusage usage;
  getrusage(RUSAGE_SELF, &usage);
  return usage.ru_maxrss;
}

/// Holes of a file are read as zeros: 4 GiB of them must be neither read nor kept.
TEST_F(ElfCheck, LooksAtASparseFileOfFourGigabytesWithoutReadingIt) {
  const long before = peak_kilobytes();
  std::filesystem::resize_file(file, std::uintmax_t{4} << 30);
  EXPECT_EQ(refusal(), "");  // any data may follow an ELF file
  write(static_cast<std::streamoff>(offsetof(Elf64_Ehdr, e_shoff)), std::string("\0\0\0\xf0", 4));
  EXPECT_THAT(refusal(), StartsWith("has lost its end"));
  EXPECT_LT(peak_kilobytes() - before, 64 * 1024);  // a few pages are needed
}

TEST_F(ElfCheck, RefusesWhatIsNoPlugin) {
  std::filesystem::copy_file(test::bad_plugins() / "missing_symbol.so", file,
                             std::filesystem::copy_options::overwrite_existing);
  EXPECT_THAT(refusal(), StartsWith("is no plugin: "));
}

}  // namespace
}  // namespace skybody
