// Builds policy files for tests of their reader and of flights with them.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "core/io/files/flight_log_hdf5.h"

namespace skybody::test {

/// The message about a file whose seal does not match, after the file's name.
inline constexpr const char* kDamaged =
    "damaged, cut short or changed: its bytes are not those that its first lines name; take "
    "another copy, or an earlier checkpoint";

/// Content of a policy file; each test changes the fields it is about.
struct Draft {
  std::string format = "skybody-policy", squash = "clip", scenario = "test",
              scenario_hash = "0123456789abcdef";
  std::int64_t version = 2, observation_size = 2, action_size = 1;
  struct Layer {
    hsize_t rows, columns;
    std::vector<float> weight, bias;
    std::string activation;                                 ///< of a dense layer
    std::vector<float> state_weight = {}, state_bias = {};  ///< of a recurrent layer
  };
  std::vector<Layer> layers = {{2, 2, {0.5f, -1.0f, 2.0f, 0.25f}, {0.1f, -0.2f}, "tanh"},
                               {1, 2, {1.5f, -0.75f}, {0.05f}, "none"}};
  std::vector<double> mean, scale;
  double clip = 10.0;
  std::string left_out;  ///< name of an attribute to omit
  std::function<void(const Hdf5Writer&, hid_t)>
      finish;  ///< called with the file before it is closed
};

/// Writes the file without a seal. @returns path
std::filesystem::path write_unsealed(const std::filesystem::path& path, const Draft& draft);
/// Writes the file with its seal. @returns path
std::filesystem::path write_policy(const std::filesystem::path& path, const Draft& draft);

std::string bytes_of(const std::filesystem::path& path);
void put_bytes(const std::filesystem::path& path, const std::string& bytes);

}  // namespace skybody::test
