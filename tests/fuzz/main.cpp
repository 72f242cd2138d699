// skybody_fuzz: mutated scenarios, models, policies, recordings, states, actions and plugins.
// docs/fuzzing.md describes how to run it, how to rerun a finding, and how to add an area.
#include <sys/statvfs.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <exception>
#include <string>

#include "tests/fuzz/campaign.h"
#include "tests/fuzz/report.h"

namespace skybody::fuzz {
namespace {

namespace fs = std::filesystem;

/// A folder in memory, if plugins can be loaded from it: every input is written to a file.
fs::path scratch_parent() {
  const char* memory = "/dev/shm";
  struct statvfs found {};
  const bool usable =
      access(memory, W_OK) == 0 && statvfs(memory, &found) == 0 && (found.f_flag & ST_NOEXEC) == 0;
  return usable ? fs::path(memory) : fs::temp_directory_path();
}

class ScratchFolder {
 public:
  ScratchFolder() {
    std::string pattern = (scratch_parent() / "skybody_fuzz_XXXXXX").string();
    if (mkdtemp(pattern.data()) == nullptr) throw std::runtime_error("cannot make a folder");
    path_ = pattern;
  }
  ~ScratchFolder() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
  }
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;

  const fs::path& path() const { return path_; }

 private:
  fs::path path_;
};

int run(const Options& options) {
  const ScratchFolder scratch;
  Campaign campaign(options, scratch.path());
  if (options.in_process) {
    campaign.run_here();
    return 0;
  }
  const auto begin = std::chrono::steady_clock::now();
  const std::vector<Tally> tallies = campaign.run();
  const std::chrono::duration<double, std::ratio<60>> time =
      std::chrono::steady_clock::now() - begin;
  std::printf("%s", table_text(tallies).c_str());
  if (!options.markdown.empty()) {
    write_markdown(options.markdown, tallies, {options.command, time.count(), options.jobs});
  }
  for (const Tally& tally : tallies) {
    if (tally.bad() > 0) return 1;
  }
  return 0;
}

}  // namespace
}  // namespace skybody::fuzz

int main(int count, char** arguments) {
  skybody::fuzz::Options options;
  int status = 0;
  if (!skybody::fuzz::parse_options(count, arguments, options, status)) return status;
  try {
    return skybody::fuzz::run(options);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "skybody_fuzz: %s\n", error.what());
    return 2;
  }
}
