// The flight log: the content reads back as written, and write failures are reported.
#include "core/io/files/flight_log.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <vector>

#include "core/base/system/error.h"
#include "tests/integration/flight_file.h"
#include "tests/integration/process.h"

namespace skybody::test {
namespace {

using testing::ElementsAre;

/// As in the program.
const bool cleanup_skipped = (skip_hdf5_cleanup_at_exit(), true);

FlightLogHeader small_header() {
  FlightLogHeader header;
  header.scenario_name = "small";
  header.scenario_text = std::string(100000, 'x');  // larger than an HDF5 attribute
  header.seed = 18446744073709551615u;
  header.dt = 0.001;
  header.versions = {{"skybody", "1.2.3"}};
  header.bodies = {"a.base", "a.arm"};
  header.q = {{"a.base.x", "m"}};
  header.params = {{"robots.a.links.base.mass", "kg"}};
  header.nominal_params = {2.0};
  return header;
}

/// Adds `rows` rows whose values are all distinct.
void add_rows(FlightLog& log, int rows) {
  for (int i = 0; i < rows; ++i) {
    std::vector<double> bodies(26);
    for (std::size_t k = 0; k < bodies.size(); ++k) bodies[k] = 100.0 * i + static_cast<double>(k);
    const double q = 0.5 * i;
    FlightLogRow row;
    row.time = 0.001 * i;
    row.bodies = bodies;
    row.q = std::span(&q, 1);
    row.reward = static_cast<float>(i);
    row.status = i + 1 == rows ? 2 : 0;
    row.touching = static_cast<std::uint8_t>(i % 2);
    log.add(row);
  }
}

TEST(FlightLog, ReturnsEveryRowAcrossChunks) {
  const TemporaryFolder folder;
  const int rows = 2500;
  FlightLog log(folder.path() / "a.h5", small_header());
  const double drawn = 2.25;
  log.begin_episode(std::span(&drawn, 1));
  add_rows(log, rows);
  log.event("truncated");
  log.close();

  const FlightFile file(folder.path() / "a.h5");
  EXPECT_THAT(file.shape("/episodes/0001/bodies"), ElementsAre(rows, 2, 13));
  const std::vector<double> bodies = file.values("/episodes/0001/bodies");
  EXPECT_EQ(bodies[26 * 2400 + 25], 240025.0);
  EXPECT_EQ(file.values("/episodes/0001/q").back(), 0.5 * (rows - 1));
  EXPECT_EQ(file.values("/episodes/0001/status").back(), 2.0);
  EXPECT_EQ(file.values("/episodes/0001/touching").back(), (rows - 1) % 2);
  EXPECT_THAT(file.values("/episodes/0001/params"), ElementsAre(2.25));
  EXPECT_THAT(file.values("/params/nominal"), ElementsAre(2.0));
  EXPECT_THAT(file.texts("/params/paths"), ElementsAre("robots.a.links.base.mass"));
  EXPECT_THAT(file.events("/episodes/0001"), ElementsAre("truncated"));
  EXPECT_EQ(file.text_attribute("/", "scenario_text").size(), 100000u);
  EXPECT_EQ(file.text_attribute("/", "seed"), "18446744073709551615");
  EXPECT_EQ(file.text_attribute("/versions", "skybody"), "1.2.3");
}

TEST(FlightLog, LeavesOutWhatAScenarioDoesNotHave) {
  const TemporaryFolder folder;
  FlightLog log(folder.path() / "a.h5", small_header());
  const double drawn = 2.0;
  log.begin_episode(std::span(&drawn, 1));
  add_rows(log, 1);
  log.close();
  const FlightFile file(folder.path() / "a.h5");
  EXPECT_FALSE(file.has("/episodes/0001/sensors"));
  EXPECT_TRUE(file.has("/episodes/0001/time"));
}

TEST(FlightLog, KeepsWhatWasFlownWhenItIsNotClosed) {
  const TemporaryFolder folder;
  {
    FlightLog log(folder.path() / "a.h5", small_header());
    const double drawn = 2.0;
    log.begin_episode(std::span(&drawn, 1));
    add_rows(log, 10);
  }
  EXPECT_THAT(FlightFile(folder.path() / "a.h5").shape("/episodes/0001/time"), ElementsAre(10));
}

TEST(FlightLog, SaysWhyItCannotWrite) {
  try {
    FlightLog log("/nowhere/at/all.h5", small_header());
    FAIL() << "no error";
  } catch (const Error& error) {
    EXPECT_EQ(std::string(error.what()),
              "cannot write the flight log /nowhere/at/all.h5: No such file or directory");
  }
}

TEST(FlightLog, SaysWhenTheDiskIsFull) {
  FlightLogHeader header = small_header();
  header.scenario_text = "small";
  const auto fill = [&] {
    FlightLog log("/dev/full", header);
    const double drawn = 2.0;
    log.begin_episode(std::span(&drawn, 1));
    add_rows(log, 5000);
    log.close();
  };
  EXPECT_THROW(fill(), Error);
}

}  // namespace
}  // namespace skybody::test
