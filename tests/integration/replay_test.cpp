// Recordings and `skybody replay`.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <csignal>
#include <filesystem>
#include <fstream>
#include <limits>
#include <sstream>

#include "core/base/math/random.h"
#include "core/base/system/error.h"
#include "core/replay/replay_player.h"
#include "core/replay/replay_recorder.h"
#include "tests/integration/flips.h"
#include "tests/integration/process.h"

namespace skybody::test {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::EndsWith;
using testing::HasSubstr;
using testing::StartsWith;

// Short episodes, so that the comparison covers resets.
const std::string kHorizon = "stepping.horizon=7";

/// A Pool stepped in several ways, with every kind of event that a recording must contain.
class Recorded : public testing::Test {
 protected:
  static constexpr int kEnvs = 5;

  std::unique_ptr<Pool> make(PoolOptions options = {}) {
    options.envs = kEnvs;
    options.seed = 9;
    return std::make_unique<Pool>(compiled_, options);
  }

  std::vector<float> actions(std::size_t rows) {
    std::vector<float> values(rows * static_cast<std::size_t>(compiled_->action_size()));
    Random<double> random(RandomKey{1, 0}, 0, ++draws_, 5);
    for (float& value : values) value = static_cast<float>(random.uniform(-1.0, 1.0));
    return values;
  }

  void fly(Pool& envs, int steps) {
    for (int k = 0; k < steps; ++k) {
      const auto batch = envs.recv();
      const auto rows = static_cast<std::size_t>(batch->rows);
      envs.send(actions(rows), std::span(batch->env_id).first(rows));
    }
  }
  static void finish(Pool& envs) {
    while (envs.in_flight() > 0) envs.recv();
  }

  ReplayReport replay(int threads = 2) {
    ReplayReader reader(file_);
    return play(reader, compiled_, threads);
  }

  const LoadOptions load_ = {"hover", {kHorizon}, {}};
  const std::shared_ptr<const CompiledScenario> compiled_ = compile_scenario(load_);
  const TemporaryFolder folder_;
  const fs::path file_ = folder_.path() / "run.h5";
  std::uint64_t draws_ = 0;
};

TEST_F(Recorded, EverythingThatCanBeDoneIsReplayedOnAnyNumberOfThreads) {
  const auto envs = make({.batch = 2, .threads = 2, .order = Order::kArrival});
  const auto recorder = start_recording(*envs, file_, {load_, true});
  envs->send_reset();
  fly(*envs, 30);
  finish(*envs);
  const std::vector<std::uint64_t> saved = envs->save();
  const std::string path = compiled_->layout().param_info.at(0).path;
  envs->set_param(3, path, compiled_->layout().param_info[0].nominal);
  const std::int32_t targets[] = {0, 4};
  envs->fork(2, targets, true);
  envs->send(actions(kEnvs));
  fly(*envs, 12);
  finish(*envs);
  envs->send_reset(std::uint64_t{77});
  fly(*envs, 9);
  finish(*envs);
  envs->restore(saved);
  std::vector<float> bad = actions(1);
  bad[0] = std::numeric_limits<float>::quiet_NaN();
  const std::int32_t one[] = {1};
  envs->send(bad, one);
  finish(*envs);
  const std::uint8_t mask[] = {0, 1, 0, 1, 0};
  envs->send_reset(mask);
  finish(*envs);
  stop_recording(*envs, *recorder);
  for (const int threads : {1, 3}) {
    const ReplayReport report = replay(threads);
    EXPECT_TRUE(report.identical()) << report.text(ReplayReader(file_).header(), "a", "b");
    EXPECT_EQ(report.transitions, ReplayReader(file_).transitions());
  }
}

TEST_F(Recorded, AutoresetModesAreReplayed) {
  for (const Autoreset mode : {Autoreset::kNextStep, Autoreset::kSameStep, Autoreset::kDisabled}) {
    const auto envs = make({.autoreset = mode});
    const auto recorder = start_recording(*envs, file_);
    envs->send_reset();
    const int steps = mode == Autoreset::kDisabled ? 7 : 20;
    fly(*envs, steps);
    finish(*envs);
    stop_recording(*envs, *recorder);
    const ReplayReport report = replay();
    EXPECT_TRUE(report.identical());
    EXPECT_EQ(report.transitions, static_cast<std::size_t>(kEnvs * (steps + 1)));
  }
}

TEST_F(Recorded, BeginsInTheMiddleAndLeavesHashesAsTheyWere) {
  const auto envs = make();
  envs->send_reset();
  fly(*envs, 4);
  finish(*envs);
  const auto recorder = start_recording(*envs, file_);
  envs->send(actions(kEnvs));
  fly(*envs, 3);
  finish(*envs);
  stop_recording(*envs, *recorder);
  EXPECT_THROW(envs->hash(), Error) << "made without keep_hash";
  EXPECT_TRUE(replay().identical());
}

TEST_F(Recorded, IsReadableUpToTheLastFlushWhateverHappensAfterwards) {
  const auto envs = make();
  const auto recorder = start_recording(*envs, file_);
  envs->send_reset();
  fly(*envs, 10);
  recorder->flush();
  fly(*envs, 10);
  const fs::path copy = folder_.path() / "copy.h5";  // the file that a crash now would leave
  fs::copy_file(file_, copy);
  ReplayReader reader(copy);
  const ReplayReport report = play(reader, compiled_, 1);
  EXPECT_TRUE(report.identical());
  EXPECT_EQ(report.transitions, 10u * kEnvs);
  stop_recording(*envs, *recorder);
}

/// Limits the size of files that this process writes to `bytes` during its lifetime, as on a full
/// disk.
class FileLimit {
 public:
  explicit FileLimit(std::uintmax_t bytes) : handler_(std::signal(SIGXFSZ, SIG_IGN)) {
    ::getrlimit(RLIMIT_FSIZE, &before_);
    rlimit now = before_;
    now.rlim_cur = bytes;
    ::setrlimit(RLIMIT_FSIZE, &now);
  }
  ~FileLimit() {
    ::setrlimit(RLIMIT_FSIZE, &before_);
    std::signal(SIGXFSZ, handler_);
  }

 private:
  void (*handler_)(int);
  rlimit before_{};
};

TEST_F(Recorded, IsKeptUpToItsLastWholeBurstWhereTheNextCannotBeWritten) {
  const auto envs = make();
  const auto recorder = start_recording(*envs, file_);
  envs->send_reset();
  fly(*envs, 10);
  recorder->flush();
  std::string message;
  {
    const FileLimit full(fs::file_size(file_));
    try {
      for (int k = 0; k < 50; ++k) {
        fly(*envs, 50);
        recorder->flush();
      }
    } catch (const Error& error) {
      message = error.what();
    }
  }
  EXPECT_THAT(message,
              HasSubstr("; the recording has ended; the file is kept and can be replayed"));
  EXPECT_FALSE(recorder->recording());
  EXPECT_TRUE(replay().identical());
  EXPECT_GE(replay().transitions, 10u * kEnvs);
}

TEST_F(Recorded, IsRemovedWhereNoBurstWithTransitionsWasWritten) {
  const auto envs = make();
  const auto recorder = start_recording(*envs, file_);
  envs->send_reset();
  std::string message;
  {
    const FileLimit full(fs::file_size(file_));
    try {
      fly(*envs, 10);
      recorder->flush();
    } catch (const Error& error) {
      message = error.what();
    }
  }
  EXPECT_THAT(message, HasSubstr("; the recording has ended, and the file is removed: "));
  EXPECT_FALSE(fs::exists(file_));
}

TEST_F(Recorded, IsRefusedInAnotherScenario) {
  const auto other = compile_scenario({"hover", {kHorizon, "gravity=[0, 0, -9.8]"}, {}});
  const auto envs = make();
  const auto recorder = start_recording(*envs, file_, {load_, true});
  envs->send_reset();
  fly(*envs, 10);
  finish(*envs);
  stop_recording(*envs, *recorder);
  ReplayReader reader(file_);
  try {
    play(reader, other, 1);
    FAIL() << "another scenario was accepted";
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), AllOf(HasSubstr("run.h5 was recorded in the scenario `hover`"),
                                    HasSubstr("its merged text differs from line ")));
  }
}

TEST_F(Recorded, AChangeThatIsNotInTheRecordingIsFoundAndNamed) {
  const EnvParam param = compiled_->layout().param_info.at(0);
  const auto envs = make();
  const auto recorder = start_recording(*envs, file_, {load_, true});
  envs->send_reset();
  fly(*envs, 4);
  finish(*envs);
  envs->observe(nullptr);
  envs->set_param(2, param.path, 0.5 * (param.nominal + param.max));
  envs->observe(recorder);
  envs->send(actions(kEnvs));
  fly(*envs, 1);
  finish(*envs);
  stop_recording(*envs, *recorder);
  const ReplayReport report = replay();
  ASSERT_TRUE(report.where.has_value());
  EXPECT_EQ(report.parted, 1u);
  EXPECT_EQ(report.where->first.env, 2);
  EXPECT_EQ(report.where->transition, 6u) << "a reset and four actions went before";
  EXPECT_THAT(
      report.text(ReplayReader(file_).header(), "recorded", "replayed"),
      AllOf(StartsWith("first difference: environment 2, transition 6 (episode 1, step 5); 1 of 5 "
                       "environments differ\n"),
            HasSubstr("state params " + param.path)));
}

TEST_F(Recorded, TwoRecordingsPartWhereTheirActionsDo) {
  const fs::path second = folder_.path() / "second.h5";
  for (const fs::path& file : {file_, second}) {
    draws_ = 0;
    const auto envs = make();
    const auto recorder = start_recording(*envs, file, {load_, true});
    envs->send_reset();
    fly(*envs, 4);
    finish(*envs);
    std::vector<float> row = actions(kEnvs);
    if (file == second) row[3 * row.size() / kEnvs] *= 0.5f;  // of environment 3
    envs->send(row);
    fly(*envs, 3);
    finish(*envs);
    stop_recording(*envs, *recorder);
  }
  const ReplayReader a(file_), b(second);
  const ReplayReport report = compare_replays(a, b);
  ASSERT_TRUE(report.where.has_value());
  EXPECT_EQ(report.parted, 1u);
  EXPECT_EQ(report.where->first.env, 3);
  EXPECT_EQ(report.where->transition, 6u) << "a reset and four actions went before";
  EXPECT_EQ(report.where->first.episode_step, 5);
  EXPECT_EQ(report.where->differences.at(0).name, "action[0]");
  const std::string text = report.text(a.header(), "first", "second");
  EXPECT_THAT(
      text, StartsWith("first difference: environment 3, transition 6 (episode 1, step 5); 1 of 5 "
                       "environments differ\n"));
  EXPECT_THAT(text, HasSubstr("state rotor_speed quad."));
  EXPECT_TRUE(compare_replays(a, a).identical());
}

/// All content of a file that a replay's user can see.
std::string content_of(const fs::path& file) {
  ReplayReader reader(file);
  const ReplayHeader& h = reader.header();
  std::ostringstream out;
  out << h.skybody_version << h.scenario_name << h.scenario_file << h.scenario_text << h.autoreset
      << h.scenario_hash << ' ' << h.seed << ' ' << h.first_env_id << ' ' << h.envs << ' '
      << h.action_size;
  for (const auto* list :
       {&h.overrides, &h.plugin_path, &h.columns, &h.observation_names, &h.state_names}) {
    for (const std::string& text : *list) out << text << ',';
  }
  ReplayEvent event;
  while (reader.next(event)) {
    out << static_cast<int>(event.kind) << ' ' << event.argument << event.path;
    for (const auto id : event.env_ids) out << id << ' ';
    for (const auto word : event.saved) out << word << ' ';
    for (const float value : event.actions) out << value << ' ';
  }
  for (std::size_t k = 0; k < reader.transitions(); ++k) {
    const ReplayRow row = reader.row(k);
    out << row.env << ' ' << row.hash << ' ' << row.episode << ' ' << row.episode_step << ' '
        << row.was_reset << ' ' << row.status << ' ' << row.reward;
    for (const float value : row.observation) out << ' ' << value;
    for (const auto word : row.state) out << ' ' << word;
  }
  return out.str();
}

TEST_F(Recorded, WithATurnedBitItIsRefusedOrTheSame) {
  const auto envs = make();
  const auto recorder = start_recording(*envs, file_, {load_, true});
  envs->send_reset();
  fly(*envs, 12);
  recorder->flush();
  fly(*envs, 12);
  finish(*envs);
  stop_recording(*envs, *recorder);
  const FlipCounts counts = flip_bits(file_, flips_wanted(500), [&] { return content_of(file_); });
  std::printf("%s\n", testing::PrintToString(counts).c_str());
  EXPECT_EQ(counts, (FlipCounts{.refused = counts.refused, .same = counts.same}));
}

TEST(Replay, ARecordingThatCtrlCEndedIsReplayed) {
  const TemporaryFolder folder;
  const ProcessOptions here{.folder = folder.path()};
  ProcessOptions interrupted = here;
  const fs::path file = folder.path() / "run.h5";
  interrupted.interrupt_when = [&] {  // the first burst after the start has been written
    std::error_code error;
    constexpr std::uintmax_t kOneBurst = 1 << 20;
    return fs::exists(file, error) && fs::file_size(file, error) > kOneBurst;
  };
  const Outcome recorded = run_skybody(
      {"hash", "hover", "--envs", "8", "--steps", "1000000000", "--record", "run.h5"}, interrupted);
  EXPECT_EQ(recorded.exit_code, 130);
  EXPECT_EQ(recorded.out, "");
  EXPECT_EQ(recorded.err, "warning: interrupted; what was done so far is in run.h5\n");
  const Outcome replayed = run_skybody({"replay", "run.h5"}, here);
  EXPECT_EQ(replayed.exit_code, 0) << replayed.err;
  EXPECT_THAT(replayed.out, StartsWith("identical: "));
}

TEST(Replay, RunsWhatHashRecorded) {
  const TemporaryFolder folder;
  const ProcessOptions here{.folder = folder.path()};
  const Outcome recorded =
      run_skybody({"hash", "hover", "--envs", "4", "--batch", "2", "--threads", "2", "--order",
                   "arrival", "--steps", "30", "--set", kHorizon, "--record", "run.h5"},
                  here);
  ASSERT_EQ(recorded.exit_code, 0) << recorded.err;
  EXPECT_EQ(recorded.out,
            run_skybody({"hash", "hover", "--envs", "4", "--steps", "30", "--set", kHorizon}).out)
      << "recording changed the run";
  const Outcome replayed = run_skybody({"replay", "run.h5", "--threads", "1"}, here);
  EXPECT_EQ(replayed.exit_code, 0) << replayed.err;
  EXPECT_EQ(replayed.out, "identical: 124 transitions\n");
  EXPECT_EQ(replayed.err, "");
}

TEST(Replay, SaysWhereTwoRecordingsPartWithExitStatusOne) {
  const TemporaryFolder folder;
  const ProcessOptions here{.folder = folder.path()};
  for (const char* seed : {"1", "2"}) {
    const Outcome outcome = run_skybody({"hash", "hover", "--envs", "2", "--steps", "5", "--seed",
                                         seed, "--record", std::string(seed) + ".h5"},
                                        here);
    ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  }
  const Outcome outcome = run_skybody({"replay", "1.h5", "--against", "2.h5"}, here);
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_THAT(outcome.out,
              StartsWith("first difference: environment 0, transition 1 (episode 1, step 0, a "
                         "reset); 2 of 2 environments differ\n"));
  EXPECT_EQ(outcome.err, "");
  EXPECT_EQ(run_skybody({"replay", "1.h5", "--against", "1.h5"}, here).exit_code, 0);
}

TEST(Replay, RefusesAScenarioThatHasChanged) {
  const TemporaryFolder folder;
  const ProcessOptions here{.folder = folder.path()};
  const auto write = [&](const char* gravity) {
    std::ofstream(folder.path() / "mine.yaml")
        << "include: hover.yaml\ngravity: " << gravity << "\n";
  };
  write("[0, 0, -9.81]");
  ASSERT_EQ(
      run_skybody({"hash", "mine.yaml", "--steps", "5", "--record", "run.h5"}, here).exit_code, 0);
  EXPECT_EQ(run_skybody({"replay", "run.h5"}, here).exit_code, 0);
  write("[0, 0, -1.62]");
  const Outcome outcome = run_skybody({"replay", "run.h5"}, here);
  EXPECT_EQ(outcome.exit_code, 2);
  EXPECT_EQ(outcome.out, "");
  EXPECT_THAT(outcome.err, AllOf(HasSubstr("error: run.h5 was recorded in the scenario"),
                                 HasSubstr("its merged text differs from line ")));
}

TEST(Replay, SaysWhatIsWrongWithFilesThatAreNoRecordings) {
  const TemporaryFolder folder;
  const ProcessOptions here{.folder = folder.path()};
  ASSERT_EQ(run_skybody({"hash", "hover", "--steps", "5", "--record", "run.h5"}, here).exit_code,
            0);
  fs::copy_file(folder.path() / "run.h5", folder.path() / "cut.h5");
  fs::resize_file(folder.path() / "cut.h5", fs::file_size(folder.path() / "cut.h5") / 2);
  std::ofstream(folder.path() / "text.h5") << "not HDF5";
  ASSERT_EQ(run_skybody({"run", "hover", "--steps", "3", "--no-picture", "--out", "flight"}, here)
                .exit_code,
            0);
  const auto error_of = [&](const char* file) {
    const Outcome outcome = run_skybody({"replay", file}, here);
    EXPECT_EQ(outcome.exit_code, 2) << file;
    EXPECT_EQ(outcome.out, "");
    EXPECT_EQ(lines_of(outcome.err).size(), 1u) << outcome.err;
    return outcome.err;
  };
  EXPECT_EQ(error_of("gone.h5"), "gone.h5: error: the file does not exist\n");
  EXPECT_THAT(error_of("cut.h5"), StartsWith("cut.h5: error: not a replay file, or cut short: "));
  const std::string remedy = "; give a recording, which `skybody hash --record FILE` writes\n";
  EXPECT_THAT(error_of("text.h5"),
              AllOf(StartsWith("text.h5: error: not a replay file"), EndsWith(remedy)));
  EXPECT_EQ(error_of("flight/flight.h5"),
            "flight/flight.h5: error: not a replay: its format is a text of variable length, as no "
            "replay has" +
                remedy);
}

}  // namespace
}  // namespace skybody::test
