// Replay files that are damaged or maliciously crafted.
#include "core/io/files/replay_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdint>
#include <filesystem>
#include <string>

#include "core/base/math/hash.h"
#include "core/io/files/flight_log_hdf5.h"
#include "core/io/files/hdf5_reader.h"
#include "core/io/files/replay_bursts.h"
#include "core/model/located_error.h"
#include "tests/integration/process.h"

namespace skybody::test {
namespace {

namespace fs = std::filesystem;

/// Overwrites one value of a column of 64-bit or 32-bit numbers.
template <class T>
void put_value(const fs::path& file, const char* column, hsize_t row, hid_t type, T value) {
  const Hdf5Id opened(H5Fopen(file.c_str(), H5F_ACC_RDWR, H5P_DEFAULT), H5Fclose);
  const Hdf5Id set(H5Dopen2(opened, column, H5P_DEFAULT), H5Dclose);
  const Hdf5Id space(H5Dget_space(set), H5Sclose);
  ASSERT_GE(H5Sselect_elements(space, H5S_SELECT_SET, 1, &row), 0);
  const hsize_t one = 1;
  const Hdf5Id memory(H5Screate_simple(1, &one, nullptr), H5Sclose);
  ASSERT_GE(H5Dwrite(set, type, memory, space, H5P_DEFAULT, &value), 0);
}

template <class T>
void add_column(HashChain& chain, const Hdf5Reader& reader, const char* path, std::size_t rows) {
  const auto values = reader.rows<T>(path, 0, rows);
  add_burst(chain, rows, values.data(), values.size() * sizeof(T));
}

/// Updates the hash of a recording of one burst to match its content, as an attacker can.
void rehash(const fs::path& file, const ReplayHeader& header) {
  HashChain chain = replay_chain(header);
  {
    const Hdf5Reader reader(file, "replay", "");
    const auto burst = reader.all<std::uint64_t>(kReplayBursts);
    for (std::size_t k = 0; k < kReplayColumnCount; ++k) {
      const auto& [path, type, width] = kReplayColumns[k];
      if (replay_width(header, width) == 0) continue;
      const auto rows = static_cast<std::size_t>(burst[k]);
      if (type == ReplayType::kU8) add_column<std::uint8_t>(chain, reader, path, rows);
      if (type == ReplayType::kI32) add_column<std::int32_t>(chain, reader, path, rows);
      if (type == ReplayType::kU64) add_column<std::uint64_t>(chain, reader, path, rows);
      if (type == ReplayType::kF32) add_column<float>(chain, reader, path, rows);
    }
  }
  const Hdf5Id opened(H5Fopen(file.c_str(), H5F_ACC_RDWR, H5P_DEFAULT), H5Fclose);
  const Hdf5Id set(H5Dopen2(opened, kReplayBursts, H5P_DEFAULT), H5Dclose);
  const Hdf5Id space(H5Dget_space(set), H5Sclose);
  const hsize_t at[2] = {0, kReplayColumnCount};
  const hsize_t one = 1;
  const std::uint64_t hash = chain.value();
  ASSERT_GE(H5Sselect_elements(space, H5S_SELECT_SET, 1, at), 0);
  const Hdf5Id memory(H5Screate_simple(1, &one, nullptr), H5Sclose);
  ASSERT_GE(H5Dwrite(set, H5T_NATIVE_UINT64, memory, space, H5P_DEFAULT, &hash), 0);
}

std::string refusal_of(const fs::path& file) {
  try {
    ReplayReader reader(file);
    for (ReplayEvent event; reader.next(event);) {
    }
  } catch (const LocatedError& error) {
    return error.message();
  }
  return "";
}

/// A recording of one environment that was reset once, in one burst.
ReplayHeader write_small(const fs::path& file, bool with_transition = true) {
  ReplayHeader header;
  header.envs = 1;
  header.autoreset = "next_step";
  header.action_size = 2;
  header.columns = {"x float32 [3] from task"};
  header.observation_names = {"a", "b", "c"};
  ReplayWriter writer(file, header);
  ReplayEvent restore;
  restore.kind = ReplayEventKind::kRestore;
  restore.saved = {1, 2, 3};
  writer.add(restore);
  const std::int32_t env[] = {0};
  writer.add(ReplayEventKind::kReset, env, {});
  ReplayRow row;
  row.observation = {1.0f, 2.0f, 3.0f};
  if (with_transition) writer.add(row);
  writer.close();
  return header;
}

constexpr const char* kDamagedValues =
    "this replay is damaged: the values of burst 0 are not those that were recorded; take another "
    "copy";
constexpr const char* kDamagedEvents =
    "this replay is damaged: its events and transitions do not fit together";

TEST(ReplayFile, RefusesAnEventCountBeyondTheFileBeforeItAsksForMemory) {
  const TemporaryFolder folder;
  const fs::path file = folder.path() / "run.h5";
  const ReplayHeader header = write_small(file);
  ASSERT_EQ(refusal_of(file), "");
  for (const hsize_t event : {0, 1}) {  // a saved state, a reset
    write_small(file);
    put_value(file, "/events/count", event, H5T_NATIVE_UINT64, std::uint64_t{1} << 61);
    EXPECT_EQ(refusal_of(file), kDamagedValues);
    rehash(file, header);
    EXPECT_THAT(refusal_of(file), testing::StartsWith(kDamagedEvents));
  }
}

TEST(ReplayFile, RefusesEventsThatDoNotFitTheOtherColumns) {
  const TemporaryFolder folder;
  const fs::path file = folder.path() / "run.h5";
  const ReplayHeader header = write_small(file);
  rehash(file, header);
  EXPECT_EQ(refusal_of(file), "") << "rehash() itself";
  const auto refusal_with = [&](const char* column, hsize_t row, hid_t type, auto value) {
    write_small(file);
    put_value(file, column, row, type, value);
    rehash(file, header);
    return refusal_of(file);
  };
  EXPECT_THAT(refusal_with("/events/kind", 1, H5T_NATIVE_UINT8, std::uint8_t{9}),
              testing::StartsWith(kDamagedEvents));
  EXPECT_THAT(refusal_with("/events/kind", 0, H5T_NATIVE_UINT8, std::uint8_t{1}),
              testing::StartsWith(kDamagedEvents));
  EXPECT_THAT(refusal_with("/events/kind", 1, H5T_NATIVE_UINT8, std::uint8_t{2}),
              testing::StartsWith(kDamagedEvents))
      << "actions that are not there";
  EXPECT_THAT(refusal_with("/events/env_id", 0, H5T_NATIVE_INT32, std::int32_t{1}),
              testing::StartsWith(kDamagedEvents));
  EXPECT_THAT(refusal_with("/transitions/env_id", 0, H5T_NATIVE_INT32, std::int32_t{-1}),
              testing::StartsWith(kDamagedEvents));
}

TEST(ReplayFile, RefusesARecordingWithoutTransitions) {
  const TemporaryFolder folder;
  const fs::path file = folder.path() / "run.h5";
  write_small(file, false);
  EXPECT_EQ(refusal_of(file),
            "this replay has no transitions: there is nothing to compare; record a reset");
}

TEST(ReplayFile, FollowsNoLinks) {
  const TemporaryFolder folder;
  const fs::path file = folder.path() / "run.h5", other = folder.path() / "other.h5";
  write_small(file);
  write_small(other);
  {
    const Hdf5Id opened(H5Fopen(file.c_str(), H5F_ACC_RDWR, H5P_DEFAULT), H5Fclose);
    ASSERT_GE(H5Ldelete(opened, "/events", H5P_DEFAULT), 0);
    ASSERT_GE(
        H5Lcreate_external(other.c_str(), "/events", opened, "/events", H5P_DEFAULT, H5P_DEFAULT),
        0);
  }
  EXPECT_EQ(refusal_of(file),
            "`/events` is a link to another place; a replay holds its values "
            "itself");
}

/// Replaces /overrides by texts in another HDF5 storage type.
template <class Set>
void replace_overrides(const fs::path& file, hid_t type, Set&& set) {
  const Hdf5Id opened(H5Fopen(file.c_str(), H5F_ACC_RDWR, H5P_DEFAULT), H5Fclose);
  ASSERT_GE(H5Ldelete(opened, "/overrides", H5P_DEFAULT), 0);
  const hsize_t one = 1, most = H5S_UNLIMITED;
  const Hdf5Id space(H5Screate_simple(1, &one, &most), H5Sclose);
  const Hdf5Id properties(H5Pcreate(H5P_DATASET_CREATE), H5Pclose);
  set(properties);
  const Hdf5Id made(
      H5Dcreate2(opened, "/overrides", type, space, H5P_DEFAULT, properties, H5P_DEFAULT),
      H5Dclose);
  ASSERT_GE(made, 0);
}

TEST(ReplayFile, RefusesHugeChunksAndTextsOfVariableLength) {
  const TemporaryFolder folder;
  const fs::path file = folder.path() / "run.h5";
  write_small(file);
  replace_overrides(file, hdf5_text_type(4), [](hid_t properties) {
    const hsize_t chunk = hsize_t{1} << 29;
    H5Pset_chunk(properties, 1, &chunk);
  });
  EXPECT_EQ(refusal_of(file), "`/overrides` has chunks of more than 16 MiB");
  write_small(file);
  replace_overrides(file, hdf5_text_type(), [](hid_t properties) {
    const hsize_t chunk = 1;
    H5Pset_chunk(properties, 1, &chunk);
  });
  EXPECT_EQ(refusal_of(file),
            "`/overrides` is a text of variable length; allowed: texts of fixed length");
}

TEST(ReplayFile, IsReadUpToItsLastBurstWhereTheNextWasNotConcluded) {
  const TemporaryFolder folder;
  const fs::path file = folder.path() / "run.h5";
  write_small(file);
  {  // after a kill during the next burst, columns may be longer
    const Hdf5Id opened(H5Fopen(file.c_str(), H5F_ACC_RDWR, H5P_DEFAULT), H5Fclose);
    const Hdf5Id set(H5Dopen2(opened, "/transitions/hash", H5P_DEFAULT), H5Dclose);
    const hsize_t rows = 7;
    ASSERT_GE(H5Dset_extent(set, &rows), 0);
  }
  EXPECT_EQ(refusal_of(file), "");
  EXPECT_EQ(ReplayReader(file).transitions(), 1u);
}

}  // namespace
}  // namespace skybody::test
