// The task kit's histories, verdicts and terms of rewards, by hand.
#include <gtest/gtest.h>
#include <skybody/task_kit.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace skybody::task_kit {
namespace {

Values<double> values_of(std::vector<double>& numbers) { return {numbers.data(), 1, true}; }

TEST(TaskKitHistory, ShowsTheNewestEntryFirst) {
  BufferPlan plan;
  const History other(plan, 1, 1), history(plan, 3, 2);
  std::vector<double> words(static_cast<std::size_t>(plan.size()), 0.0), row(8, 7.0);
  const Values<double> buffer = values_of(words);
  history.fill(buffer, [](int k) { return 10.0 + k; });
  for (double entry = 1.0; entry < 3.0; ++entry) {
    history.push(buffer, true, [&](int k) { return 20.0 * entry + k; });
  }
  history.observe(buffer, Part(1, history.size()), values_of(row));
  EXPECT_EQ(row, (std::vector<double>{7, 40, 41, 20, 21, 10, 11, 7}));
  EXPECT_EQ(words[0], 0.0);  // the other history's
}

TEST(TaskKitHistory, KeepsWhatItHasWhereNothingIsDue) {
  BufferPlan plan;
  const History history(plan, 2, 1);
  std::vector<double> words{1.0, 2.0};
  history.push(values_of(words), false, [](int) { return 3.0; });
  EXPECT_EQ(words, (std::vector<double>{1.0, 2.0}));
}

TEST(TaskKitWindow, BeginsNow) {
  const Window window{20, 0.01};
  EXPECT_EQ(window.time(3.0, 0), 3.0);
  EXPECT_DOUBLE_EQ(window.time(3.0, 19), 3.19);
}

/// An Evaluation of one environment.
struct Evaluated {
  std::vector<double> observation = std::vector<double>(1), info = std::vector<double>(3, -1.0),
                      reward = std::vector<double>(1);
  std::uint64_t end = 0;
  Evaluation<double> out(bool wants_info) {
    return {values_of(observation),
            values_of(info),
            values_of(reward),
            values_of(reward),
            &end,
            true,
            wants_info};
  }
};
const Part kTilt(0, 1), kBound(1, 1), kSuccess(2, 1);

TEST(TaskKitVerdict, EndsTheEpisodeWithItsScopeAndNamesTheReason) {
  Evaluated now;
  {
    Evaluation<double> out = now.out(true);
    Verdict<double> verdict(out);
    verdict.fail(kTilt, false);
    verdict.fail(kBound, true);
    verdict.succeed(kSuccess, true);
  }
  EXPECT_EQ(now.info, (std::vector<double>{0, 1, 0}));  // a failure is not a success
  EXPECT_EQ(now.end, 1u);
}

TEST(TaskKitVerdict, SuccessMayGoOnOrEndTheEpisode) {
  for (const bool ends : {false, true}) {
    Evaluated now;
    {
      Evaluation<double> out = now.out(true);
      Verdict<double> verdict(out);
      verdict.fail(kTilt, false);
      if (ends) {
        verdict.finish(kSuccess, true);
      } else {
        verdict.succeed(kSuccess, true);
      }
    }
    EXPECT_EQ(now.info[2], 1.0);
    EXPECT_EQ(now.end, ends ? 1u : 0u);
  }
}

TEST(TaskKitVerdict, WritesNoInfosWhereNobodyLooks) {
  Evaluated now;
  Evaluation<double> out = now.out(false);
  Verdict<double>(out).fail(kTilt, true);
  EXPECT_EQ(now.info, std::vector<double>(3, -1.0));
  EXPECT_EQ(now.end, 1u);
}

TEST(TaskKitShaping, HasItsClosedForms) {
  EXPECT_DOUBLE_EQ(closeness(2.0, 0.5), 0.5);
  EXPECT_DOUBLE_EQ(approach(2.5, 10.0), 0.75);
  EXPECT_EQ(approach(11.0, 10.0), 0.0);
  const Quat<double> tilted{std::cos(0.5), std::sin(0.5), 0.0, 0.0};  // by 1 rad
  EXPECT_NEAR(tilt_wall(tilted, 0.1), 1.0 / std::cos(1.0) - 1.0, 1e-14);
  EXPECT_NEAR(tilt(tilted), 1.0, 1e-14);
}

TEST(TaskKitParts, WriteMatricesRowByRow) {
  std::vector<double> row(10);
  Part(1, 9).set(values_of(row), Mat3<double>{{1, 2, 3, 4, 5, 6, 7, 8, 9}});
  EXPECT_EQ(row, (std::vector<double>{0, 1, 2, 3, 4, 5, 6, 7, 8, 9}));
}

/// The definition, point by point.
double hausdorff_by_definition(const std::vector<Vec3<double>>& a,
                               const std::vector<Vec3<double>>& b) {
  const auto farthest = [](const auto& from, const auto& to) {
    double result = 0.0;
    for (const Vec3<double>& p : from) {
      double nearest = kInfinity;
      for (const Vec3<double>& q : to) nearest = std::min(nearest, norm(p - q));
      result = std::max(result, nearest);
    }
    return result;
  };
  return std::max(farthest(a, b), farthest(b, a));
}

TEST(TaskKitHausdorff, IsTheFarthestOfTheNearestEitherWay) {
  for (const int count : {1, 2, 20, 32, 33, 70}) {  // two passes from 33 on
    std::vector<Vec3<double>> a, b;
    for (int i = 0; i < count; ++i) {
      a.push_back({std::sin(7.0 * i), std::cos(3.0 * i), 0.1 * i});
      b.push_back({std::sin(5.0 * i + 1.0), 0.3 * std::cos(2.0 * i), 0.05 * i});
    }
    const auto point = [](const std::vector<Vec3<double>>& of) {
      return [&of](int i) { return of[static_cast<std::size_t>(i)]; };
    };
    EXPECT_DOUBLE_EQ(hausdorff_distance<double>(count, point(a), point(b)),
                     hausdorff_by_definition(a, b))
        << count;
  }
}

}  // namespace
}  // namespace skybody::task_kit
