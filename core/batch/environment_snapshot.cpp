// Saving and restoring all environments of an EnvironmentStates.
#include <algorithm>
#include <cstring>

#include "core/base/system/error.h"
#include "core/batch/environment_states.h"

namespace skybody {
namespace {

// The format of a snapshot: these words, then per environment its state words and its hash chain.
enum SavedWord : int {
  kMagicWord,
  kVersionWord,
  kScenarioWord,
  kEnvsWord,
  kWordsWord,
  kSavedHeader,
};
constexpr std::uint64_t kMagic = 0x544545'4c464253ull;  // "SBFLEET"
constexpr std::uint64_t kVersion = 2;                   // 2: with a checksum (Pool::save)
constexpr std::size_t kChainWords = sizeof(HashChain) / sizeof(std::uint64_t);
static_assert(std::is_trivially_copyable_v<HashChain> &&
              sizeof(HashChain) == kChainWords * sizeof(std::uint64_t));

std::vector<std::uint64_t> header(const CompiledScenario& compiled, int envs) {
  return {kMagic, kVersion, compiled.scenario().hash, static_cast<std::uint64_t>(envs),
          compiled.saved_words()};
}

}  // namespace

std::vector<std::uint64_t> EnvironmentStates::save() const {
  std::vector<std::uint64_t> out = header(*compiled_, envs());
  const std::size_t words = compiled_->saved_words();
  out.reserve(out.size() + index(envs()) * (words + kChainWords));
  for (int env = 0; env < envs(); ++env) {
    const std::vector<std::uint64_t> lane_words = state(env).save(places_.lane_of(env));
    out.insert(out.end(), lane_words.begin(), lane_words.end());
    std::uint64_t chain[kChainWords];
    std::memcpy(chain, &chains_[index(env)], sizeof(chain));
    out.insert(out.end(), chain, chain + kChainWords);
  }
  return out;
}

void EnvironmentStates::check_saved(std::span<const std::uint64_t> saved) const {
  const std::vector<std::uint64_t> expected = header(*compiled_, envs());
  const std::size_t words = compiled_->saved_words();
  const std::size_t each = words + kChainWords;
  if (saved.size() < kSavedHeader || saved[kMagicWord] != kMagic) {
    throw Error("this is not a saved state: give what save() gave");
  }
  if (saved[kVersionWord] != kVersion) {
    throw Error("saved by another version of Skybody (format " +
                std::to_string(saved[kVersionWord]) + ", this one reads " +
                std::to_string(kVersion) + ")");
  }
  if (saved[kScenarioWord] != expected[kScenarioWord] ||
      saved[kWordsWord] != expected[kWordsWord]) {
    throw Error("this state was saved with another scenario than " + compiled_->scenario().file +
                ": restore it where it was saved");
  }
  if (saved[kEnvsWord] != expected[kEnvsWord]) {
    throw Error("this state is of " + std::to_string(saved[kEnvsWord]) +
                " environments; here are " + std::to_string(envs()));
  }
  if (saved.size() != kSavedHeader + index(envs()) * each) {
    throw Error("this saved state is cut short: " + std::to_string(saved.size()) + " words of " +
                std::to_string(kSavedHeader + index(envs()) * each));
  }
}

void EnvironmentStates::restore(std::span<const std::uint64_t> saved) {
  check_saved(saved);
  const std::size_t words = compiled_->saved_words();
  const std::size_t each = words + kChainWords;
  const std::uint64_t* from = saved.data() + kSavedHeader;
  for (int env = 0; env < envs(); ++env, from += each) {
    state(env).restore(places_.lane_of(env), {from, from + words});
    std::memcpy(static_cast<void*>(&chains_[index(env)]), from + words, sizeof(HashChain));
    flags_.refresh(env, state(env));
  }
  for (int group = 0; group < places_.count(); ++group) draw_again(group);
}

}  // namespace skybody
