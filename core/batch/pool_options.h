// Options of a Pool, and their names in files and on command lines.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>

namespace skybody {

/// Order in which recv() returns finished environments.
enum class Order {
  kFixed,    ///< by id, cyclically: the same batches in every run
  kArrival,  ///< first finished, first returned
};

/// Behaviour at the end of an episode (Gymnasium's AutoresetMode).
enum class Autoreset {
  kNextStep,  ///< the next action is ignored and the environment reset instead
  kSameStep,  ///< reset at once; the ended episode's last row is in final_observation
  kDisabled,  ///< the caller resets; stepping an ended environment is an error
};

/// Options of a Pool.
struct PoolOptions {
  int envs = 1;     ///< N_E
  int batch = 0;    ///< N_B <= N_E; 0: N_E
  int threads = 0;  ///< N_T, with the caller; 0: one per processor, at most N_E
  Order order = Order::kFixed;
  Autoreset autoreset = Autoreset::kNextStep;
  std::uint64_t seed = 0;          ///< key of all random numbers
  std::uint64_t first_env_id = 0;  ///< environment i draws with (seed, first_env_id + i)
  bool pin_threads = false;        ///< each worker on a processor of its own, where allowed
  bool keep_hash = false;          ///< chain a trajectory hash per environment
  bool info = true;  ///< whether rows contain info values (the task's, then other plugins' reports)
  /// recv() never returns memory that the caller still refers to. false: it uses a fresh buffer
  /// (counted); true: it throws BufferInUse, and fills reused buffers with NaN.
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

/// Null for an unknown name.
inline std::optional<Order> order_from(const std::string& name) {
  return detail::enum_from<Order>(kOrderNames, name);
}
inline std::optional<Autoreset> autoreset_from(const std::string& name) {
  return detail::enum_from<Autoreset>(kAutoresetNames, name);
}

}  // namespace skybody
