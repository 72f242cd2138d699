#include "tests/integration/policy_draft.h"

#include <fstream>
#include <iterator>

#include "core/io/files/policy_checksum.h"

namespace skybody::test {

namespace fs = std::filesystem;

namespace {

void write_matrix(const Hdf5Writer& writer, hid_t parent, const char* name, int rank,
                  const hsize_t* extent, const std::vector<float>& values) {
  const Hdf5Id space(writer.check(H5Screate_simple(rank, extent, nullptr)), H5Sclose);
  const Hdf5Id set(writer.check(H5Dcreate2(parent, name, H5T_IEEE_F32LE, space, H5P_DEFAULT,
                                           H5P_DEFAULT, H5P_DEFAULT)),
                   H5Dclose);
  writer.check(H5Dwrite(set, H5T_NATIVE_FLOAT, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()));
}

}  // namespace

fs::path write_unsealed(const fs::path& path, const Draft& draft) {
  const Hdf5Writer writer(path, "policy");
  const Hdf5Id file = writer.create_file();
  const auto text = [&](const char* name, const std::string& value) {
    if (draft.left_out != name) writer.write_text(file, name, value);
  };
  const auto number = [&](const char* name, std::int64_t value) {
    if (draft.left_out != name) writer.write_attribute(file, name, value);
  };
  text("format", draft.format);
  number("version", draft.version);
  text("scenario", draft.scenario);
  text("scenario_hash", draft.scenario_hash);
  number("seed", 1);
  text("algorithm", "ppo");
  number("steps", 1000);
  text("skybody_version", "0");
  number("observation_size", draft.observation_size);
  number("action_size", draft.action_size);
  text("action_squash", draft.squash);
  if (!draft.mean.empty()) {
    const Hdf5Id group = writer.create_group(file, "normalization");
    writer.write_dataset(group, "mean", draft.mean);
    writer.write_dataset(group, "scale", draft.scale);
    writer.write_attribute(group, "clip", draft.clip);
  }
  const Hdf5Id layers = writer.create_group(file, "layers");
  for (std::size_t k = 0; k < draft.layers.size(); ++k) {
    const Draft::Layer& layer = draft.layers[k];
    const Hdf5Id group = writer.create_group(layers, std::to_string(k));
    const hsize_t shape[2] = {layer.rows, layer.columns}, bias = layer.bias.size();
    write_matrix(writer, group, "weight", 2, shape, layer.weight);
    write_matrix(writer, group, "bias", 1, &bias, layer.bias);
    if (layer.state_weight.empty()) {
      writer.write_text(group, "activation", layer.activation);
    } else {
      const hsize_t rows = layer.state_bias.size();
      const hsize_t states[2] = {rows, layer.state_weight.size() / rows};
      write_matrix(writer, group, "state_weight", 2, states, layer.state_weight);
      write_matrix(writer, group, "state_bias", 1, &rows, layer.state_bias);
    }
  }
  if (draft.finish) draft.finish(writer, file);
  return path;
}

std::string bytes_of(const fs::path& path) {
  std::ifstream stream(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

void put_bytes(const fs::path& path, const std::string& bytes) {
  std::ofstream(path, std::ios::binary) << bytes;
}

fs::path write_policy(const fs::path& path, const Draft& draft) {
  write_unsealed(path, draft);
  const std::string content = bytes_of(path);
  put_bytes(path, policy_seal(content) + content);
  return path;
}

}  // namespace skybody::test
