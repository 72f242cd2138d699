// One line of the table of goals.
#pragma once

#include <cstdio>
#include <optional>
#include <string>
#include <vector>

#include "core/io/files/json.h"

namespace skybody::bench {

/// A measurement, the value that it is compared with, and the goal.
struct Figure {
  std::string what;     ///< "hover, K=1, 1024 environments"
  std::string actions;  ///< hold, zero, random; empty: none
  int threads = 0;      ///< 0: independent of threads
  std::string unit;     ///< of `ours` and `limit`
  double ours = 0.0;
  std::optional<double> limit;  ///< the compared value
  std::string against;          ///< description of `limit`
  double ratio = 0.0;           ///< as the goal defines it
  std::string sense;            ///< ">=" or "<=" the goal; empty: no goal, for information
  double goal = 0.0;
  std::optional<double> near_share =
      std::nullopt;  ///< share of our physics steps with bodies near contact

  bool meets() const { return sense.empty() || (sense == ">=" ? ratio >= goal : ratio <= goal); }
  std::string json() const;
};

inline std::string Figure::json() const {
  const auto number = [](double x) {
    char text[32];
    std::snprintf(text, sizeof(text), "%.6g", x);
    return std::string(text);
  };
  JsonObject out;
  out.set_text("what", what).set_text("actions", actions).set("threads", std::to_string(threads));
  out.set_text("unit", unit).set("ours", number(ours));
  out.set("limit", limit ? number(*limit) : "null").set_text("against", against);
  out.set("ratio", number(ratio)).set_text("sense", sense).set("goal", number(goal));
  out.set("near_share", near_share ? number(*near_share) : "null");
  return out.text();
}

}  // namespace skybody::bench
