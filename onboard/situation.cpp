#include "onboard/situation.h"

#include <algorithm>
#include <cmath>
#include <string_view>

namespace skybody::onboard {
namespace {

bool finite(const Vec3<double>& v) {
  return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

void put(double* to, const Vec3<double>& v) {
  to[0] = v.x;
  to[1] = v.y;
  to[2] = v.z;
}

}  // namespace

bool Motion::is_valid() const {
  const double length = rotation.w * rotation.w + rotation.x * rotation.x +
                        rotation.y * rotation.y + rotation.z * rotation.z;
  return finite(position) && finite(velocity) && finite(angular_velocity) &&
         std::abs(length - 1.0) < 0.01;  // also false for NaN
}

double Motion::tilt() const {
  const double up = 1.0 - 2.0 * (rotation.x * rotation.x + rotation.y * rotation.y);
  return std::acos(std::clamp(up, -1.0, 1.0));
}

Situation::Situation(const Mission& mission) {
  const SetupCopy& setup = mission.setup;
  std::size_t q_size = 0, u_size = 0, sensor_size = 0;
  bodies.resize(setup.bodies().size() * kBodyValues);
  for (const SkybodyRobotInfo& r : setup.robots()) {
    q_size = std::max(q_size, static_cast<std::size_t>(r.first_q + r.q_count));
    u_size = std::max(u_size, static_cast<std::size_t>(r.first_u + r.u_count));
    for (int k = 0; k < r.body_count; ++k) {
      Motion motion;
      motion.position = {r.position[0], r.position[1], r.position[2]};
      motion.rotation = {r.rotation[0], r.rotation[1], r.rotation[2], r.rotation[3]};
      set_body(r.first_body + k, motion);
    }
  }
  for (const SkybodySensorInfo& s : setup.sensors()) {
    sensor_size = std::max(sensor_size, static_cast<std::size_t>(s.first + s.count));
  }
  q.resize(q_size);
  u.resize(u_size);
  rotor_speed.resize(setup.rotors().size());
  sensors.resize(sensor_size);
  for (const SkybodyEnvParamInfo& p : setup.params()) params.push_back(p.nominal);
}

void Situation::set_body(int body, const Motion& m) {
  double* to = bodies.data() + static_cast<std::ptrdiff_t>(body) * kBodyValues;
  put(to, m.position);
  to[3] = m.rotation.w;
  put(to + 4, {m.rotation.x, m.rotation.y, m.rotation.z});
  put(to + 7, m.velocity);
  put(to + 10, m.angular_velocity);
}

Motion Situation::body(int body) const {
  const double* v = bodies.data() + static_cast<std::ptrdiff_t>(body) * kBodyValues;
  return {{v[0], v[1], v[2]}, {v[3], v[4], v[5], v[6]}, {v[7], v[8], v[9]}, {v[10], v[11], v[12]}};
}

bool is_of_imu(const SkybodySensorInfo& sensor) {
  const std::string_view channel = sensor.channel;
  return sensor.count == 3 && (channel == "specific_force" || channel == "angular_rate");
}

void Situation::set_imu(const Mission& mission, const Imu& imu) {
  for (const SkybodySensorInfo& s : mission.setup.sensors()) {
    if (!is_of_imu(s)) continue;
    const bool is_force = std::string_view(s.channel) == "specific_force";
    put(sensors.data() + s.first, is_force ? imu.specific_force : imu.angular_velocity);
  }
}

bool Situation::set_param(const Mission& mission, std::string_view path,
                          std::span<const double> values) {
  const auto& infos = mission.setup.params();
  const std::string first = std::string(path) + "[0]";
  for (std::size_t k = 0; k < infos.size(); ++k) {
    if (path != infos[k].path && path != infos[k].alias && first != infos[k].path) continue;
    if (k + values.size() > infos.size()) return false;
    for (std::size_t i = 0; i < values.size(); ++i) {
      params[k + i] = std::clamp(values[i], infos[k + i].min, infos[k + i].max);
    }
    return true;
  }
  return false;
}

}  // namespace skybody::onboard
