#include "tests/fuzz/seed_policy.h"

#include "core/io/files/flight_log_hdf5.h"
#include "core/io/files/policy_checksum.h"
#include "tests/fuzz/files.h"

namespace skybody::fuzz {
namespace {

constexpr hsize_t kObservations = 6, kHidden = 8, kActions = 4;

void write_values(const Hdf5Writer& writer, hid_t parent, const char* name,
                  const std::vector<hsize_t>& shape, float first) {
  hsize_t count = 1;
  for (const hsize_t extent : shape) count *= extent;
  std::vector<float> values(count);
  for (std::size_t k = 0; k < count; ++k) {
    values[k] = first + 0.037f * static_cast<float>(k % 13) - 0.2f;
  }
  const Hdf5Id space(
      writer.check(H5Screate_simple(static_cast<int>(shape.size()), shape.data(), nullptr)),
      H5Sclose);
  const Hdf5Id set(writer.check(H5Dcreate2(parent, name, H5T_IEEE_F32LE, space, H5P_DEFAULT,
                                           H5P_DEFAULT, H5P_DEFAULT)),
                   H5Dclose);
  writer.check(H5Dwrite(set, H5T_NATIVE_FLOAT, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()));
}

void write_layer(const Hdf5Writer& writer, hid_t layers, const char* name, hsize_t inputs,
                 hsize_t outputs, const char* activation) {
  const Hdf5Id group = writer.create_group(layers, name);
  write_values(writer, group, "weight", {outputs, inputs}, 0.01f);
  write_values(writer, group, "bias", {outputs}, 0.05f);
  writer.write_text(group, "activation", activation);
}

void write_header(const Hdf5Writer& writer, hid_t file) {
  const auto text = [&](const char* name, const char* value) {
    writer.write_text(file, name, value);
  };
  text("format", "skybody-policy");
  writer.write_attribute(file, "version", std::int64_t{kPolicyFormat});
  text("scenario", "hover");
  text("scenario_hash", "0123456789abcdef");
  writer.write_attribute(file, "seed", std::int64_t{1});
  text("algorithm", "ppo");
  writer.write_attribute(file, "steps", std::int64_t{1000});
  text("skybody_version", "0");
  writer.write_attribute(file, "observation_size", static_cast<std::int64_t>(kObservations));
  writer.write_attribute(file, "action_size", static_cast<std::int64_t>(kActions));
  text("action_squash", "clip");
}

void write_unsealed(const std::filesystem::path& path) {
  const Hdf5Writer writer(path, "policy");
  const Hdf5Id file = writer.create_file();
  write_header(writer, file);
  const Hdf5Id normalization = writer.create_group(file, "normalization");
  writer.write_dataset(normalization, "mean", std::vector<double>{0.1, -0.2, 0.3, 0.0, 0.5, -0.6});
  writer.write_dataset(normalization, "scale", std::vector<double>{1.1, 0.9, 0.5, 2.0, 1.5, 0.7});
  writer.write_attribute(normalization, "clip", 10.0);
  const Hdf5Id layers = writer.create_group(file, "layers");
  write_layer(writer, layers, "0", kObservations, kHidden, "tanh");
  write_layer(writer, layers, "1", kHidden, kActions, "none");
}

}  // namespace

void write_seed_policy(const std::filesystem::path& path) {
  write_unsealed(path);
  const std::string content = read_bytes(path);
  write_bytes(path, policy_seal(content) + content);
}

}  // namespace skybody::fuzz
