// Definitions for setup.h.
#pragma once

#include <iterator>
#include <limits>
#include <string>
#include <vector>

#include "core/plugin_abi/path_pattern.h"
#include "plugins/api/setup.h"

namespace skybody {

inline int Setup::robot() const {
  if (raw_.team_size == 0) throw std::logic_error("only a controller serves one robot");
  if (raw_.team_size > 1) {
    refuse("controller `", raw_.instance, "` serves one robot, and is given a team of ",
           raw_.team_size, ": move it to the `controllers` of a robot");
  }
  return raw_.team[0];
}

inline int Setup::robot(const std::string& name) const {
  std::string known;
  for (int i = 0; i < raw_.robot_count; ++i) {
    if (name.empty() && raw_.robot_count == 1) return i;
    if (name == raw_.robots[i].name) return i;
    known += (i > 0 ? ", " : "") + std::string(raw_.robots[i].name);
  }
  if (name.empty()) refuse("several robots: name one of ", known);
  refuse("no robot `", name, "`: there are ", known);
}

inline View<RotorInfo> Setup::rotors_of(int robot) const {
  const RobotInfo& r = raw_.robots[robot];
  return {raw_.rotors + r.first_rotor, r.rotor_count};
}

inline const LinkInfo& Setup::link(int robot, const std::string& name) const {
  std::string known;
  for (const LinkInfo& l : links()) {
    if (l.robot != robot) continue;
    if (name == l.name) return l;
    known += (known.empty() ? "" : ", ") + std::string(l.name);
  }
  refuse("robot `", raw_.robots[robot].name, "` has no link `", name, "`: there are ", known);
}

inline const BodyInfo& Setup::joint(int robot, const std::string& name) const {
  std::string known;
  for (const BodyInfo& b : bodies()) {
    if (b.robot != robot || b.joint == SKYBODY_WELD || b.joint == SKYBODY_FREE) continue;
    if (name == b.joint_name) return b;
    known += (known.empty() ? "" : ", ") + std::string(b.joint_name);
  }
  refuse("robot `", raw_.robots[robot].name, "` has no joint `", name, "`: there are ",
         (known.empty() ? "none" : known));
}

inline int Setup::sensor(const std::string& instance, const std::string& channel,
                         int* count) const {
  std::string known;
  for (int i = 0; i < raw_.sensor_count; ++i) {
    const SkybodySensorInfo& s = raw_.sensors[i];
    if (instance == s.name && channel == s.channel) {
      if (count != nullptr) *count = s.count;
      declare_.reads(declare_.host, s.first);
      return s.first;
    }
    known += (i > 0 ? ", " : "") + std::string(s.name) + "." + s.channel;
  }
  refuse("no sensor output `", instance, ".", channel, "`: there are ",
         (known.empty() ? "none" : known));
}

inline std::vector<int> Setup::find_params(const std::string& path) const {
  std::vector<std::string> robots;
  for (int r = 0; r < raw_.robot_count; ++r) robots.emplace_back(raw_.robots[r].name);
  const std::vector<std::string> patterns = plugin_detail::patterns_of(path, robots);
  std::vector<int> found;
  for (int i = 0; i < raw_.param_count; ++i) {
    const SkybodyEnvParamInfo& param = raw_.params[i];
    if (plugin_detail::any_matches(patterns, param.path, param.alias)) found.push_back(i);
  }
  if (found.empty()) {
    refuse("nothing randomizable is called `", path, "`", plugin_detail::kNoSuchParam);
  }
  return found;
}

inline void Setup::input(Signal signal, const std::vector<double>& low,
                         const std::vector<double>& high) const {
  if (low.size() != high.size()) throw std::logic_error("input(): low and high differ in size");
  declare_.input(declare_.host, static_cast<int>(signal), static_cast<int>(low.size()), low.data(),
                 high.data());
}

inline void Setup::input(Signal signal, int count) const {
  declare_.input(declare_.host, static_cast<int>(signal), count, nullptr, nullptr);
}

inline void Setup::output(Signal signal, int count, int robot) const {
  if (robot < 0 && raw_.team_size > 0) robot = raw_.team[0];
  declare_.output(declare_.host, robot, static_cast<int>(signal), count);
}

inline void Setup::channel(const std::string& name, const std::string& unit, int count, double low,
                           double high, int robot, const std::string& doc) const {
  const SkybodyChannel channel{name.c_str(), unit.c_str(), count, low, high, robot, 0, 0, 0,
                               {},           doc.c_str()};
  declare_.channel(declare_.host, &channel);
}

inline void Setup::privileged_channel(const std::string& name, const std::string& unit, int count,
                                      double low, double high, int robot,
                                      const std::string& doc) const {
  const SkybodyChannel channel{name.c_str(), unit.c_str(), count, low, high, robot, 1, 0, 0,
                               {},           doc.c_str()};
  declare_.channel(declare_.host, &channel);
}

inline const Triangles& Setup::visual_triangles(int visual) const {
  const Triangles& found = *raw_.visual_triangles(raw_.tables, visual);
  if (*found.problem == '\0') return found;
  const ShapeInfo& shape = raw_.visuals[visual].shape;
  refuse("the mesh `", shape.mesh, "` of the body `", shape.name, "` ", found.problem,
         ": mend or simplify the file, or draw the body as boxes, cylinders, spheres or capsules");
}

inline const Triangles& Setup::obstacle_triangles(int obstacle) const {
  const Triangles& found = *raw_.obstacle_triangles(raw_.tables, obstacle);
  if (*found.problem == '\0') return found;
  std::string name;
  for (const ShapeInfo& shape : shapes()) {
    if (shape.obstacle == obstacle) name = shape.name;
  }
  refuse("the height field of the obstacle `", name, "` ", found.problem, ": use a coarser one");
}

inline const PictureInfo& Setup::picture(const std::string& file) const {
  const PictureInfo& found = *raw_.picture(raw_.tables, file.c_str());
  if (*found.problem == '\0') return found;
  refuse("the picture `", file, "` ", found.problem,
         ": name a whole PNG or JPEG file, or leave the texture out");
}

template <class T>
Image<T> Setup::image(const std::string& name, const std::vector<int>& shape, int robot, double low,
                      double high) const {
  SkybodyChannel channel{name.c_str(), "", 1, low, high, robot, 0, 0, 0, {}, ""};
  if (shape.empty() || shape.size() > std::size(channel.shape)) {
    throw std::logic_error("image(): `" + name + "` needs one to three extents");
  }
  channel.type = plugin_detail::column_type<T>();
  for (const int extent : shape) {
    channel.shape[channel.rank++] = extent;
    channel.count = plugin_detail::product(channel.count, extent);
  }
  declare_.channel(declare_.host, &channel);
  const std::size_t offset = image_bytes_;
  image_bytes_ += plugin_detail::image_room(static_cast<std::size_t>(channel.count) * sizeof(T));
  return {offset, channel.count};
}

inline void Setup::info(const std::string& name, const std::string& unit, int count,
                        const std::string& doc) const {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  const SkybodyChannel channel{name.c_str(), unit.c_str(), count, -infinity, infinity, -1, 0, 0, 0,
                               {},           doc.c_str()};
  declare_.info(declare_.host, &channel);
}

inline void Setup::report(const std::string& name, const std::string& unit, int count,
                          int first) const {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  const SkybodyChannel channel{
      name.c_str(), unit.c_str(), count, -infinity, infinity, -1, 0, 0, 0, {}, ""};
  declare_.report(declare_.host, &channel, first);
}

inline void Setup::action(const std::string& name, const std::string& unit, int count, double low,
                          double high, int robot) const {
  const SkybodyChannel channel{
      name.c_str(), unit.c_str(), count, low, high, robot, 0, 0, 0, {}, ""};
  declare_.action(declare_.host, &channel);
}

}  // namespace skybody
