#include "tests/fuzz/inputs.h"

#include <algorithm>

#include "tests/fuzz/files.h"
#include "tests/fuzz/recipe.h"

namespace skybody::fuzz {

namespace fs = std::filesystem;

std::string MadeInputs::name(std::uint64_t k) const {
  return std::string(row_.name) + "_" + std::to_string(seed_) + "_" + std::to_string(k);
}

std::string MadeInputs::rerun(std::uint64_t k) const {
  return std::string(row_.name) + " --seed " + std::to_string(seed_) + " --first " +
         std::to_string(k) + " --count 1";
}

std::string FileInputs::make(std::uint64_t k) const {
  const fs::path& file = files_[k];
  return file.extension() == ".recipe" ? expand_recipe(read_bytes(file)) : read_bytes(file);
}

std::string FileInputs::name(std::uint64_t k) const {
  return area_ + "_" + files_[k].filename().string();
}

std::string FileInputs::rerun(std::uint64_t k) const {
  return area_ + " --input " + files_[k].string();
}

std::vector<fs::path> corpus_files(const std::string& area) {
  const fs::path folder = fs::path(SKYBODY_SOURCE_DIR) / "tests/fuzz/corpus" / area;
  std::vector<fs::path> files;
  std::error_code none;
  for (const auto& entry : fs::directory_iterator(folder, none)) files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  return files;
}

}  // namespace skybody::fuzz
