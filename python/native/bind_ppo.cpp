// The learners: a `Ppo` with its own slices or with slices held by Python, and `PpoSlices`, the
// slices of a worker.
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <memory>
#include <string>
#include <utility>

#include "learn/make_learner.h"
#include "learn/position_error.h"
#include "learn/ppo/ppo.h"
#include "learn/ppo/ppo_slices.h"
#include "learn/ppo/recovering_ppo.h"
#include "python/native/arrays.h"
#include "python/native/bindings.h"
#include "python/native/learner_options.h"
#include "python/native/remote_slices.h"

namespace skybody::python {
namespace {

using learn::LearnerState;

/// Some slices with their own networks, which receive parameters before each computation.
class HeldSlices {
 public:
  HeldSlices(const learn::LearnerOptions& options, int first, int count)
      : setup_(std::make_shared<const learn::PpoSetup>(options)),
        threads_(options.threads, learn::kSlices),
        networks_(setup_->agents, setup_->images, setup_->hyper, setup_->isa),
        slices_(setup_, first, count, threads_) {}

  nb::list collect(nb::handle policy, nb::handle value, std::int64_t iteration, nb::handle mean,
                   nb::handle scale, double return_mean) {
    set_parameters(policy, value);
    const Values<double> means = read_array<double>(mean, "mean", {setup_->row.inputs});
    const Values<double> scales = read_array<double>(scale, "scale", {setup_->row.inputs});
    inputs_ = {iteration,
               {means.span().begin(), means.span().end()},
               {scales.span().begin(), scales.span().end()},
               return_mean};
    released([&] { slices_.collect(inputs_, networks_); });
    return each([](const learn::SliceOutputs& of) {
      return nb::make_tuple(array_of(of.rollout_sums), array_of(of.episode_returns));
    });
  }

  nb::list find_advantages(double reward_scale) {
    released([&] { slices_.find_advantages(reward_scale, networks_); });
    return each([](const learn::SliceOutputs& of) { return array_of(of.advantage_sums); });
  }

  nb::list find_gradients(nb::handle policy, nb::handle value, int epoch, int index,
                          bool wants_policy, bool wants_value, double mean, double scale) {
    set_parameters(policy, value);
    const learn::Minibatch minibatch{epoch, index, wants_policy, wants_value, mean, scale};
    released([&] { slices_.find_gradients(minibatch, networks_); });
    return each([&](const learn::SliceOutputs& of) {
      const auto wanted = [](bool is_wanted, std::span<const float> gradient) {
        return array_of(is_wanted ? gradient : gradient.first(0));
      };
      return nb::make_tuple(array_of(of.minibatch_sums), wanted(wants_policy, of.policy_gradient),
                            wanted(wants_value, of.value_gradient));
    });
  }

  nb::list rollout() const {
    nb::list made;
    for (int k = 0; k < slices_.count(); ++k) made.append(dict_of(slices_.slice(k).rollout()));
    return made;
  }

  void stagger_resets(std::int64_t iteration) {
    released([&] { slices_.stagger_resets(iteration); });
  }

  nb::list save() const {
    nb::list states;
    for (int k = 0; k < slices_.count(); ++k) {
      learn::StateBlocks blocks;
      const std::vector<std::uint64_t> words = slices_.save(k, blocks);
      states.append(state_of(blocks, words));
    }
    return states;
  }

  void restore(const nb::list& states) {
    for (int k = 0; k < slices_.count(); ++k) {
      learn::StateBlocks blocks;
      const std::vector<std::uint64_t> words =
          read_state(states[static_cast<std::size_t>(k)], blocks);
      slices_.restore(k, blocks, words);
    }
  }

 private:
  nb::dict dict_of(const learn::PpoSlice::LastRollout& rollout) const {
    const learn::RowLayout& row = setup_->row;
    nb::dict columns;
    columns["inputs"] = columns_of(rollout, 0, row.inputs);
    columns["action"] = columns_of(rollout, row.action(), row.actions);
    columns["log_probability"] = columns_of(rollout, row.log_probability(), 1);
    columns["advantage"] = columns_of(rollout, row.advantage(), 1);
    columns["value_target"] = columns_of(rollout, row.value_target(), 1);
    columns["order"] = array_of(rollout.order);
    return columns;
  }

  /// `count` values of each row, (rows, count).
  nb::object columns_of(const learn::PpoSlice::LastRollout& rollout, int first, int count) const {
    const std::size_t rows = rollout.reward.size(), width = static_cast<std::size_t>(count);
    const auto stride = static_cast<std::size_t>(setup_->row.stride());
    std::vector<float> values;
    for (std::size_t r = 0; r < rows; ++r) {
      const float* from = rollout.rows.data() + r * stride + first;
      values.insert(values.end(), from, from + count);
    }
    return copy_of<float>(values, {rows, width});
  }

  void set_parameters(nb::handle policy, nb::handle value) {
    const Values<float> policies = read_array<float>(policy, "policy", {-1});
    const Values<float> values = read_array<float>(value, "value", {-1});
    networks_.set(policies.span(), values.span());
  }

  template <class Work>
  static void released(Work&& work) {
    const nb::gil_scoped_release release;
    work();
  }

  template <class Make>
  nb::list each(Make&& make) const {
    nb::list made;
    for (int k = 0; k < slices_.count(); ++k) made.append(make(slices_.outputs(k)));
    return made;
  }

  std::shared_ptr<const learn::PpoSetup> setup_;
  learn::LearnerThreads threads_;
  learn::PpoNetworks networks_;
  learn::PpoSlices slices_;
  learn::RolloutInputs inputs_;
};

struct AnyLearner {
  std::unique_ptr<learn::Learner> learner;
};
struct AnyPpo : AnyLearner {};
struct AnyGradient : AnyLearner {};

/// Makes the learner, with its own slices or with slices held by Python.
std::unique_ptr<learn::Learner> make_ppo(const LoadedScenario& scenario,
                                         const learn::LearnerOptions& options,
                                         const nb::object& slices) {
  if (slices.is_none()) {
    return make_learner(learn::Algorithm::kFastPpo, scenario.options(), options);
  }
  auto setup = std::make_shared<const learn::PpoSetup>(options);
  auto holder = std::make_unique<RemoteSlices>(slices, setup->plan.slices());
  const auto replace = [slices] {
    const nb::gil_scoped_acquire gil;
    calling([&] { slices.attr("replace")(); });
  };
  return std::make_unique<learn::RecoveringPpo>(std::move(setup), std::move(holder),
                                                options.threads, replace);
}

nb::dict dict_of(const learn::Report& report) {
  nb::dict losses;
  for (const auto& [name, value] : report.losses) losses[name.c_str()] = value;
  nb::dict values;
  values["steps"] = report.steps;
  values["episode_returns"] = array_of<float>(report.episode_returns);
  values["position_error"] = report.position_error;
  values["faults"] = report.faults;
  values["environment_seconds"] = report.environment_seconds;
  values["inference_seconds"] = report.inference_seconds;
  values["update_seconds"] = report.update_seconds;
  values["losses"] = losses;
  return values;
}

nb::dict iterate(AnyLearner& any) {
  learn::Report report;
  {
    const nb::gil_scoped_release release;
    report = any.learner->iterate();
  }
  return dict_of(report);
}

nb::tuple save(const AnyLearner& any) {
  const LearnerState state = any.learner->state();
  return state_of(state.blocks, state.environments);
}

void restore(AnyLearner& any, nb::handle state) {
  LearnerState read;
  read.environments = read_state(state, read.blocks);
  any.learner->restore(read);
}

}  // namespace

static void bind_hyperparameters(nb::module_& m) {
  m.def(
      "position_errors",
      [] {
        nb::list errors;
        for (const char* name : learn::kPositionErrors) errors.append(name);
        return nb::tuple(errors);
      },
      nb::sig("def position_errors() -> tuple[str, ...]"),
      "Infos that are a distance from the goal [m], the first that a task has counts.");
  m.def(
      "hyperparameters",
      [](const std::string& algorithm, const nb::dict& values) {
        const learn::Algorithm which = algorithm_of(algorithm);
        return dict_of(hyperparameters_of(values, which), which);
      },
      nb::arg("algorithm"), nb::arg("values") = nb::dict(),
      nb::sig("def hyperparameters(algorithm: str, values: dict[str, typing.Any] = {}) -> "
              "dict[str, typing.Any]"),
      "All hyper-parameters of a learner in C++: those given, and the defaults of the others.");
  m.def(
      "hyperparameter_rows",
      [](const std::string& algorithm) {
        const learn::Algorithm which = algorithm_of(algorithm);
        nb::list rows;
        for (const learn::HyperparameterRow& row : learn::hyperparameter_rows()) {
          if (!learn::has(row, which)) continue;
          rows.append(nb::make_tuple(row.name, row.least, row.largest, row.meaning));
        }
        return rows;
      },
      nb::arg("algorithm"),
      nb::sig("def hyperparameter_rows(algorithm: str) -> "
              "list[tuple[str, float, float, str]]"),
      "The list of a learner in C++: (name, least value, largest value, meaning).");
}

static void bind_slices(nb::module_& m) {
  nb::class_<HeldSlices>(m, "PpoSlices",
                         "Consecutive slices of the environments of a `Ppo`, for a worker. What a "
                         "method gives is a list with an entry a slice.")
      .def(
          "__init__",
          [](HeldSlices* self, const LoadedScenario& scenario, const nb::dict& hyper,
             std::uint64_t seed, std::int64_t total_steps, int first, int count, int threads) {
            new (self) HeldSlices(learner_options(scenario, learn::Algorithm::kFastPpo, hyper, seed,
                                                  total_steps, threads),
                                  first, count);
          },
          nb::sig("def __init__(self, compiled: CompiledScenario, hyper: dict[str, typing.Any], "
                  "seed: int, total_steps: int, first: int, count: int, threads: int = 1) -> None"),
          nb::arg("compiled"), nb::arg("hyper"), nb::arg("seed"), nb::arg("total_steps"),
          nb::arg("first"), nb::arg("count"), nb::arg("threads") = 1)
      .def("collect", &HeldSlices::collect,
           nb::sig("def collect(self, policy: object, value: object, iteration: int, mean: object, "
                   "scale: object, return_mean: float) -> list[typing.Any]"),
           nb::arg("policy"), nb::arg("value"), nb::arg("iteration"), nb::arg("mean"),
           nb::arg("scale"), nb::arg("return_mean"),
           "A rollout with these parameters: (sums, returns of the episodes that ended).")
      .def("find_advantages", &HeldSlices::find_advantages,
           nb::sig("def find_advantages(self, reward_scale: float) -> list[typing.Any]"),
           nb::arg("reward_scale"), "Sums of the advantages.")
      .def("find_gradients", &HeldSlices::find_gradients,
           nb::sig("def find_gradients(self, policy: object, value: object, epoch: int, index: "
                   "int, wants_policy: bool, wants_value: bool, advantage_mean: float, "
                   "advantage_scale: float) -> list[typing.Any]"),
           nb::arg("policy"), nb::arg("value"), nb::arg("epoch"), nb::arg("index"),
           nb::arg("wants_policy"), nb::arg("wants_value"), nb::arg("advantage_mean"),
           nb::arg("advantage_scale"),
           "Of a minibatch: (sums, gradient of the policy, of the value function); gradients "
           "that are not wanted are empty.")
      .def("rollout", &HeldSlices::rollout, nb::sig("def rollout(self) -> list[typing.Any]"),
           "What is learned from: normalized inputs, actions, log-probabilities, advantages and "
           "targets of the value function, (rows, values) each, and the rows' order in the last "
           "epoch.")
      .def("stagger_resets", &HeldSlices::stagger_resets, nb::arg("iteration"))
      .def("save", &HeldSlices::save, nb::sig("def save(self) -> list[typing.Any]"),
           "(blocks by name, the environments' words).")
      .def("restore", &HeldSlices::restore,
           nb::sig("def restore(self, states: list[typing.Any]) -> None"), nb::arg("states"),
           "The inverse of save().");
}

static void bind_learners(nb::module_& m) {
  nb::class_<AnyLearner>(m, "NativeLearner", "What the learners in C++ have in common.")
      .def_prop_ro("steps", [](const AnyLearner& any) { return any.learner->steps(); })
      .def_prop_ro("parameter_hash",
                   [](const AnyLearner& any) { return any.learner->parameter_hash(); })
      .def("iterate", &iterate, nb::sig("def iterate(self) -> dict[str, typing.Any]"),
           "One rollout and its update; a report by name.")
      .def(
          "policy", [](const AnyLearner& any) { return dict_of(any.learner->policy()); },
          nb::sig("def policy(self) -> dict[str, typing.Any]"), "As `read_policy_file` gives it.")
      .def("save", &save, nb::sig("def save(self) -> tuple[typing.Any, typing.Any]"),
           "(blocks of words by name, words of the environments).")
      .def("restore", &restore, nb::sig("def restore(self, state: object) -> None"),
           nb::arg("state"), "The inverse of save().");
  nb::class_<AnyPpo, AnyLearner>(m, "Ppo", "The learner `fast-ppo`.")
      .def(
          "__init__",
          [](AnyPpo* self, const LoadedScenario& scenario, const nb::dict& hyper,
             std::uint64_t seed, std::int64_t total_steps, int threads, const nb::object& slices) {
            new (self) AnyPpo{make_ppo(scenario,
                                       learner_options(scenario, learn::Algorithm::kFastPpo, hyper,
                                                       seed, total_steps, threads),
                                       slices)};
          },
          nb::arg("compiled"), nb::arg("hyper"), nb::arg("seed"), nb::arg("total_steps"),
          nb::arg("threads") = 0, nb::arg("slices") = nb::none(),
          nb::sig("def __init__(self, compiled: CompiledScenario, hyper: dict[str, typing.Any], "
                  "seed: int, total_steps: int, threads: int = 0, slices: object | None = None) "
                  "-> None"));
  nb::class_<AnyGradient, AnyLearner>(m, "Gradient", "The learner `gradient`.")
      .def(
          "__init__",
          [](AnyGradient* self, const LoadedScenario& scenario, const nb::dict& hyper,
             std::uint64_t seed, std::int64_t total_steps, int threads) {
            new (self)
                AnyGradient{make_learner(learn::Algorithm::kGradient, scenario.options(),
                                         learner_options(scenario, learn::Algorithm::kGradient,
                                                         hyper, seed, total_steps, threads))};
          },
          nb::arg("compiled"), nb::arg("hyper"), nb::arg("seed"), nb::arg("total_steps"),
          nb::arg("threads") = 0,
          nb::sig("def __init__(self, compiled: CompiledScenario, hyper: dict[str, typing.Any], "
                  "seed: int, total_steps: int, threads: int = 0) -> None"));
}

void bind_ppo(nb::module_& m) {
  nb::exception<learn::SlicesLost>(m, "SlicesLost", m.attr("Error")).doc() =
      "Workers died. The iteration can be repeated.";
  nb::exception<learn::Diverged>(m, "Diverged", m.attr("Error")).doc() =
      "A loss or a parameter is no longer finite. The newest checkpoint is of a state before that.";
  bind_hyperparameters(m);
  bind_slices(m);
  bind_learners(m);
}

}  // namespace skybody::python
