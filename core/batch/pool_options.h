// How a Pool is made, and the words for it in files and on command lines.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>

namespace skybody {

/// In which order recv() gives finished environments.
enum class Order {
  kFixed,    ///< by id, cyclically: the same batches in every run
  kArrival,  ///< first finished, first served
};

/// What happens where an episode has ended (Gymnasium's AutoresetMode).
enum class Autoreset {
  kNextStep,  ///< the next action is ignored and the environment reset instead
  kSameStep,  ///< reset at once; the ended episode's last row is in final_observation
  kDisabled,  ///< the caller resets; stepping an ended environment is an error
};

/// How a Pool is made.
struct PoolOptions {
  int envs = 1;     ///< N_E
  int batch = 0;    ///< N_B <= N_E; 0: N_E
  int threads = 0;  ///< N_T, the caller counted; 0: one per processor, at most one per environment
  Order order = Order::kFixed;
  Autoreset autoreset = Autoreset::kNextStep;
  std::uint64_t seed = 0;          ///< key of all random numbers
  std::uint64_t first_env_id = 0;  ///< environment i draws with (seed, first_env_id + i)
  bool pin_threads = false;        ///< workers each on a processor of their own, where allowed
  bool keep_hash = false;          ///< chain a trajectory hash per environment
  bool info = true;  ///< whether rows carry info values (the task's, then what others report)
  /// recv() never hands out memory that the caller still refers to: false: takes a fresh buffer
  /// (counted), true: throws BufferInUse, and fills buffers that it recycles with NaN.
  bool debug_buffers = false;
};

inline constexpr int kMostEnvs = 1 << 24;
inline constexpr int kMostThreads = 1024;

/// Names in the order of the enumerators.
inline constexpr std::array<const char*, 2> kOrderNames = {"fixed", "arrival"};
inline constexpr std::array<const char*, 3> kAutoresetNames = {"next_step", "same_step",
                                                               "disabled"};

inline std::string to_text(Order order) { return kOrderNames[static_cast<std::size_t>(order)]; }
inline std::string to_text(Autoreset autoreset) {
  return kAutoresetNames[static_cast<std::size_t>(autoreset)];
}

namespace detail {
template <class Enum, std::size_t N>
std::optional<Enum> enum_from(const std::array<const char*, N>& names, const std::string& name) {
  for (std::size_t k = 0; k < N; ++k) {
    if (name == names[k]) return static_cast<Enum>(k);
  }
  return std::nullopt;
}
}  // namespace detail

/// Null for a word that is none.
inline std::optional<Order> order_from(const std::string& name) {
  return detail::enum_from<Order>(kOrderNames, name);
}
inline std::optional<Autoreset> autoreset_from(const std::string& name) {
  return detail::enum_from<Autoreset>(kAutoresetNames, name);
}

}  // namespace skybody
