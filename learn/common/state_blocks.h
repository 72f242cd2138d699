// Words of a checkpoint, by name. A class with state passes its arrays to a visitor in one
// function, which serves for writing, checking and reading.
#pragma once

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <string>
#include <utility>
#include <vector>

#include "core/base/system/error.h"

namespace skybody::learn {

using StateBlocks = std::vector<std::pair<std::string, std::vector<std::uint64_t>>>;

/// Adds a block for each array.
class StateWriter {
 public:
  explicit StateWriter(StateBlocks& blocks) : blocks_(blocks) {}

  template <class T>
  void operator()(const std::string& name, const T* values, std::size_t count) {
    std::vector<std::uint64_t> words((count * sizeof(T) + 7) / 8);
    if (count > 0) std::memcpy(words.data(), values, count * sizeof(T));
    blocks_.emplace_back(name, std::move(words));
  }

 private:
  StateBlocks& blocks_;
};

/// Finds the block of each array, and checks it or copies from it. Check all blocks first, so that
/// nothing changes if one is missing.
class StateReader {
 public:
  enum class Mode { kCheck, kCopy };
  StateReader(const StateBlocks& blocks, Mode mode) : blocks_(blocks), mode_(mode) {}

  /// @throws Error if there is no such block or its size differs
  template <class T>
  void operator()(const std::string& name, T* values, std::size_t count) {
    const std::vector<std::uint64_t>& words = find(name);
    const std::size_t wanted = (count * sizeof(T) + 7) / 8;
    if (words.size() != wanted) {
      throw Error("the checkpoint's `" + name + "` has " + std::to_string(words.size()) +
                  " words, and this learner's " + std::to_string(wanted) +
                  ": it is another scenario's, or of other hyper-parameters");
    }
    if (mode_ == Mode::kCopy && count > 0)
      std::memcpy(static_cast<void*>(values), words.data(), count * sizeof(T));
  }

 private:
  const std::vector<std::uint64_t>& find(const std::string& name) const {
    const auto found = std::find_if(blocks_.begin(), blocks_.end(),
                                    [&](const auto& block) { return block.first == name; });
    if (found == blocks_.end()) {
      throw Error("the checkpoint has no `" + name + "`: it is another learner's");
    }
    return found->second;
  }

  const StateBlocks& blocks_;
  Mode mode_;
};

}  // namespace skybody::learn
