// Trust: owners and permissions of libraries that may be opened.
#include "core/plugin_host/trust.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sched.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <fstream>

#include "tests/unit/plugins/small_world.h"

namespace skybody {
namespace {

using std::filesystem::path;
using testing::HasSubstr;

/// outer/inner/x.so in a folder of this user.
class Trust : public testing::Test {
 protected:
  Trust() : outer(root.path() / "outer"), inner(outer / "inner"), file(inner / "x.so") {
    std::filesystem::create_directories(inner);
    std::ofstream(file) << "x";
    set_mode(outer, 0755);
    set_mode(inner, 0755);
    set_mode(file, 0644);
  }
  static void set_mode(const path& place, mode_t mode) { ASSERT_EQ(chmod(place.c_str(), mode), 0); }

  const test::Folder root;
  const path outer, inner, file;
};

TEST_F(Trust, IsGivenToWhatOnlyTheUserMayWrite) { EXPECT_EQ(trust_problem(file), ""); }

TEST_F(Trust, IsNotGivenToAFileThatEverybodyMayWrite) {
  set_mode(file, 0666);
  EXPECT_EQ(trust_problem(file),
            "is not opened: everybody may write it (mode 0666); if you trust the library, chmod "
            "go-w " +
                file.string());
}

TEST_F(Trust, IsNotGivenToAFolderThatEverybodyMayWrite) {
  set_mode(inner, 0777);
  EXPECT_EQ(trust_problem(file), "is not opened: everybody may write its folder " + inner.string() +
                                     " (mode 0777); if you trust the library, chmod go-w " +
                                     inner.string());
}

TEST_F(Trust, IsNotGivenToAStickyFolder) {
  set_mode(inner, 01777);
  EXPECT_EQ(trust_problem(file), "is not opened: everybody may write its folder " + inner.string() +
                                     " (mode 1777); if you trust the library, move it into a "
                                     "folder of your own");
}

TEST_F(Trust, IsNotGivenBelowAFolderThatEverybodyMayWrite) {
  set_mode(outer, 0777);
  EXPECT_EQ(trust_problem(file),
            "is not opened: everybody may write the folder " + outer.string() +
                " above it (mode 0777); if you trust the library, chmod go-w " + outer.string());
}

TEST_F(Trust, IsGivenBelowAStickyFolder) {
  set_mode(outer, 01777);
  EXPECT_EQ(trust_problem(file), "");
}

TEST_F(Trust, IsGivenToThePrivateGroupAlone) {
  set_mode(inner, 0775);
  if (geteuid() != 0) GTEST_SKIP() << "only root can give files away";
  EXPECT_EQ(trust_problem(file), "");  // root's group has no other members
  constexpr gid_t kDaemon = 1;
  ASSERT_EQ(chown(inner.c_str(), 0, kDaemon), 0);
  EXPECT_THAT(trust_problem(file), HasSubstr("` may write its folder " + inner.string()));
}

constexpr uid_t kNobodysNumber = 54321;  // without a name

/// trust_problem(file) in a child process that `become` has switched to another user.
template <class Become>
std::string problem_as(const Become& become, const path& file) {
  int ends[2];
  if (pipe(ends) != 0) return "no pipe";
  const pid_t child = fork();
  if (child == 0) {
    const std::string text = become() ? trust_problem(file) : "cannot become another user";
    const ssize_t written = write(ends[1], text.data(), text.size());
    _exit(written < 0 ? 1 : 0);
  }
  close(ends[1]);
  char text[4096];
  const ssize_t size = read(ends[0], text, sizeof text);
  close(ends[0]);
  waitpid(child, nullptr, 0);
  return size > 0 ? std::string(text, static_cast<std::size_t>(size)) : std::string();
}

TEST_F(Trust, IsGivenToTheGroupOfTheUsersNumberWhereNeitherHasAName) {
  if (geteuid() != 0) GTEST_SKIP() << "only root can become another user";
  set_mode(root.path(), 0755);
  set_mode(inner, 0775);
  set_mode(file, 0664);
  for (const path& place : {inner, file}) {
    ASSERT_EQ(chown(place.c_str(), kNobodysNumber, kNobodysNumber), 0);
  }
  const auto become = [] { return setgid(kNobodysNumber) == 0 && setuid(kNobodysNumber) == 0; };
  EXPECT_EQ(problem_as(become, file), "");
  ASSERT_EQ(chown(inner.c_str(), kNobodysNumber, kNobodysNumber + 1), 0);
  EXPECT_THAT(problem_as(become, file), HasSubstr("the group `54322` may write its folder"));
}

TEST_F(Trust, IsGivenBelowFoldersOfARootThatIsNotMapped) {
  if (geteuid() != 0) GTEST_SKIP() << "only root can give files away";
  ASSERT_EQ(chown(outer.c_str(), kNobodysNumber, kNobodysNumber), 0);
  const auto become = [] {  // root outside is 1000 inside, and no other user is mapped
    if (unshare(CLONE_NEWUSER) != 0) return false;
    std::ofstream("/proc/self/uid_map") << "1000 0 1\n";
    return geteuid() == 1000;
  };
  const std::string problem = problem_as(become, file);
  if (problem == "cannot become another user") GTEST_SKIP() << "no user namespaces here";
  EXPECT_EQ(problem, "");
  ASSERT_EQ(chown(inner.c_str(), kNobodysNumber, kNobodysNumber), 0);
  EXPECT_THAT(problem_as(become, file), HasSubstr("its folder " + inner.string() + " belongs to"));
}

TEST_F(Trust, IsNotGivenToAnotherUsersFile) {
  if (geteuid() != 0) GTEST_SKIP() << "only root can give files away";
  ASSERT_EQ(chown(file.c_str(), kNobodysNumber, 0), 0);
  EXPECT_EQ(trust_problem(file),
            "is not opened: it belongs to the user `54321`, not to you or root (mode 0644); if you "
            "trust the library, copy it into a folder of your own");
  ASSERT_EQ(chown(file.c_str(), 0, 0), 0);
  ASSERT_EQ(chown(outer.c_str(), kNobodysNumber, 0), 0);
  EXPECT_THAT(trust_problem(file),
              HasSubstr("the folder " + outer.string() + " above it belongs to the user `54321`"));
}

}  // namespace
}  // namespace skybody
