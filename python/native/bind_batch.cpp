#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <cstring>
#include <optional>
#include <string>
#include <vector>

#include "core/base/system/error.h"
#include "python/native/arrays.h"
#include "python/native/batch.h"
#include "python/native/bindings.h"

namespace skybody::python {
namespace {

/// A view of a column, with `Element` as NumPy's element type. It holds the Python object, which
/// holds the buffer. Writable although the engine's memory is constant: the engine does not read it
/// again, and learners (torch.from_numpy) refuse read-only arrays or warn about them.
template <class Element, class T>
Element* memory(const Column<T>& column) {
  static_assert(sizeof(Element) == sizeof(T));
  return const_cast<Element*>(reinterpret_cast<const Element*>(column.data()));
}

template <auto column, class Element>
Array1<Element> values(nb::handle_t<ReceivedBatch> self) {
  const Batch& batch = *nb::cast<const ReceivedBatch&>(self).core;
  return Array1<Element>(memory<Element>(batch.*column), {static_cast<std::size_t>(batch.rows)},
                         self);
}

/// None if no row is a fault, which is the usual case.
std::optional<std::vector<std::optional<std::string>>> fault_reasons(const ReceivedBatch& self) {
  const Batch& batch = *self.core;
  const auto count = static_cast<std::size_t>(batch.rows);
  if (std::memchr(batch.fault.data(), 1, count) == nullptr) return std::nullopt;
  std::vector<std::optional<std::string>> reasons(count);
  for (std::size_t i = 0; i < count; ++i) {
    if (batch.fault[i] != 0) reasons[i] = self.compiled->fault_reason(batch.status[i]);
  }
  return reasons;
}

/// None if no action was clipped, which is the usual case.
nb::object clipped(const ReceivedBatch& self) {
  if (self.clipped.empty()) return nb::none();
  return array_of<std::int32_t>(self.clipped);
}

template <auto column, auto width>
Array2<float> rows(nb::handle_t<ReceivedBatch> self) {
  const Batch& batch = *nb::cast<const ReceivedBatch&>(self).core;
  return Array2<float>(
      memory<float>(batch.*column),
      {static_cast<std::size_t>(batch.rows), static_cast<std::size_t>(batch.width.*width)}, self);
}

/// Rows that exist only under one mode of autoreset.
template <auto column, auto width>
Array2<float> final_rows(nb::handle_t<ReceivedBatch> self) {
  const Batch& batch = *nb::cast<const ReceivedBatch&>(self).core;
  if ((batch.*column).empty() && batch.width.*width > 0) {
    throw Error(
        "rows from before a reset are kept with autoreset='same_step' only; with the others, the "
        "last row of an ended episode is in `observation` and `info`");
  }
  return rows<column, width>(self);
}

/// The bytes of an image, (n, bytes); shape and type are in the column.
Array2<std::uint8_t> image_rows(nb::handle_t<ReceivedBatch> self,
                                const std::vector<Column<std::uint8_t>>& images, int index) {
  const Batch& batch = *nb::cast<const ReceivedBatch&>(self).core;
  check_image(index, batch.width.images.size());
  const auto k = static_cast<std::size_t>(index);
  if (images.empty()) {
    throw Error("images from before a reset are kept with autoreset='same_step' only");
  }
  return Array2<std::uint8_t>(
      memory<std::uint8_t>(images[k]),
      {static_cast<std::size_t>(batch.rows), static_cast<std::size_t>(batch.width.images[k])},
      self);
}

Array2<std::uint8_t> image(nb::handle_t<ReceivedBatch> self, int index) {
  return image_rows(self, nb::cast<const ReceivedBatch&>(self).core->images, index);
}
Array2<std::uint8_t> final_image(nb::handle_t<ReceivedBatch> self, int index) {
  return image_rows(self, nb::cast<const ReceivedBatch&>(self).core->final_images, index);
}

using Class = nb::class_<ReceivedBatch>;

void bind_outcome(Class& c) {
  c.def_prop_ro(
      "observation", &rows<&Batch::observation, &RowWidths::observation>,
      "(n, O) float32: after the transition; under same_step autoreset, after the reset.");
  c.def_prop_ro("reward", &values<&Batch::reward, float>,
                "(n,) float32: of a team, the team's. 0 where was_reset or fault.");
  c.def_prop_ro("agent_reward", &rows<&Batch::agent_reward, &RowWidths::agents>,
                "(n, agents) float32: each agent's own; the team's where the task gives no own.");
  c.def_prop_ro("info", &rows<&Batch::info, &RowWidths::info>,
                "(n, I) float32: info values (the task's, then what other plugins report), as\n"
                "CompiledScenario.info_channels names them.");
  c.def_prop_ro("final_observation",
                &final_rows<&Batch::final_observation, &RowWidths::observation>,
                "(n, O) float32: before the reset, meaningful where terminated or truncated.\n\n"
                "Raises Error unless autoreset is same_step.");
  c.def_prop_ro("final_info", &final_rows<&Batch::final_info, &RowWidths::info>,
                "(n, I) float32: like final_observation.");
}

void bind_columns(Class& c) {
  c.def_prop_ro(
      "privileged", &rows<&Batch::privileged, &RowWidths::privileged>,
      "(n, P) float32: what a critic sees besides, as CompiledScenario.observation_columns\n"
      "names it.");
  c.def_prop_ro("final_privileged", &final_rows<&Batch::final_privileged, &RowWidths::privileged>,
                "(n, P) float32: like final_observation.");
  c.def("image", &image, nb::arg("index"),
        "(n, bytes) uint8: the memory of an image of the observation. With the column that has\n"
        "this index as its `image`, image(index).view(dtype).reshape(n, *shape) are the images.");
  c.def("final_image", &final_image, nb::arg("index"),
        "(n, bytes) uint8: likewise before the reset.");
}

void bind_flags(Class& c) {
  c.def_prop_ro("terminated", &values<&Batch::terminated, bool>,
                "(n,) bool: the task ended the episode.");
  c.def_prop_ro("truncated", &values<&Batch::truncated, bool>,
                "(n,) bool: horizon, task or fault ended the episode.");
  c.def_prop_ro(
      "fault", &values<&Batch::fault, bool>,
      "(n,) bool: a bad action, state or outcome ended the episode (fault_reasons): do not\n"
      "bootstrap it.");
  c.def_prop_ro("fault_reasons", &fault_reasons,
                "Per row why it is a fault, None where it is none; None where no row is one.");
  c.def_prop_ro("clipped", &clipped,
                nb::sig("def clipped(self) -> numpy.typing.NDArray[numpy.int32] | None"),
                "(n,) int32: how many values of each row's action lay beyond [-1, 1] and were\n"
                "clipped; None where no row has any.");
  c.def_prop_ro("was_reset", &values<&Batch::was_reset, bool>,
                "(n,) bool: the transition was a reset: no reward, the action was ignored.");
  c.def_prop_ro("status", &values<&Batch::status, std::uint64_t>,
                "(n,) uint64: bits 1 terminated, 2 truncated, 4 fault; with a fault 8 bad action, "
                "16 bad state, 32 bad outcome.");
  c.def_prop_ro("env_id", &values<&Batch::env_id, std::int32_t>,
                "(n,) int32: which environment each row is of.");
  c.def_prop_ro("episode_step", &values<&Batch::episode_step, std::int32_t>,
                "(n,) int32: actions taken in the episode that the row is of.");
}

}  // namespace

void bind_batch(nb::module_& m) {
  Class c(m, "Batch",
          "Finished transitions, one row per environment. Every array is a view of the engine's\n"
          "memory, no copy: its values stay until the second next recv(), and for as long as the\n"
          "Batch or a view of it is referred to. Views are writable.");
  bind_outcome(c);
  bind_columns(c);
  bind_flags(c);
  c.def("__len__", [](const ReceivedBatch& b) { return b.core->rows; });
  c.def("__repr__",
        [](const ReceivedBatch& b) { return nb::str("Batch({} rows)").format(b.core->rows); });
}

}  // namespace skybody::python
