#include <nanobind/stl/filesystem.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <array>
#include <cstddef>
#include <cstring>
#include <new>
#include <optional>
#include <string>
#include <vector>

#include "python/native/arrays.h"
#include "python/native/batch.h"
#include "python/native/bindings.h"
#include "python/native/properties.h"
#include "python/native/python_pool.h"
#include "python/native/state_array.h"

namespace skybody::python {
namespace {

/// "order is 'x'; allowed: 'fixed', 'arrival'".
template <std::size_t N>
[[noreturn]] void refuse_word(const std::string& what, const std::string& text,
                              const std::array<const char*, N>& names) {
  std::string allowed;
  for (const char* name : names) {
    allowed += (allowed.empty() ? "'" : ", '") + std::string(name) + "'";
  }
  throw nb::value_error((what + " is '" + text + "'; allowed: " + allowed).c_str());
}

Order to_order(const std::string& text) {
  if (const auto order = order_from(text)) return *order;
  refuse_word("order", text, kOrderNames);
}

Autoreset to_autoreset(const std::string& text) {
  if (const auto autoreset = autoreset_from(text)) return *autoreset;
  refuse_word("autoreset", text, kAutoresetNames);
}

void construct(PythonPool* self, const LoadedScenario& compiled, int num_envs, int batch_size,
               int num_threads, const std::string& order, const std::string& autoreset,
               std::uint64_t seed, std::uint64_t first_env_id, bool pin_threads, bool keep_hash,
               bool info, bool debug) {
  PoolOptions options;
  options.envs = num_envs;
  options.batch = batch_size;
  options.threads = num_threads;
  options.order = to_order(order);
  options.autoreset = to_autoreset(autoreset);
  options.seed = seed;
  options.first_env_id = first_env_id;
  options.pin_threads = pin_threads;
  options.keep_hash = keep_hash;
  options.info = info;
  options.debug_buffers = debug;
  new (self) PythonPool(compiled, options);
}

void send_reset(PythonPool& self, nb::handle mask, std::optional<std::uint64_t> seed) {
  if (!mask.is_none() && seed) {
    throw nb::value_error("send_reset() takes a mask or a seed: a seed begins all environments");
  }
  if (seed) {
    self.call_with_argument([&](Pool& pool) { pool.send_reset(*seed); });
  } else if (mask.is_none()) {
    self.call_with_argument([](Pool& pool) { pool.send_reset(); });
  } else {
    const auto chosen = read_mask(mask, "mask", self.envs());
    self.call_with_argument([&](Pool& pool) { pool.send_reset(chosen); });
  }
}

void send(PythonPool& self, nb::handle actions, nb::handle env_ids) {
  const std::int64_t width = self.compiled()->action_size();
  if (env_ids.is_none()) {
    const auto rows = read_array<float>(actions, "actions", {self.envs(), width});
    self.send(rows.span());
    return;
  }
  const auto ids = read_array<std::int32_t>(env_ids, "env_ids", {-1});
  const auto rows =
      read_array<float>(actions, "actions", {static_cast<std::int64_t>(ids.rows()), width});
  if (!ids.span().empty())
    self.send(rows.span(), ids.span());  // an empty list means all to the pool
}

ReceivedBatch received(const PythonPool& self, std::shared_ptr<const Batch> batch) {
  std::vector<std::int32_t> clipped = self.clipped(*batch);
  return {std::move(batch), self.compiled().shared(), std::move(clipped)};
}

ReceivedBatch step(PythonPool& self, nb::handle actions) {
  const std::int64_t width = self.compiled()->action_size();
  const auto rows = read_array<float>(actions, "actions", {self.envs(), width});
  return received(self, self.step(rows.span()));
}

/// @param lines  changes, see read_param_change(); @param redraws  all randomizers draw instead
void request(PythonPool& self, const std::vector<std::string>& lines, bool redraws, bool at_reset,
             nb::handle env_ids) {
  const RequestTime when = at_reset ? RequestTime::kNextReset : RequestTime::kNextStep;
  const auto ask = [&](std::span<const std::int32_t> ids) {
    self.call_with_argument([&](Pool& pool) {
      if (redraws) return pool.randomize(when, ids);
      pool.request(read_param_changes(lines), when, ids);
    });
  };
  if (env_ids.is_none()) return ask({});
  const auto ids = read_array<std::int32_t>(env_ids, "env_ids", {-1});
  if (!ids.span().empty()) ask(ids.span());  // an empty list means all to the pool
}

nb::bytes save(PythonPool& self) {
  const auto words = self.call([](Pool& pool) { return pool.save(); });
  return nb::bytes(words.data(), words.size() * sizeof(std::uint64_t));
}

void restore(PythonPool& self, const nb::bytes& saved) {
  if (saved.size() % sizeof(std::uint64_t) != 0) {
    throw nb::value_error(("saved state of " + std::to_string(saved.size()) +
                           " bytes is not what save() gave: it was cut or changed")
                              .c_str());
  }
  std::vector<std::uint64_t> words(saved.size() / sizeof(std::uint64_t));
  if (!words.empty()) std::memcpy(words.data(), saved.data(), saved.size());
  self.call_with_argument([&](Pool& pool) { pool.restore(words); });
}

/// Rows of all environments. @tparam write  the pool's function that writes them
template <void (Pool::*write)(std::span<float>) const>
nb::object rows_of(PythonPool& self, int width) {
  const auto rows = static_cast<std::size_t>(self.envs());
  const auto columns = static_cast<std::size_t>(width);
  std::vector<float> values(rows * columns);
  self.call([&](Pool& pool) { (pool.*write)(values); });
  return copy_of<float>(values, {rows, columns});
}

nb::object observations(PythonPool& self) {
  return rows_of<&Pool::observations>(self, self.compiled()->observation_size());
}

nb::object privileged(PythonPool& self) {
  return rows_of<&Pool::privileged>(self, self.compiled()->privileged_size());
}

nb::object image(PythonPool& self, int index) {
  const auto& images = self.compiled()->images();
  check_image(index, images.size());
  const auto rows = static_cast<std::size_t>(self.envs());
  const auto width = static_cast<std::size_t>(images[static_cast<std::size_t>(index)].bytes);
  std::vector<std::uint8_t> pixels(rows * width);
  self.call([&](Pool& pool) { pool.image(index, pixels); });
  return copy_of<std::uint8_t>(pixels, {rows, width});
}

nb::object state(PythonPool& self, const std::string& path) {
  return state_array(self.compiled(), path, {static_cast<std::size_t>(self.envs())},
                     [&](std::vector<double>& values) {
                       self.call_with_argument([&](Pool& pool) { pool.state(path, values); });
                     });
}

nb::object goals(PythonPool& self, int env) {
  const std::vector<double> values =
      self.call_with_argument([&](Pool& pool) { return pool.goals(env); });
  return copy_of<double>(values, {values.size() / 4, 4});
}

/// The value of one of the pool's functions.
template <auto value>
auto asked(PythonPool& self) {
  return self.call([](Pool& pool) { return (pool.*value)(); });
}

void fork(PythonPool& self, int source, nb::handle targets, bool rekey) {
  const auto ids = read_array<std::int32_t>(targets, "targets", {-1});
  self.call_with_argument([&](Pool& pool) { pool.fork(source, ids.span(), rekey); });
}

std::uint64_t hash(PythonPool& self, std::optional<int> env) {
  if (!env) return self.call([](Pool& pool) { return pool.hash(); });
  return self.call_with_argument([&](Pool& pool) { return pool.hash(*env); });
}

nb::object refuse_pickling(const PythonPool&) {
  throw nb::type_error(
      "a Pool cannot be pickled or copied: it has threads. Make one anew in the other process, "
      "from the scenario and the seed; save() gives the state as bytes for restore() there");
}

using Class = nb::class_<PythonPool>;

void bind_flow(Class& c) {
  c.def("send_reset", &send_reset, nb::arg("mask") = nb::none(), nb::arg("seed") = nb::none(),
        nb::sig("def send_reset(self, mask: numpy.typing.NDArray[numpy.bool | numpy.uint8] | None "
                "= None, seed: int | None = None) -> None"),
        "Begins new episodes; recv() gives their first observations.\n\n"
        "mask: (num_envs,) bool or uint8: which environments; None: all\n"
        "seed: puts every environment at its beginning under this seed, episode counters too\n\n"
        "Raises ValueError if one of them is in flight, if the mask has another shape, or if both\n"
        "are given; TypeError if the mask has another dtype.");
  c.def("send", &send, nb::arg("actions").none(), nb::arg("env_ids") = nb::none(),
        nb::sig("def send(self, actions: numpy.typing.NDArray[numpy.float32], env_ids: "
                "numpy.typing.NDArray[numpy.int32] | None = None) -> None"),
        "Hands over one action row per environment and returns; the rows are copied before.\n\n"
        "actions: (n, A) float32 in [-1, 1] (clipped); a row that is not finite faults that\n"
        "    environment and no other\n"
        "env_ids: (n,) int32, each at most once; None: all environments in order\n\n"
        "Raises TypeError on another dtype (nothing is converted silently) and ValueError on\n"
        "another shape, or if an id is out of range, twice there, in flight, not yet reset, or "
        "(with\n"
        "autoreset disabled) its episode has ended; then nothing was sent.");
  c.def(
      "recv", [](PythonPool& self) { return received(self, self.recv()); },
      "Waits for batch_size finished environments, fewer where fewer are in flight. Works with\n"
      "the other threads meanwhile, without the GIL; KeyboardInterrupt gets through.\n\n"
      "Raises ValueError if nothing is in flight; BufferError in debug mode if the buffer that\n"
      "would be reused is still referred to; Error with whatever a worker met.");
  c.def("step", &step, nb::arg("actions").none(),
        nb::sig("def step(self, actions: numpy.typing.NDArray[numpy.float32]) -> Batch"),
        "send(actions) and recv() in one call, for pools whose batch has all environments.\n\n"
        "Raises Error where a step before was interrupted and its transitions are under way;\n"
        "otherwise as send() and recv().");
  c.def("refuse_interrupted", &PythonPool::refuse_interrupted,
        "Raises Error where a step was interrupted (Ctrl-C) and its transitions are under way.");
  c.def(
      "close", &PythonPool::close,
      "Finishes a recording and stops the threads; steps under way are waited for. May be called\n"
      "again; any other call raises Error from then on. Batches and their views stay valid.\n\n"
      "Raises Error if the recording cannot be finished; the pool is closed all the same.");
  def_context(c, "Pool");
}

void bind_state(Class& c) {
  c.def("state", &state, nb::arg("path"),
        nb::sig("def state(self, path: str) -> numpy.typing.NDArray[numpy.float64]"),
        "A value of the state of all environments, (num_envs, *shape) float64, fresh. What there "
        "is, with\n"
        "units, frames and shapes: CompiledScenario.state_values.\n\n"
        "Raises ValueError naming the nearest paths if there is none, or before a reset; Error\n"
        "while environments are in flight.");
  c.def("goals", &goals, nb::arg("env"),
        nb::sig("def goals(self, env: int) -> numpy.typing.NDArray[numpy.float64]"),
        "(goals, 4) float64: where the task wants its bodies in one environment: position (world) "
        "[m]\nand yaw [rad].\n\n"
        "Raises ValueError if there is no such environment, or before a reset; Error while\n"
        "environments are in flight.");
  c.def(
      "save", &save,
      "Everything of all environments as bytes: motion, drawn values, plugin states, random keys.\n"
      "\nRaises Error while some are in flight.");
  c.def("restore", &restore, nb::arg("saved"),
        "Puts back what save() gave.\n\n"
        "Raises ValueError if it is of another scenario or number of environments, Error while\n"
        "some are in flight.");
  c.def("fork", &fork, nb::arg("source"), nb::arg("targets").none(), nb::arg("rekey") = false,
        nb::sig("def fork(self, source: int, targets: numpy.typing.NDArray[numpy.int32], rekey: "
                "bool = False) -> None"),
        "Makes environments copies of `source`: same motion, drawn values and future.\n\n"
        "targets: (n,) int32\nrekey: each copy gets random numbers of its own\n\n"
        "Raises ValueError if an id is out of range or in flight.");
  c.def("observations", &observations,
        nb::sig("def observations(self) -> numpy.typing.NDArray[numpy.float32]"),
        "(num_envs, O) float32: fresh array with every environment's row as of now.");
  c.def("privileged", &privileged,
        nb::sig("def privileged(self) -> numpy.typing.NDArray[numpy.float32]"),
        "(num_envs, P) float32: fresh array with every environment's privileged row as of now.");
  c.def("image", &image, nb::arg("index"),
        nb::sig("def image(self, index: int) -> numpy.typing.NDArray[numpy.uint8]"),
        "(num_envs, bytes) uint8: fresh array with an image of every environment as of now, as\n"
        "Batch.image() has it.");
  c.def(
      "hash", &hash, nb::arg("env") = nb::none(),
      "64-bit trajectory hash of one environment, or of all in order of their ids.\n\n"
      "Raises Error without keep_hash or while some are in flight, ValueError if there is no such\n"
      "environment.");
}

void bind_params(Class& c) {
  c.def(
      "param",
      [](PythonPool& self, int env, const std::string& path) {
        return self.call_with_argument([&](Pool& pool) { return pool.param(env, path); });
      },
      nb::arg("env"), nb::arg("path"),
      "Value of a randomizable parameter in one environment; units in "
      "CompiledScenario.param_info.\n\n"
      "Raises ValueError if there is no such environment or parameter.");
  c.def(
      "set_param",
      [](PythonPool& self, int env, const std::string& path, double value) {
        self.call_with_argument([&](Pool& pool) { pool.set_param(env, path, value); });
      },
      nb::arg("env"), nb::arg("path"), nb::arg("value"),
      "Sets it, in mid-episode.\n\nRaises ValueError if unknown or outside its bounds.");
  c.def("request", &request, nb::arg("lines"), nb::arg("redraws"), nb::arg("at_reset"),
        nb::arg("env_ids").none() = nb::none(),
        nb::sig("def request(self, lines: list[str], redraws: bool, at_reset: bool, env_ids: "
                "numpy.typing.NDArray[numpy.int32] | None = None) -> None"),
        "Asks for values of parameters, also while environments are in flight.\n\n"
        "lines: changes as skybody.requests.request_lines makes them\n"
        "redraws: all randomizers draw instead\n"
        "at_reset: at the next reset, not with the next transition that is sent\n"
        "env_ids: (n,) int32; None: all environments\n\n"
        "Raises ValueError if there is no such environment or parameter, or a value would be\n"
        "outside its bounds; then nothing was asked for.");
}

void bind_recording(Class& c) {
  c.def(
      "record", &PythonPool::record, nb::arg("path"), nb::arg("states") = false,
      nb::sig("def record(self, path: str | os.PathLike[str], states: bool = False) -> None"),
      "Writes everything that happens from now on to a file, for `skybody replay`: what is sent,\n"
      "and what comes back with a trajectory hash. Replaces a file that is there. Rows are\n"
      "written in bursts of about 4 MiB, by stop_recording() and by close().\n\n"
      "states: all state words as well, so that a replay that differs can name them\n\n"
      "Raises Error while some are in flight or the pool is recorded already, or if the file\n"
      "cannot be written. Where writing fails later, send() or recv() raises it and the recording\n"
      "is over.");
  c.def("stop_recording", &PythonPool::stop_recording,
        "Finishes the file. What is in flight is not in it.\n\n"
        "Raises Error if nothing was being recorded, or the file cannot be finished.");
}

void bind_facts(Class& c) {
  c.def_prop_ro("compiled", &PythonPool::compiled, nb::rv_policy::reference_internal,
                "The scenario that it steps.");
  c.def_prop_ro("num_envs", &PythonPool::envs, "N_E: number of environments.");
  c.def_prop_ro("batch_size", &PythonPool::batch, "N_B: rows of a full batch.");
  c.def_prop_ro("num_threads", &PythonPool::threads, "N_T: threads that step, the caller counted.");
  c.def_prop_ro("pinned_threads", &PythonPool::pinned_threads,
                "Threads that have a processor of their own; 0 where pinning is not allowed.");
  c.def_prop_ro("closed", &PythonPool::closed, "Whether close() was called.");
  c.def_prop_ro("in_flight", asked<&Pool::in_flight>, "Environments sent and not yet received.");
  c.def_prop_ro("fresh_buffers", asked<&Pool::fresh_buffers>,
                "Buffers made because Python still held the one to be reused.");
  c.def_prop_ro(
      "clipped",
      [](PythonPool& self) { return self.call([&](Pool&) { return self.all_clipped(); }); },
      "Action values sent so far that lay beyond [-1, 1], and were clipped.");
  c.def_prop_ro("faults", asked<&Pool::faults>, "Faulted transitions received so far.");
  def_unpicklable(c, &refuse_pickling);
  c.def("__repr__", [](const PythonPool& p) {
    return "Pool(" + p.compiled()->scenario().name + ", " + std::to_string(p.envs()) +
           " environments, " + std::to_string(p.threads()) + " threads" +
           (p.closed() ? ", closed)" : ")");
  });
}

}  // namespace

void bind_pool(nb::module_& m) {
  Class c(
      m, "Pool",
      "Many environments of one scenario, stepped on several threads. What each environment\n"
      "does depends on scenario, seed, its id and its actions alone: not on threads, batches or\n"
      "order. One Python thread at a time: a call while another is inside one raises Error.");
  c.def("__init__", &construct, nb::arg("compiled"), nb::arg("num_envs"), nb::arg("batch_size") = 0,
        nb::arg("num_threads") = 0, nb::arg("order") = "fixed", nb::arg("autoreset") = "next_step",
        nb::arg("seed") = 0, nb::arg("first_env_id") = 0, nb::arg("pin_threads") = false,
        nb::arg("keep_hash") = false, nb::arg("info") = true, nb::arg("debug") = false,
        "num_envs: N_E >= 1\n"
        "batch_size: N_B, rows that recv() waits for, 1 ... num_envs; 0: num_envs\n"
        "num_threads: N_T, the caller counted; 0: one per processor\n"
        "order: `fixed` (by id, cyclically: the same batches in every run) or `arrival` (first\n"
        "    finished, first served)\n"
        "autoreset: `next_step` (the next action is ignored and the environment reset instead),\n"
        "    `same_step` (reset at once; final_observation has the ended episode's last row) or\n"
        "    `disabled` (stepping an ended environment raises)\n"
        "seed, first_env_id: environment i draws with the key (seed, first_env_id + i)\n"
        "pin_threads: give each worker a processor of its own where the system allows it; the\n"
        "    caller is left where it is\n"
        "keep_hash: chain a trajectory hash per environment\n"
        "info: whether rows carry info values (the task's, then what other plugins report);\n"
        "    without, tasks need not compute them\n"
        "debug: fill reused buffers with NaN, and raise BufferError where one is still held\n\n"
        "Raises ValueError if one of them is out of range.");
  bind_flow(c);
  bind_state(c);
  bind_params(c);
  bind_recording(c);
  bind_facts(c);
}

}  // namespace skybody::python
