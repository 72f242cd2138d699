#include "onboard/needs.h"

#include <cstring>
#include <functional>

#include "onboard/task_host.h"

namespace skybody::onboard {
namespace {

using Change = std::function<void(Situation&)>;
constexpr std::size_t kRows = 3;  // of a reset and of the two steps after it

/// kRows rows of observations, with a change of the situation at each.
std::vector<float> rows_of(const Mission& mission, TaskHost& task, const Change& change) {
  const auto width = static_cast<std::size_t>(mission.policy.observation_size);
  const std::vector<float> action(static_cast<std::size_t>(mission.policy.action_size), 0.1f);
  std::vector<float> rows(kRows * width);
  Situation situation(mission);
  change(situation);
  task.reset(situation);
  for (std::size_t k = 0; k < kRows; ++k) {
    situation.step = k;
    situation.physics_step = k * static_cast<std::uint64_t>(mission.setup.setup().action_repeat);
    task.observe(situation, action, std::span(rows).subspan(k * width, width));
  }
  return rows;
}

/// Indices of the columns in which two sets of rows differ.
std::vector<std::size_t> differing(const Mission& mission, const std::vector<float>& a,
                                   const std::vector<float>& b) {
  std::vector<std::size_t> found;
  const auto width = static_cast<std::size_t>(mission.policy.observation_size);
  for (std::size_t c = 0; c < mission.columns.size(); ++c) {
    const Column& column = mission.columns[c];
    bool differs = false;
    for (std::size_t row = 0; row < kRows; ++row) {
      const std::size_t at = row * width + static_cast<std::size_t>(column.first);
      differs |=
          std::memcmp(&a[at], &b[at], sizeof(float) * static_cast<std::size_t>(column.count)) != 0;
    }
    if (differs) found.push_back(c);
  }
  return found;
}

void shift(std::vector<double>& values) {
  for (std::size_t k = 0; k < values.size(); ++k) {
    values[k] += 0.3 + 0.01 * static_cast<double>(k % 7);
  }
}

Change body_change(int body) {
  return [body](Situation& s) {
    Motion m = s.body(body);
    m.position = m.position + Vec3<double>{0.31, -0.17, 0.23};
    m.rotation = {0.8, 0.36, -0.36, 0.3174901573277509};
    m.velocity = {0.4, -0.3, 0.2};
    m.angular_velocity = {-0.5, 0.7, 0.9};
    s.set_body(body, m);
  };
}

/// Everything that no packet gives.
Change unknown_change(const Mission& mission) {
  return [&mission](Situation& s) {
    shift(s.q);
    shift(s.u);
    shift(s.rotor_speed);
    for (const SkybodySensorInfo& sensor : mission.setup.sensors()) {
      if (is_of_imu(sensor)) continue;
      for (int k = 0; k < sensor.count; ++k)
        s.sensors[static_cast<std::size_t>(sensor.first + k)] += 0.3;
    }
  };
}

}  // namespace

Needs find_needs(const Mission& mission) {
  TaskHost task(mission);
  Needs needs;
  needs.bodies_of.resize(mission.columns.size());
  const std::vector<float> nominal = rows_of(mission, task, [](Situation&) {});
  const auto changed = [&](const Change& change) {
    return differing(mission, nominal, rows_of(mission, task, change));
  };
  for (int body = 0; body < static_cast<int>(mission.setup.bodies().size()); ++body) {
    if (body == mission.vehicle().first_body) continue;
    const auto columns = changed(body_change(body));
    if (!columns.empty()) needs.bodies.push_back(body);
    for (const std::size_t c : columns) needs.bodies_of[c].push_back(body);
  }
  for (const std::size_t c : changed(unknown_change(mission))) {
    needs.unknown.push_back(mission.columns[c].name);
  }
  const Imu imu{{0.5, -0.4, 9.0}, {0.3, -0.2, 0.1}};
  needs.imu = !changed([&](Situation& s) { s.set_imu(mission, imu); }).empty();
  return needs;
}

}  // namespace skybody::onboard
