// Sources of inputs: made from a seed, or read from files.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "tests/fuzz/area.h"

namespace skybody::fuzz {

/// Inputs of one area by number.
class Inputs {
 public:
  virtual ~Inputs() = default;
  virtual std::string make(std::uint64_t k) const = 0;
  /// A file name for input k.
  virtual std::string name(std::uint64_t k) const = 0;
  /// The arguments of skybody_fuzz that run input k again.
  virtual std::string rerun(std::uint64_t k) const = 0;
};

/// Mutated seeds; their number is unlimited.
class MadeInputs : public Inputs {
 public:
  MadeInputs(const AreaRow& row, const Area& area, std::uint64_t seed)
      : row_(row), area_(area), seed_(seed) {}
  std::string make(std::uint64_t k) const override { return make_input(row_, area_, seed_, k); }
  std::string name(std::uint64_t k) const override;
  std::string rerun(std::uint64_t k) const override;

 private:
  const AreaRow& row_;
  const Area& area_;
  std::uint64_t seed_;
};

/// Files: the corpus, or one named file. A file named *.recipe is expanded (recipe.h).
class FileInputs : public Inputs {
 public:
  FileInputs(std::string area, std::vector<std::filesystem::path> files)
      : area_(std::move(area)), files_(std::move(files)) {}
  std::string make(std::uint64_t k) const override;
  std::string name(std::uint64_t k) const override;
  std::string rerun(std::uint64_t k) const override;
  std::uint64_t count() const { return files_.size(); }

 private:
  std::string area_;
  std::vector<std::filesystem::path> files_;
};

/// The area's own seeds, unchanged: each must be accepted.
class SeedInputs : public Inputs {
 public:
  SeedInputs(std::string area, const Material& material)
      : area_(std::move(area)), material_(material) {}
  std::string make(std::uint64_t k) const override { return material_.seeds[k]; }
  std::string name(std::uint64_t k) const override { return "seed_" + std::to_string(k); }
  std::string rerun(std::uint64_t) const override { return area_ + " --corpus"; }
  std::uint64_t count() const { return material_.seeds.size(); }

 private:
  std::string area_;
  const Material& material_;
};

/// Files of tests/fuzz/corpus/AREA, sorted by name.
std::vector<std::filesystem::path> corpus_files(const std::string& area);

}  // namespace skybody::fuzz
