#include "core/env/state_values.h"

#include <algorithm>
#include <numeric>
#include <set>

#include "core/base/system/error.h"
#include "core/base/system/suggestion.h"
#include "core/env/compiled_scenario.h"
#include "core/env/state_value_list.h"

namespace skybody {
namespace {

/// `count` of the 13 values of one body's motion.
void read_motion(const StateGroup& group, int lane, int body, int part, int count, double* out) {
  const int lanes = group.lanes();
  const double* values = group.bodies() + (13 * body + part) * lanes + lane;
  for (int k = 0; k < count; ++k) out[k] = values[k * lanes];
}

/// Motion of a frame fixed to a body. Angular velocity is in the axes of that frame.
BodyState motion_of_link(const BodyState& body, const Pose& pose) {
  const Vec3<double> arm = rotate(body.rotation, pose.position);
  BodyState link;
  link.position = body.position + arm;
  link.rotation = body.rotation * pose.rotation;
  link.velocity = body.velocity + cross(rotate(body.rotation, body.angular_velocity), arm);
  link.angular_velocity = rotate(conjugate(pose.rotation), body.angular_velocity);
  return link;
}

/// The word of a path that begins at an index; empty at or beyond its end.
std::string word_at(const std::string& path, std::size_t from) {
  if (from >= path.size()) return "";
  return path.substr(from, path.find('.', from) - from);
}

}  // namespace

StateValues::StateValues(const CompiledScenario& compiled)
    : dt_(compiled.scenario().stepping.dt), values_(list_state_values(compiled)) {
  std::set<std::string> known;
  std::erase_if(values_, [&](const StateValue& value) { return !known.insert(value.path).second; });
  for (std::size_t i = 0; i < values_.size(); ++i) {
    by_path_.emplace(values_[i].path, static_cast<int>(i));
  }
  for (std::size_t i = 0; i < values_.size(); ++i) {
    if (!values_[i].alias.empty()) by_path_.emplace(values_[i].alias, static_cast<int>(i));
  }
}

const StateValue& StateValues::at(std::string_view path) const {
  const auto found = by_path_.find(path);
  if (found == by_path_.end()) refuse(path);
  return values_[static_cast<std::size_t>(found->second)];
}

/// Whether some path begins with a prefix.
bool StateValues::has_prefix(const std::string& prefix) const {
  return std::any_of(values_.begin(), values_.end(), [&](const StateValue& value) {
    return value.path.starts_with(prefix) || value.alias.starts_with(prefix);
  });
}

/// The words that may follow a prefix, which is empty or ends in a dot.
std::vector<std::string> StateValues::words_after(const std::string& prefix) const {
  std::vector<std::string> words;
  std::set<std::string> known;
  for (const StateValue& value : values_) {
    for (const std::string* path : {&value.path, &value.alias}) {
      if (path->empty() || !path->starts_with(prefix)) continue;
      std::string word = word_at(*path, prefix.size());
      if (known.insert(word).second) words.push_back(std::move(word));
    }
  }
  return words;
}

/// Throws an Error that lists the existing words in place of the first unknown one.
void StateValues::refuse(std::string_view path) const {
  const std::string whole(path);
  std::string known, word = word_at(whole, 0);
  while (!word.empty() && has_prefix(known + word + ".")) {
    known += word + ".";
    word = word_at(whole, known.size());
  }
  const std::vector<std::string> words = words_after(known);
  std::string message = "no value of the state is called `" + whole + "`";
  const std::string nearest = word.empty() ? "" : closest(word, words);
  if (nearest.empty()) {
    message += "; ";
  } else {
    const std::string mended = known + nearest + whole.substr(known.size() + word.size());
    message += "; did you mean `" + (has_prefix(mended) ? mended : known + nearest) + "`? ";
  }
  const std::string group =
      known.empty() ? "the state" : "`" + known.substr(0, known.size() - 1) + "`";
  throw Error(message + group + " has " + join_first(words) +
              " (`skybody check --states FILE` lists all)");
}

void StateValues::read(const StateValue& value, const StateGroup& group, int lane,
                       double* out) const {
  switch (value.source) {
    case StateSource::kReals:
      group.gather(lane, {value.first, value.count()}, out);
      return;
    case StateSource::kHeader:
      *out = static_cast<double>(group.bits(value.first)[lane]);
      return;
    case StateSource::kTime:
      *out = static_cast<double>(group.bits(value.first)[lane]) * dt_;
      return;
    case StateSource::kBodies: {
      const int width = value.shape.back();
      const int bodies = value.count() / width;
      for (int b = 0; b < bodies; ++b) {
        read_motion(group, lane, value.first + b, value.part, width, out + b * width);
      }
      return;
    }
    case StateSource::kLink: {
      BodyState body;
      read_motion(group, lane, value.first, 0, 13, reinterpret_cast<double*>(&body));
      const BodyState link = motion_of_link(body, value.pose);
      std::copy_n(reinterpret_cast<const double*>(&link) + value.part, value.count(), out);
      return;
    }
  }
}

}  // namespace skybody
