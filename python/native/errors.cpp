#include "python/native/errors.h"

#include "core/io/yaml/diagnostics.h"
#include "python/native/bindings.h"

namespace skybody::python {

void bind_errors(nb::module_& m) {
  // The last registered translator is tried first, so derived classes follow their base.
  nb::exception<Error>(m, "Error", PyExc_RuntimeError).doc() =
      "The engine cannot do what was asked: a closed pool, a state of another scenario, a worker "
      "that met an\nerror. The message has the value, what is allowed and the remedy.";
  nb::exception<InputError>(m, "InputError", PyExc_ValueError).doc() =
      "A scenario, or a file that it names, cannot be used. The message has every mistake as\n"
      "`file:line:column: error: ...`, one a line.";
  nb::register_exception_translator([](const std::exception_ptr& thrown, void*) {
    try {
      std::rethrow_exception(thrown);
    } catch (const BufferInUse& e) {
      PyErr_SetString(PyExc_BufferError, e.what());
    }
  });
}

}  // namespace skybody::python
