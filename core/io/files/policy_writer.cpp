// The seal is a hash of the bytes that HDF5 writes, so the file is written in memory first (HDF5's
// driver `core`). The memory is FileMemory's; its content is complete when HDF5 closes the file.
// H5Fget_file_image does not help: the superblock of an open file cannot be read again. A seed
// beyond HDF5's signed integers is written as a text; readers ignore it.
#include "core/io/files/policy_writer.h"

#include <functional>
#include <limits>
#include <numeric>
#include <vector>

#include "core/base/system/error.h"
#include "core/io/files/atomic_file.h"
#include "core/io/files/flight_log_hdf5.h"
#include "core/io/files/policy_checksum.h"
#include "core/version.h"

namespace skybody {
namespace {

constexpr std::size_t kMemoryStep = 1 << 10;  // [bytes]; the file's size is a multiple of it

/// Properties of a file or a group without time stamps: equal policies give equal bytes.
Hdf5Id timeless(const Hdf5Writer& writer, hid_t kind) {
  Hdf5Id creation(writer.check(H5Pcreate(kind)), H5Pclose);
  writer.check(H5Pset_obj_track_times(creation, 0));
  return creation;
}

/// The bytes of a file in memory; HDF5 calls its functions.
class FileMemory {
 public:
  /// Stores the file created with `access` in this object, which must outlive it.
  void serve(const Hdf5Writer& writer, hid_t access) {
    H5FD_file_image_callbacks_t callbacks{};
    callbacks.image_malloc = [](std::size_t size, H5FD_file_image_op_t, void* self) {
      return resize(self, size);
    };
    callbacks.image_realloc = [](void*, std::size_t size, H5FD_file_image_op_t, void* self) {
      return resize(self, size);
    };
    callbacks.image_free = [](void*, H5FD_file_image_op_t, void*) -> herr_t { return 0; };
    callbacks.udata_copy = [](void* self) { return self; };
    callbacks.udata_free = [](void*) -> herr_t { return 0; };
    callbacks.udata = this;
    writer.check(H5Pset_fapl_core(access, kMemoryStep, 0));
    writer.check(H5Pset_file_image_callbacks(access, &callbacks));
  }
  /// Complete once the file is closed.
  const std::string& bytes() const { return bytes_; }

 private:
  static void* resize(void* self, std::size_t size) {
    std::string& bytes = static_cast<FileMemory*>(self)->bytes_;
    bytes.resize(size);
    return bytes.data();
  }

  std::string bytes_;
};

/// Creates a file of HDF5 1.10's format with space for the seal. Metadata has checksums.
Hdf5Id create(const Hdf5Writer& writer, FileMemory& memory) {
  const Hdf5Id creation = timeless(writer, H5P_FILE_CREATE);
  writer.check(H5Pset_userblock(creation, kPolicySealBytes));
  const Hdf5Id access(writer.check(H5Pcreate(H5P_FILE_ACCESS)), H5Pclose);
  writer.check(H5Pset_libver_bounds(access, H5F_LIBVER_V110, H5F_LIBVER_V110));
  memory.serve(writer, access);
  return {writer.check(H5Fcreate("policy.h5", H5F_ACC_TRUNC, creation, access)), H5Fclose};
}

Hdf5Id create_group(const Hdf5Writer& writer, hid_t parent, const std::string& name) {
  const Hdf5Id creation = timeless(writer, H5P_GROUP_CREATE);
  return {writer.check(H5Gcreate2(parent, name.c_str(), H5P_DEFAULT, creation, H5P_DEFAULT)),
          H5Gclose};
}

/// Writes a dataset in one chunk with Fletcher's checksum, which HDF5 checks on every read.
template <class T>
void put(const Hdf5Writer& writer, hid_t parent, const char* name, hid_t type,
         const std::vector<T>& values, const std::vector<hsize_t>& extent) {
  const int rank = static_cast<int>(extent.size());
  const Hdf5Id space(writer.check(H5Screate_simple(rank, extent.data(), nullptr)), H5Sclose);
  const Hdf5Id properties = timeless(writer, H5P_DATASET_CREATE);
  writer.check(H5Pset_chunk(properties, rank, extent.data()));
  writer.check(H5Pset_fletcher32(properties));
  const Hdf5Id set(
      writer.check(H5Dcreate2(parent, name, type, space, H5P_DEFAULT, properties, H5P_DEFAULT)),
      H5Dclose);
  writer.check(H5Dwrite(set, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()));
}

void put_doubles(const Hdf5Writer& writer, hid_t parent, const char* name,
                 const std::vector<double>& values) {
  put(writer, parent, name, H5T_NATIVE_DOUBLE, values, {values.size()});
}

void put_floats(const Hdf5Writer& writer, hid_t parent, const char* name,
                const std::vector<double>& values, const std::vector<hsize_t>& extent) {
  const hsize_t room = std::accumulate(extent.begin(), extent.end(), hsize_t{1}, std::multiplies{});
  if (values.size() != room) {
    throw Error("`" + std::string(name) + "` of a policy's layer has " +
                std::to_string(values.size()) + " values; its sizes ask for " +
                std::to_string(room));
  }
  const std::vector<float> narrow(values.begin(), values.end());
  put(writer, parent, name, H5T_NATIVE_FLOAT, narrow, extent);
}

/// Writes entries of the scenario's rows, one row per agent.
void put_entries(const Hdf5Writer& writer, hid_t parent, const char* name,
                 const std::vector<PolicyAgent>& agents, std::vector<int> PolicyAgent::*part) {
  std::vector<int> entries;
  for (const PolicyAgent& agent : agents) {
    entries.insert(entries.end(), (agent.*part).begin(), (agent.*part).end());
  }
  put(writer, parent, name, H5T_NATIVE_INT, entries,
      {agents.size(), entries.size() / agents.size()});
}

void write_header(const Hdf5Writer& writer, hid_t file, const PolicyFile& policy,
                  std::uint64_t seed) {
  constexpr auto kLargest = static_cast<std::uint64_t>(std::numeric_limits<std::int64_t>::max());
  writer.write_text(file, "scenario", policy.scenario);
  writer.write_text(file, "scenario_hash", policy.scenario_hash);
  if (seed <= kLargest) {
    writer.write_attribute(file, "seed", static_cast<std::int64_t>(seed));
  } else {
    writer.write_text(file, "seed", std::to_string(seed));
  }
  writer.write_text(file, "algorithm", policy.algorithm);
  writer.write_attribute(file, "steps", policy.steps);
  writer.write_text(file, "skybody_version", version());
  writer.write_attribute(file, "observation_size", std::int64_t{policy.observation_size});
  writer.write_attribute(file, "action_size", std::int64_t{policy.action_size});
  writer.write_text(file, "format", "skybody-policy");
  writer.write_attribute(file, "version", std::int64_t{kPolicyFormat});
  writer.write_text(file, "action_squash", policy.squash == ActionSquash::kTanh ? "tanh" : "clip");
}

void write_normalization(const Hdf5Writer& writer, hid_t file, const PolicyFile& policy) {
  if (policy.mean.empty()) return;
  const Hdf5Id group = create_group(writer, file, "normalization");
  put_doubles(writer, group, "mean", policy.mean);
  put_doubles(writer, group, "scale", policy.scale);
  writer.write_attribute(group, "clip", policy.clip);
}

void write_agents(const Hdf5Writer& writer, hid_t file, const PolicyFile& policy) {
  if (policy.agents.empty()) return;
  const Hdf5Id group = create_group(writer, file, "agents");
  put_entries(writer, group, "observation", policy.agents, &PolicyAgent::observation);
  put_entries(writer, group, "action", policy.agents, &PolicyAgent::action);
}

void write_layer(const Hdf5Writer& writer, hid_t group, const PolicyLayer& layer) {
  const auto rows = static_cast<hsize_t>(layer.weight_rows());
  put_floats(writer, group, "weight", layer.weight, {rows, static_cast<hsize_t>(layer.inputs)});
  put_floats(writer, group, "bias", layer.bias, {rows});
  if (layer.is_recurrent()) {
    put_floats(writer, group, "state_weight", layer.state_weight,
               {rows, static_cast<hsize_t>(layer.outputs)});
    put_floats(writer, group, "state_bias", layer.state_bias, {rows});
  } else {
    writer.write_text(group, "activation", name(layer.activation));
  }
  if (layer.kind != LayerKind::kConv) return;
  const ConvShape& shape = layer.conv;
  writer.write_attribute(group, "outputs", std::int64_t{shape.outputs});
  writer.write_attribute(group, "kernel_height", std::int64_t{shape.kernel_height});
  writer.write_attribute(group, "kernel_width", std::int64_t{shape.kernel_width});
  writer.write_attribute(group, "stride", std::int64_t{shape.stride});
  writer.write_text(group, "padding", shape.same ? "same" : "valid");
}

void write_images(const Hdf5Writer& writer, hid_t file, const PolicyFile& policy) {
  if (policy.images.empty()) return;
  const Hdf5Id images = create_group(writer, file, "images");
  for (std::size_t k = 0; k < policy.images.size(); ++k) {
    const PolicyImage& image = policy.images[k];
    const Hdf5Id group = create_group(writer, images, std::to_string(k));
    writer.write_text(group, "column", image.column);
    writer.write_attribute(group, "height", std::int64_t{image.height});
    writer.write_attribute(group, "width", std::int64_t{image.width});
    writer.write_attribute(group, "channels", std::int64_t{image.channels});
    writer.write_attribute(group, "low", image.low);
    writer.write_attribute(group, "high", image.high);
    for (std::size_t l = 0; l < image.layers.size(); ++l) {
      write_layer(writer, create_group(writer, group, std::to_string(l)), image.layers[l]);
    }
  }
}

void write_layers(const Hdf5Writer& writer, hid_t file, const PolicyFile& policy) {
  const Hdf5Id layers = create_group(writer, file, "layers");
  for (std::size_t k = 0; k < policy.layers.size(); ++k) {
    write_layer(writer, create_group(writer, layers, std::to_string(k)), policy.layers[k]);
  }
}

}  // namespace

std::string policy_bytes(const PolicyFile& policy, std::uint64_t seed) {
  if (const std::string fault = fault_of(policy); !fault.empty()) throw Error("a policy: " + fault);
  const QuietHdf5 quiet;
  const Hdf5Writer writer("in memory", "policy");
  FileMemory memory;
  Hdf5Id file = create(writer, memory);
  write_header(writer, file, policy, seed);
  write_agents(writer, file, policy);
  write_normalization(writer, file, policy);
  write_images(writer, file, policy);
  write_layers(writer, file, policy);
  writer.check(file.reset() ? 0 : -1);
  const std::string content = memory.bytes().substr(kPolicySealBytes);
  return policy_seal(content) + content;
}

void write_policy(const std::filesystem::path& file, const PolicyFile& policy, std::uint64_t seed) {
  write_file_atomically(file, policy_bytes(policy, seed));
}

}  // namespace skybody
