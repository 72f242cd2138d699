#include "core/base/system/arguments.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <vector>

#include "core/base/system/error.h"

namespace skybody {
namespace {

using ::testing::ThrowsMessage;

TEST(Arguments, OutOfRangeAreNamedWithWhatIsAllowed) {
  check_index("world", 0, 3);
  check_index("world", 2, 3);
  EXPECT_THAT([] { check_index("world", 3, 3); },
              ThrowsMessage<Error>("there is no world 3; allowed: 0 ... 2"));
  EXPECT_THAT([] { check_index("world", -1, 3); },
              ThrowsMessage<Error>("there is no world -1; allowed: 0 ... 2"));
  check_range("threads", 1, 1, 4, "");
  check_range("threads", 4, 1, 4, "");
  EXPECT_THAT([] { check_range("threads", 5, 1, 4, "take one"); },
              ThrowsMessage<Error>("threads is 5; allowed: 1 ... 4; take one"));
  check_physics_steps(0);
  EXPECT_THAT([] { check_physics_steps(-2); },
              ThrowsMessage<Error>("physics_steps is -2; it must be 0 or more"));
}

TEST(Arguments, IndicesAreThereOnce) {
  check_indices("world", std::vector<int>{2, 0, 1}, 3);
  EXPECT_THAT(
      [] {
        check_indices("world", std::vector<int>{2, 0, 2}, 3);
      },
      ThrowsMessage<Error>("world 2 is there twice"));
  EXPECT_THAT(
      [] {
        check_indices("world", std::vector<int>{2, 3}, 3);
      },
      ThrowsMessage<Error>("there is no world 3; allowed: 0 ... 2"));
}

TEST(Arguments, ValuesAreCountedByRows) {
  check_values("actions", 12, 3, 4);
  EXPECT_THAT([] { check_values("actions", 11, 3, 4); },
              ThrowsMessage<Error>("actions has 11 values; expected 3 x 4"));
  EXPECT_THAT([] { check_values("action", 3, 1, 4); },
              ThrowsMessage<Error>("action has 3 values; expected 4"));
}

}  // namespace
}  // namespace skybody
