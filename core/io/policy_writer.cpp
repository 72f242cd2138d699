// Needs: the bytes that HDF5 writes, because the seal is a hash of them. HDF5 gives the image of a
// file in memory with a superblock that it does not read again (its mark of being open is in it),
// so the file is written to anonymous memory of Linux and closed. The seed is written as a text
// where it does not fit HDF5's signed integers: readers pass over it.
#include "core/io/policy_writer.h"

#include <sys/mman.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <limits>
#include <vector>

#include "core/base/error.h"
#include "core/io/flight_log_hdf5.h"
#include "core/io/policy_seal.h"
#include "core/io/whole_file.h"
#include "core/version.h"

namespace skybody {
namespace {

/// Memory with a file descriptor, and a name for HDF5 to open.
class AnonymousFile {
 public:
  AnonymousFile() : descriptor_(memfd_create("policy.h5", MFD_CLOEXEC)) {
    if (descriptor_ < 0) throw Error(std::string("no memory for a policy: ") + strerror(errno));
  }
  ~AnonymousFile() { close(descriptor_); }
  AnonymousFile(const AnonymousFile&) = delete;
  AnonymousFile& operator=(const AnonymousFile&) = delete;

  std::string path() const { return "/proc/self/fd/" + std::to_string(descriptor_); }
  std::string bytes() const {
    std::string text(static_cast<std::size_t>(lseek(descriptor_, 0, SEEK_END)), '\0');
    for (std::size_t done = 0; done < text.size();) {
      const ssize_t count =
          pread(descriptor_, text.data() + done, text.size() - done, static_cast<off_t>(done));
      SKYBODY_DEMAND(count > 0, "memory of a policy file cannot be read");
      done += static_cast<std::size_t>(count);
    }
    return text;
  }

 private:
  int descriptor_;
};

/// A file of HDF5 1.10's format, behind room for the seal. Metadata has checksums.
Hdf5Id create(const Hdf5Writer& writer, const std::string& path) {
  const Hdf5Id creation(writer.check(H5Pcreate(H5P_FILE_CREATE)), H5Pclose);
  writer.check(H5Pset_userblock(creation, kPolicySealBytes));
  const Hdf5Id access(writer.check(H5Pcreate(H5P_FILE_ACCESS)), H5Pclose);
  writer.check(H5Pset_libver_bounds(access, H5F_LIBVER_V110, H5F_LIBVER_V110));
  return {writer.check(H5Fcreate(path.c_str(), H5F_ACC_TRUNC, creation, access)), H5Fclose};
}

/// A dataset in one chunk, with Fletcher's checksum, which HDF5 checks whenever it is read.
template <class T>
void put(const Hdf5Writer& writer, hid_t parent, const char* name, hid_t type,
         const std::vector<T>& values, const std::vector<hsize_t>& extent) {
  const int rank = static_cast<int>(extent.size());
  const Hdf5Id space(writer.check(H5Screate_simple(rank, extent.data(), nullptr)), H5Sclose);
  const Hdf5Id properties(writer.check(H5Pcreate(H5P_DATASET_CREATE)), H5Pclose);
  writer.check(H5Pset_chunk(properties, rank, extent.data()));
  writer.check(H5Pset_fletcher32(properties));
  writer.check(H5Pset_obj_track_times(properties, 0));  // equal policies give equal bytes
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
  const std::vector<float> narrow(values.begin(), values.end());
  put(writer, parent, name, H5T_NATIVE_FLOAT, narrow, extent);
}

/// Entries of the scenario's rows, a row for each agent.
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
  const Hdf5Id group = writer.create_group(file, "normalization");
  put_doubles(writer, group, "mean", policy.mean);
  put_doubles(writer, group, "scale", policy.scale);
  writer.write_attribute(group, "clip", policy.clip);
}

void write_agents(const Hdf5Writer& writer, hid_t file, const PolicyFile& policy) {
  if (policy.agents.empty()) return;
  const Hdf5Id group = writer.create_group(file, "agents");
  put_entries(writer, group, "observation", policy.agents, &PolicyAgent::observation);
  put_entries(writer, group, "action", policy.agents, &PolicyAgent::action);
}

void write_layer(const Hdf5Writer& writer, hid_t group, const PolicyLayer& layer) {
  const auto rows = static_cast<hsize_t>(layer.weight_rows());
  put_floats(writer, group, "weight", layer.weight, {rows, static_cast<hsize_t>(layer.inputs)});
  put_floats(writer, group, "bias", layer.bias, {rows});
  if (layer.kind == LayerKind::kGru) {
    put_floats(writer, group, "state_weight", layer.state_weight,
               {rows, static_cast<hsize_t>(layer.outputs)});
    put_floats(writer, group, "state_bias", layer.state_bias, {rows});
  } else {
    writer.write_text(group, "activation", name(layer.activation));
  }
}

void write_layers(const Hdf5Writer& writer, hid_t file, const PolicyFile& policy) {
  const Hdf5Id layers = writer.create_group(file, "layers");
  for (std::size_t k = 0; k < policy.layers.size(); ++k) {
    write_layer(writer, writer.create_group(layers, std::to_string(k)), policy.layers[k]);
  }
}

}  // namespace

std::string policy_bytes(const PolicyFile& policy, std::uint64_t seed) {
  const QuietHdf5 quiet;
  const AnonymousFile memory;
  const Hdf5Writer writer("in memory", "policy");
  Hdf5Id file = create(writer, memory.path());
  write_header(writer, file, policy, seed);
  write_agents(writer, file, policy);
  write_normalization(writer, file, policy);
  write_layers(writer, file, policy);
  writer.check(file.reset() ? 0 : -1);
  const std::string bytes = memory.bytes();
  const std::string content = bytes.substr(kPolicySealBytes);
  return policy_seal(content) + content;
}

void write_policy(const std::filesystem::path& file, const PolicyFile& policy, std::uint64_t seed) {
  write_whole_file(file, policy_bytes(policy, seed));
}

}  // namespace skybody
