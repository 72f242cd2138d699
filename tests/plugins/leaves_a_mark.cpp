// A valid plugin that creates the file named by SKYBODY_TEST_MARK when it is loaded, so that a test
// can detect whether it was loaded.
#include <skybody/plugin.h>

#include <cstdio>
#include <cstdlib>

namespace {

using namespace skybody;

[[maybe_unused]] const bool marked = [] {
  const char* name = std::getenv("SKYBODY_TEST_MARK");
  FILE* file = name != nullptr ? std::fopen(name, "w") : nullptr;
  if (file != nullptr) std::fclose(file);
  return file != nullptr;
}();

class LeavesAMark : public Controller {
 public:
  void configure(const Setup& setup) override {
    setup.input(Signal::kCtbt, {0, -1, -1, -1}, {60, 1, 1, 1});
    setup.output(Signal::kCtbt, 4);
  }
  template <class Real>
  void control(const EnvView<Real>&, State<Real>&, ConstValues<Real> in, Values<Real> out) const {
    for (int i = 0; i < 4; ++i) out.set(i, in[i]);
  }
};

}  // namespace

SKYBODY_PLUGIN(LeavesAMark, "leaves_a_mark", "1.0.0", "Passes its input on, and leaves a mark.");
