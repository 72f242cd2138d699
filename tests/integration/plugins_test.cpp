// Trust in plugins: which folders the program loads plugins from, and the messages about plugins
// that end the process.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "tests/integration/process.h"

namespace skybody::test {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::EndsWith;
using testing::HasSubstr;
using testing::StartsWith;

constexpr const char* kHostile = SKYBODY_BINARY_DIR "/tests/plugins/hostile";

/// A folder with a scenario whose robot has a controller from an untrusted folder.
class Stranger : public testing::Test {
 protected:
  explicit Stranger(const std::string& controllers = "[{plugin: leaves_a_mark}, {plugin: ctbt}]") {
    std::ofstream(place() / "scenario.yaml")
        << "stepping: {horizon: 50}\nrobots:\n  - name: quad\n    model: qdrone2\n"
        << "    controllers: " << controllers << "\ntask: {plugin: hover}\n";
  }
  fs::path place() const { return fs::canonical(folder_.path()); }
  bool left_a_mark() const { return fs::exists(place() / "mark"); }
  fs::path put(const std::string& plugin, const std::string& where) const {
    fs::create_directories(place() / where);
    const fs::path file = place() / where / (plugin + ".so");
    fs::copy_file(fs::path(kHostile) / file.filename(), file);
    return file;
  }
  Outcome run(const std::vector<std::string>& arguments,
              const std::vector<std::string>& environment = {}) const {
    ProcessOptions options{.folder = place(), .environment = environment};
    options.environment.push_back("SKYBODY_TEST_MARK=" + (place() / "mark").string());
    return run_skybody(arguments, options);
  }
  std::string not_searched(const std::string& scenario, const fs::path& file) const {
    const std::string folder = file.parent_path().string();
    return scenario +
           ":5:28: error: the controller `leaves_a_mark` cannot be used: " + file.string() +
           " lies beside the scenario and is not opened; if you trust it: --trust-scenario, "
           "--plugin-path " +
           folder + " or SKYBODY_PLUGIN_PATH=" + folder + " (in Python plugin_path)\n";
  }

 private:
  TemporaryFolder folder_;
};

TEST_F(Stranger, BesideAScenarioIsNotRunUnlessAskedFor) {
  const fs::path file = put("leaves_a_mark", ".").lexically_normal();
  for (const std::string scenario : {"scenario.yaml", "./scenario.yaml"}) {
    const Outcome refused = run({"check", scenario});
    EXPECT_EQ(refused.exit_code, 2);
    EXPECT_EQ(refused.err, not_searched(scenario, file));
    EXPECT_FALSE(left_a_mark());
  }
  for (const std::string scenario : {"scenario.yaml", "./scenario.yaml"}) {
    const Outcome trusted = run({"check", scenario, "--trust-scenario"});
    EXPECT_EQ(trusted.exit_code, 0) << trusted.err;
    EXPECT_TRUE(left_a_mark());
    fs::remove(place() / "mark");
  }
}

TEST_F(Stranger, InTheScenariosPluginsIsNotRunUnlessAskedFor) {
  const fs::path file = put("leaves_a_mark", "plugins");
  for (const char* command : {"check", "hash", "run", "bench"}) {
    const Outcome refused = run({command, "scenario.yaml"});
    EXPECT_EQ(refused.exit_code, 2) << command;
    EXPECT_EQ(refused.err, not_searched("scenario.yaml", file)) << command;
    EXPECT_FALSE(left_a_mark()) << command;
  }
  const Outcome trusted = run({"hash", "scenario.yaml", "--steps", "5", "--trust-scenario"});
  EXPECT_EQ(trusted.exit_code, 0) << trusted.err;
  EXPECT_EQ(run({"hash", "scenario.yaml", "--steps", "5", "--plugin-path", "plugins"}).out,
            trusted.out);
  EXPECT_EQ(run({"hash", "scenario.yaml", "--steps", "5"}, {"SKYBODY_PLUGIN_PATH=plugins"}).out,
            trusted.out);
}

TEST_F(Stranger, ThatIsNotNamedIsNotRun) {
  put("leaves_a_mark", "plugins");
  const std::vector<std::string> other = {"--set", "robots.quad.controllers=[{plugin: ctbt}]"};
  for (const char* command : {"check", "hash"}) {
    std::vector<std::string> arguments = {command, "scenario.yaml", "--trust-scenario"};
    arguments.insert(arguments.end(), other.begin(), other.end());
    const Outcome outcome = run(arguments);
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    EXPECT_FALSE(left_a_mark());
  }
}

TEST_F(Stranger, InAFolderThatEverybodyMayWriteIsNotRun) {
  const fs::path file = put("leaves_a_mark", "shared");
  fs::permissions(file.parent_path(), fs::perms::all);
  const std::string reason = file.string() + ": is not opened: everybody may write its folder " +
                             file.parent_path().string() +
                             " (mode 0777); if you trust the library, chmod go-w " +
                             file.parent_path().string() + "\n";
  const Outcome checked = run({"check", "scenario.yaml", "--plugin-path", "shared"});
  EXPECT_EQ(checked.exit_code, 2);
  EXPECT_EQ(checked.err,
            "scenario.yaml:5:28: error: the controller `leaves_a_mark` cannot be used: " + reason);
  const Outcome listed = run({"plugins", "--plugin-path", "shared"});
  EXPECT_EQ(listed.exit_code, 0);
  EXPECT_THAT(listed.out, HasSubstr("\ncannot be used:\n  " + reason));
  EXPECT_EQ(run({"schema", "--plugin-path", "shared"}).exit_code, 0);
  EXPECT_FALSE(left_a_mark());
}

TEST_F(Stranger, InAReplaysPluginPathIsNamedAndNotRun) {
  const fs::path file = put("leaves_a_mark", "plugins");
  const std::vector<std::string> record = {
      "hash",    "scenario.yaml", "--steps", "5",     "--plugin-path",
      "plugins", "--record",      "run.h5",  "--set", "stepping.horizon=3"};
  ASSERT_EQ(run(record).exit_code, 0);
  ASSERT_TRUE(left_a_mark());
  fs::remove(place() / "mark");
  const Outcome refused = run({"replay", "run.h5"});
  EXPECT_EQ(refused.exit_code, 2);
  EXPECT_THAT(refused.err, StartsWith("warning: run.h5 was recorded with plugins from `" +
                                      file.parent_path().string() +
                                      "`, which is not searched; if you trust this folder, give "
                                      "it with --plugin-path\n"));
  EXPECT_THAT(refused.err, HasSubstr(" lies beside the scenario and is not opened"));
  EXPECT_FALSE(left_a_mark());
  const Outcome trusted = run({"replay", "run.h5", "--plugin-path", "plugins"});
  EXPECT_EQ(trusted.exit_code, 0) << trusted.err;
  EXPECT_EQ(trusted.err, "");
  EXPECT_THAT(trusted.out, StartsWith("identical"));
  EXPECT_EQ(run({"replay", "run.h5", "--trust-scenario"}).exit_code, 0);
}

/// A bare file name equals ./name: includes, models and plugins are found relative to it.
TEST_F(Stranger, ABareFileNameIsTheFileHere) {
  put("leaves_a_mark", "plugins");
  fs::copy(SKYBODY_SOURCE_DIR "/scenarios/models/qdrone2", place() / "model",
           fs::copy_options::recursive);
  std::ofstream(place() / "outer.yaml")
      << "include: scenario.yaml\nrobots:\n  - name: quad\n    model: model/qdrone2.urdf\n"
      << "    controllers: [{plugin: leaves_a_mark}, {plugin: ctbt}]\n";
  const Outcome bare = run({"check", "outer.yaml", "--trust-scenario"});
  EXPECT_EQ(bare.exit_code, 0) << bare.err;
  const Outcome dotted = run({"check", "./outer.yaml", "--trust-scenario"});
  EXPECT_EQ(dotted.exit_code, 0) << dotted.err;
  EXPECT_EQ(bare.out, dotted.out);
}

/// A plugin that ends the process that opens it, and the expected message.
struct Ending {
  std::string plugin, how;
};

class Ends : public Stranger, public testing::WithParamInterface<Ending> {
 protected:
  Ends() : Stranger("[{plugin: " + GetParam().plugin + "}]") {}
};

/// Sanitizers report a crash and exit with their own status.
void expect_how(const std::string& text, const std::string& how) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  (void)how;
  EXPECT_THAT(text, AnyOf(HasSubstr(" while it is loaded ("), HasSubstr(" in configure() of `")));
#else
  EXPECT_THAT(text, HasSubstr(how));
#endif
}

TEST_P(Ends, IsNamedByCheckAtTheScenariosLine) {
  const fs::path file = put(GetParam().plugin, "plugins");
  const Outcome outcome = run({"check", "scenario.yaml", "--trust-scenario"});
  EXPECT_EQ(outcome.signal, 0);
  EXPECT_EQ(outcome.exit_code, 2);
  EXPECT_EQ(outcome.out, "");
  ASSERT_EQ(lines_of(outcome.err).size(), 1u) << outcome.err;
  EXPECT_THAT(outcome.err,
              StartsWith("scenario.yaml:5:28: error: the controller `" + GetParam().plugin +
                         "` cannot be used: " + file.string() + ": "));
  expect_how(outcome.err, GetParam().how);
}

TEST_P(Ends, IsNamedByListsThatGoOn) {
  put(GetParam().plugin, "plugins");
  put("leaves_a_mark", "plugins");
  const Outcome listed = run({"plugins", "--plugin-path", "plugins"});
  EXPECT_EQ(listed.exit_code, 0) << listed.err;
  EXPECT_EQ(listed.err, "");
  EXPECT_THAT(listed.out, AllOf(HasSubstr("leaves_a_mark"), HasSubstr("rotor_speed")));
  const Outcome schema = run({"schema", "--plugin-path", "plugins"});
  EXPECT_EQ(schema.exit_code, 0) << schema.err;
  EXPECT_THAT(schema.out, AllOf(StartsWith("{"), EndsWith("}\n"), HasSubstr("leaves_a_mark")));
  if (GetParam().how.find("configure") != std::string::npos)
    return;  // these commands do not call configure()
  EXPECT_THAT(listed.out, HasSubstr("cannot be used:"));
  expect_how(listed.out, GetParam().how);
}

TEST_P(Ends, IsNamedByRunItself) {
  const fs::path file = put(GetParam().plugin, "plugins");
  const Outcome outcome = run({"run", "scenario.yaml", "--trust-scenario"});
  EXPECT_NE(outcome.exit_code, 0);
  EXPECT_THAT(outcome.err, HasSubstr("error: " + file.string() + ": "));
  const bool loads = GetParam().how.find("while it is loaded") != std::string::npos;
  EXPECT_THAT(outcome.err, HasSubstr("; `skybody check` says more\n"));
  EXPECT_THAT(outcome.err, HasSubstr(loads ? "while it is loaded" : "in configure() of `"));
}

INSTANTIATE_TEST_SUITE_P(
    Plugin, Ends,
    testing::Values(
        Ending{"exits_when_loaded", "ends the process while it is loaded (exit status 0)"},
        Ending{"crashes_when_loaded", "crashes while it is loaded (signal 11, Segmentation fault)"},
        Ending{"throws_when_loaded",
               "crashes while it is loaded (signal 6, Aborted, its last "
               "words are `what():  no licence`)"},
        Ending{"exits_in_configure",
               "ends the process in configure() of `exits_in_configure` (exit status 0)"},
        Ending{"overflows_in_configure",
               "crashes in configure() of `overflows_in_configure` (signal 11, Segmentation fault"},
        Ending{"signals_in_configure",
               "crashes in configure() of `signals_in_configure` (signal 11, Segmentation fault)"},
        Ending{"crashes_in_configure",
               "crashes in configure() of `crashes_in_configure` (signal 6, Aborted)"}),
    [](const auto& test) { return test.param.plugin; });

class Terminates : public Stranger {
 protected:
  Terminates() : Stranger("[{plugin: terminates_in_configure}]") {}
};

TEST_F(Terminates, IsNotTakenForTheUser) {
  put("terminates_in_configure", "plugins");
  const Outcome outcome = run({"check", "scenario.yaml", "--trust-scenario"});
  EXPECT_EQ(outcome.exit_code, 2);
  EXPECT_THAT(outcome.err, HasSubstr("crashes in configure() of `terminates_in_configure` (signal "
                                     "15, Terminated): mend it"));
}

/// One test for each function that ends a process.
class EndsInAStep : public Stranger, public testing::WithParamInterface<const char*> {
 protected:
  EndsInAStep()
      : Stranger("[{plugin: exits_in_a_step, parameters: {by: " + std::string(GetParam()) + "}}]") {
    put("exits_in_a_step", "plugins");
  }
  std::string words() const {
    return std::string("error: something calls ") + GetParam() +
           "() before the command is done, most likely a step of a plugin";
  }
};

TEST_P(EndsInAStep, IsNamedByCheck) {
  const Outcome outcome = run({"check", "scenario.yaml", "--trust-scenario"});
  EXPECT_EQ(outcome.exit_code, 2);
  EXPECT_THAT(outcome.err, HasSubstr("ends the process in a step of `exits_in_a_step` (exit status "
                                     "0): mend it"));
}

TEST_P(EndsInAStep, IsAnErrorOfRun) {
  const Outcome outcome =
      run({"run", "scenario.yaml", "--trust-scenario", "--policy", "zero", "--no-picture"});
  EXPECT_EQ(outcome.exit_code, 2);
  EXPECT_THAT(outcome.err, HasSubstr(words()));
}

TEST_P(EndsInAStep, IsAnErrorOfHash) {
  for (const std::string threads : {"1", "2"}) {
    const Outcome outcome =
        run({"hash", "scenario.yaml", "--trust-scenario", "--threads", threads});
    EXPECT_EQ(outcome.exit_code, 2) << threads;
    EXPECT_EQ(outcome.out, "");
    EXPECT_THAT(outcome.err, HasSubstr(words()));
  }
}

INSTANTIATE_TEST_SUITE_P(Functions, EndsInAStep,
                         testing::Values("exit", "quick_exit", "_Exit", "_exit"),
                         [](const auto& function) { return std::string(function.param); });

TEST_F(Stranger, ThatEndsTheProcessWhenUnloadedIsNamedByLists) {
  const std::string unloaded = ".so: ends the process while it is unloaded (exit status 0)";
  put("exits_when_unloaded", "plugins");
  put("exits_when_refused", "plugins");
  const Outcome listed = run({"plugins", "--plugin-path", "plugins"});
  EXPECT_EQ(listed.exit_code, 0) << listed.err;
  EXPECT_THAT(listed.out, AllOf(HasSubstr("rotor_speed"), HasSubstr("cannot be used:"),
                                HasSubstr("exits_when_unloaded" + unloaded),
                                HasSubstr("exits_when_refused" + unloaded)));
}

}  // namespace
}  // namespace skybody::test
