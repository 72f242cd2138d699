// Outcome of an episode: failed, with the reason; succeeded; or open. Reasons are infos that are 0
// or 1, `failed.NAME` and `success`: `skybody run` and evaluations count them.
#pragma once

#include <skybody/plugin.h>

#include <string>

#include "plugins/task_kit/parts.h"

namespace skybody::task_kit {

/// Declares that episodes may end by the failure `name`. @param doc  its condition
inline Part declare_failure(const Setup& setup, InfoParts& infos, const std::string& name,
                            const std::string& doc) {
  return infos.add(setup, "failed." + name, "", doc);
}
/// Declares that episodes may succeed. @param doc  the condition
inline Part declare_success(const Setup& setup, InfoParts& infos, const std::string& doc) {
  return infos.add(setup, "success", "", doc);
}

/// Outcome of one evaluate(): failures first, then success, each reason once. A failed episode ends
/// when the verdict goes out of scope.
template <class Real>
class Verdict {
 public:
  explicit Verdict(Evaluation<Real>& out) : out_(out) {}
  SKYBODY_INLINE ~Verdict() { out_.terminate(failed_); }
  Verdict(const Verdict&) = delete;
  Verdict& operator=(const Verdict&) = delete;

  /// Ends the episode as a failure where `mask` holds.
  SKYBODY_INLINE void fail(const Part& reason, const MaskOf<Real>& mask) {
    note(reason, mask);
    failed_ = logical_or(failed_, mask);
  }
  /// Records success where `mask` holds and nothing has failed; the episode goes on.
  SKYBODY_INLINE void succeed(const Part& success, const MaskOf<Real>& mask) {
    note(success, logical_and(mask, logical_not(failed_)));
  }
  /// Records success and ends the episode there.
  SKYBODY_INLINE void finish(const Part& success, const MaskOf<Real>& mask) {
    succeed(success, mask);
    out_.terminate(mask);
  }
  /// Whether anything has failed so far, for a reward.
  MaskOf<Real> failed() const { return failed_; }

 private:
  SKYBODY_INLINE void note(const Part& reason, const MaskOf<Real>& mask) {
    if (out_.wants_info()) reason.set(out_.info, choose(mask, Real(1.0), Real(0.0)));
  }

  Evaluation<Real>& out_;
  MaskOf<Real> failed_{false};
};

}  // namespace skybody::task_kit
