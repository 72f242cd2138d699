#include "core/batch/episode_flags.h"

#include <cstring>

namespace skybody {
namespace {

std::size_t place_of(int env) { return static_cast<std::size_t>(env); }

/// EpisodeFlags::describe() for eight lanes whose episodes all continue. Otherwise returns false
/// and writes nothing.
bool describe_running(int first, const std::uint64_t* steps, bool is_reset, Batch& rows) {
  const std::size_t at = place_of(first);
  std::uint64_t ended = 0;
  for (std::size_t l = 0; l < kOctet; ++l) ended |= rows.status[at + l] ^ kRunning;
  if (ended != 0) return false;
  for (Column<std::uint8_t>* flags : {&rows.terminated, &rows.truncated, &rows.fault}) {
    std::memset(flags->data() + at, 0, kOctet);
  }
  std::memset(rows.was_reset.data() + at, is_reset ? 1 : 0, kOctet);
  for (std::size_t l = 0; l < kOctet; ++l) {
    rows.episode_step[at + l] = static_cast<std::int32_t>(steps[l]);
  }
  return true;
}

}  // namespace

bool EpisodeFlags::can_step_all(bool renews) const {
  std::uint32_t missing = 0;
  for (int group = 0; group < places_.count(); ++group) {
    missing |= places_.all_lanes(group) & ~started_.of(group);
    if (!renews) missing |= ended_.of(group);
  }
  return missing == 0;
}

void EpisodeFlags::clear() {
  started_.clear();
  ended_.clear();
}

void EpisodeFlags::refresh(int env, const StateGroup& group) {
  const int lane = places_.lane_of(env);
  started_.set(places_.group_of(env), places_.bit(env), group.bits(kEpisode)[lane] > 0);
  set_ended(env, group.bits(kStatus)[lane] != kRunning);
}

void EpisodeFlags::describe(int group, std::uint32_t mask, const std::uint64_t* steps,
                            bool is_reset, Batch& rows) {
  const int first_env = places_.env_of(group, 0);
  std::uint32_t over = 0;
  std::uint32_t running = places_.span == 1 ? 0u : whole_octets(mask);
  each_octet(running, [&](int first) {
    if (!describe_running(first_env + first, steps + first, is_reset, rows)) {
      running &= ~(0xffu << first);
    }
  });
  each_lane(mask & ~running, [&](int l) {
    const std::size_t env = place_of(first_env + l);
    const std::uint64_t status = rows.status[env];
    rows.terminated[env] = (status & kTerminated) != 0;
    rows.truncated[env] = (status & kTruncated) != 0;
    rows.fault[env] = (status & kFault) != 0;
    rows.was_reset[env] = is_reset;
    rows.episode_step[env] = static_cast<std::int32_t>(steps[l]);
    if (status != kRunning) over |= 1u << l;
  });
  started_.set(group, mask, true);
  ended_.set(group, mask & ~over, false);
  ended_.set(group, over, true);
}

}  // namespace skybody
