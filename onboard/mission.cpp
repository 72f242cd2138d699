#include "onboard/mission.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <map>
#include <sstream>

#include "core/base/constants.h"
#include "core/base/math/hash.h"

namespace skybody::onboard {
namespace {

constexpr std::uint64_t kMagic = 0x4e4f495353494d53u;  // "SMISSION"
constexpr std::uint32_t kVersion = 1;

std::uint64_t checksum_of(std::string_view bytes) { return hash_bytes(bytes.data(), bytes.size()); }

template <class Archive>
void visit(Archive& a, ConvShape& s) {
  a(s.height, s.width, s.channels, s.outputs, s.kernel_height, s.kernel_width, s.stride, s.same);
}

template <class Archive>
void visit(Archive& a, PolicyLayer& layer) {
  a(layer.inputs, layer.outputs, layer.weight, layer.bias, layer.activation, layer.kind,
    layer.state_weight, layer.state_bias);
  visit(a, layer.conv);
}

/// Images are left out: a mission has none.
template <class Archive>
void visit(Archive& a, PolicyFile& p) {
  a(p.scenario, p.scenario_hash, p.algorithm, p.steps, p.observation_size, p.action_size, p.squash,
    p.mean, p.scale, p.clip);
  a.size(p.agents, 8);
  for (PolicyAgent& agent : p.agents) a(agent.observation, agent.action);
  a.size(p.layers, 8);
  for (PolicyLayer& layer : p.layers) visit(a, layer);
}

void require(bool holds, const char* problem) {
  if (!holds) throw Error(problem);
}

/// Whether rows [first, first + count) are inside of a table.
bool fits(std::int64_t first, std::int64_t count, std::size_t size) {
  return first >= 0 && count >= 0 && first + count <= static_cast<std::int64_t>(size);
}

void check_layers(const PolicyFile& policy) {
  require(!policy.layers.empty() && policy.layers.size() <= kMostLayers, "it has no layers");
  int inputs = policy.input_size();
  for (const PolicyLayer& layer : policy.layers) {
    require(layer.inputs == inputs && layer.outputs > 0 && layer.kind != LayerKind::kConv,
            "its layers do not fit one another");
    const auto rows = static_cast<std::size_t>(layer.weight_rows());
    require(
        layer.weight.size() == rows * static_cast<std::size_t>(inputs) && layer.bias.size() == rows,
        "a layer has the wrong number of weights");
    const std::size_t state = layer.is_recurrent() ? rows : 0;
    require(layer.state_weight.size() == state * static_cast<std::size_t>(layer.outputs) &&
                layer.state_bias.size() == state,
            "a layer has the wrong number of weights");
    inputs = layer.outputs;
  }
  require(inputs == policy.output_size(), "its layers do not fit the action");
  const auto count = policy.mean.size();
  require(policy.scale.size() == count &&
              (count == 0 || count == static_cast<std::size_t>(policy.input_size())),
          "its normalization does not fit the observation");
}

void check_agents(const Mission& m) {
  const PolicyFile& p = m.policy;
  const auto within = [](const std::vector<int>& places, int size) {
    return std::all_of(places.begin(), places.end(), [&](int k) { return k >= 0 && k < size; });
  };
  for (const PolicyAgent& agent : p.agents) {
    require(within(agent.observation, p.observation_size) && within(agent.action, p.action_size) &&
                agent.observation.size() == p.agents[0].observation.size() &&
                agent.action.size() == p.agents[0].action.size(),
            "an agent's entries do not fit the rows");
  }
  require(fits(m.agent, 1, std::max<std::size_t>(1, p.agents.size())), "there is no such agent");
}

/// Checks all places that this library uses. Those that the task uses are checked at each access.
void check(const Mission& m) {
  const PolicyFile& p = m.policy;
  require(p.observation_size > 0 && p.observation_size < 1 << 20 && p.action_size > 0 &&
              p.action_size < 1 << 16,
          "it has no observation or no action");
  check_agents(m);
  check_layers(p);
  require(fits(m.robot, 1, m.setup.robots().size()), "there is no such robot");
  require(m.period() > 0.0 && m.period() < 1e3 && m.setup.setup().action_repeat > 0,
          "its period is not positive");
  for (const SkybodyRobotInfo& r : m.setup.robots()) {
    require(fits(r.first_body, r.body_count, m.setup.bodies().size()) && r.body_count > 0 &&
                fits(r.first_rotor, r.rotor_count, m.setup.rotors().size()) &&
                fits(r.first_q, r.q_count, 1 << 16) && fits(r.first_u, r.u_count, 1 << 16),
            "a robot's places do not fit the tables");
  }
  for (const SkybodySensorInfo& s : m.setup.sensors()) {
    require(fits(s.first, s.count, 1 << 20), "a sensor's places do not fit");
  }
  for (const SkybodyChainInfo& c : m.setup.chains()) {
    require(
        fits(c.first_command, c.count, 1 << 16) && c.signal >= 0 && c.signal < SKYBODY_SIGNAL_COUNT,
        "a chain's places do not fit");
  }
  for (const ActionRange& range : m.actions) {
    require(range.low.size() == range.high.size() &&
                fits(range.first, static_cast<std::int64_t>(range.low.size()),
                     static_cast<std::size_t>(p.action_size)),
            "a range does not fit the action");
  }
  m.chain();
}

}  // namespace

void set_limit(Limits& limits, const std::string& name, const std::vector<double>& values) {
  const std::map<std::string, double*> numbers = {{"stale", &limits.stale},
                                                  {"lateness", &limits.lateness},
                                                  {"tilt", &limits.tilt},
                                                  {"safe_thrust", &limits.safe_thrust},
                                                  {"safe_time", &limits.safe_time}};
  const auto number = numbers.find(name);
  if (number != numbers.end() && values.size() == 1) {
    if (!(values[0] >= 0.0)) throw Error("--limit " + name + ": allowed: 0 and above");
    *number->second = values[0];
  } else if (name == "safe" && values.size() == 1) {
    limits.safe = values[0] == 0.0 ? SafeAction::kStop : SafeAction::kDescend;
  } else if (name == "fence" && values.size() == 6) {
    for (std::size_t k = 0; k < 3; ++k) {
      if (!(values[k] < values[k + 3])) {
        throw Error("--limit fence: allowed: least x, y, z, then greatest x, y, z");
      }
    }
    std::copy_n(values.begin(), 3, limits.fence_low.begin());
    std::copy_n(values.begin() + 3, 3, limits.fence_high.begin());
  } else {
    throw Error("--limit: `" + name + "` with " + std::to_string(values.size()) +
                " values; allowed: stale, lateness, tilt, safe, safe_thrust, safe_time with one, "
                "fence with six");
  }
}

template <class Archive>
void Mission::visit(Archive& a) {
  a(scenario, scenario_hash, task, task_version, robot, agent, seed, setup, columns, parts,
    is_task_in_place, actions);
  onboard::visit(a, policy);
  a(limits);
}

const SkybodyChainInfo& Mission::chain() const {
  for (const SkybodyChainInfo& chain : setup.chains()) {
    if (chain.robot == robot && chain.count > 0) return chain;
  }
  throw Error("its robot takes no command");
}

double Mission::mass() const {
  double sum = 0.0;
  for (int k = 0; k < vehicle().body_count; ++k) {
    sum += setup.bodies()[static_cast<std::size_t>(vehicle().first_body + k)].mass;
  }
  return sum;
}

double Mission::gravity() const {
  const double* g = setup.setup().gravity;
  return std::sqrt(g[0] * g[0] + g[1] * g[1] + g[2] * g[2]);
}

double Mission::largest_thrust(int k) const {
  const double* c = setup.rotors()[static_cast<std::size_t>(vehicle().first_rotor + k)].constants;
  return c[SKYBODY_ROTOR_THRUST_CONSTANT] * c[SKYBODY_ROTOR_MAX_SPEED] * c[SKYBODY_ROTOR_MAX_SPEED];
}

double Mission::largest_thrust() const {
  double sum = 0.0;
  for (int k = 0; k < vehicle().rotor_count; ++k) sum += largest_thrust(k);
  return sum;
}

std::string to_bytes(Mission& mission) {
  Writer content, head;
  content(mission);
  head.raw(kMagic);
  head.raw(kVersion);
  head.raw(std::uint32_t{0});
  head.raw(SetupCopy::layout());
  head.raw(checksum_of(content.bytes()));
  return head.bytes() + content.bytes();
}

Mission from_bytes(std::string_view bytes) {
  std::uint64_t magic = 0, layout = 0, checksum = 0;
  std::uint32_t version = 0, unused = 0;
  Reader head(bytes);
  if (bytes.size() < 32) throw Error("it is no mission");
  head.raw(magic);
  head.raw(version);
  head.raw(unused);
  head.raw(layout);
  head.raw(checksum);
  if (magic != kMagic) throw Error("it is no mission");
  if (version != kVersion || layout != SetupCopy::layout()) {
    throw Error("it is a mission of another version: write it again by `skybody export`");
  }
  const std::string_view content = bytes.substr(32);
  if (checksum_of(content) != checksum) throw Error("it is damaged: its checksum is wrong");
  Mission mission;
  Reader reader(content);
  reader(mission);
  if (!reader.is_at_end()) throw Error("it has bytes after its end");
  mission.setup.link();
  check(mission);
  return mission;
}

std::string read_file(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  std::ostringstream content;
  if (in) content << in.rdbuf();
  if (!in || !content) throw Error(file.string() + ": cannot be read; give a file that exists");
  return content.str();
}

Mission read_mission(const std::filesystem::path& file) {
  try {
    return from_bytes(read_file(file));
  } catch (const Error& error) {
    const std::string problem = error.what();
    if (problem.starts_with(file.string())) throw;
    throw Error(file.string() + ": " + problem);
  }
}

std::vector<std::vector<double>> read_gates(const std::filesystem::path& file,
                                            const Mission& mission) {
  std::array<double, 3> size{1.4, 1.4, 0.1};
  for (const SkybodyShapeInfo& s : mission.setup.shapes()) {
    if (s.kind == SKYBODY_GATE) std::copy_n(s.size, 3, size.begin());
  }
  std::istringstream in(read_file(file));
  std::vector<std::vector<double>> gates;
  std::string line;
  for (int number = 1; std::getline(in, line); ++number) {
    if (line.empty() || line[0] == '#') continue;
    std::istringstream words(line);
    std::vector<double> v;
    for (double value = 0.0; words >> value;) v.push_back(value);
    const bool is_finite =
        std::all_of(v.begin(), v.end(), [](double x) { return std::isfinite(x); });
    if (!words.eof() || !is_finite || (v.size() != 4 && v.size() != 6)) {
      throw Error(file.string() + ":" + std::to_string(number) +
                  ": is no gate; allowed: x y z yaw [width height]");
    }
    if (v.size() == 4) v.insert(v.end(), {size[0], size[1]});
    gates.push_back({v[0], v[1], v[2], std::cos(0.5 * v[3]), 0.0, 0.0, std::sin(0.5 * v[3]), v[4],
                     v[5], size[2]});
  }
  if (gates.empty()) throw Error(file.string() + ": has no gates");
  return gates;
}

}  // namespace skybody::onboard
