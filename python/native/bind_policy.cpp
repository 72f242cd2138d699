#include <nanobind/stl/string.h>

#include <string>
#include <string_view>

#include "core/io/policy_seal.h"
#include "core/model/marked_error.h"
#include "python/native/bindings.h"

namespace skybody::python {
namespace {

nb::bytes bytes_of(const std::string& text) { return nb::bytes(text.data(), text.size()); }

nb::bytes read_sealed(const std::string& file) {
  try {
    return bytes_of(read_sealed_policy(file));
  } catch (const MarkedError& error) {
    throw Error(error.mark().file + ": " + error.what());
  }
}

}  // namespace

void bind_policy(nb::module_& m) {
  m.def(
      "policy_seal",
      [](const nb::bytes& content) {
        return bytes_of(policy_seal(std::string_view(content.c_str(), content.size())));
      },
      nb::arg("content"),
      "The first 512 bytes of a policy.h5 whose other bytes are `content`. docs/policies.md says "
      "what they hold.");
  m.def("read_sealed_policy", &read_sealed, nb::arg("path"),
        "All bytes of a policy.h5. Error, which names the file, where they are not those that its "
        "seal names.");
}

}  // namespace skybody::python
