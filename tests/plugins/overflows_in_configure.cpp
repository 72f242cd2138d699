// Overflows the stack in configure().
#include <skybody/plugin.h>

namespace {

using namespace skybody;

/// Unbounded recursion: `depth` never reaches the limit.
int fill_stack(volatile int* depth) {
  volatile int page[1024] = {};
  page[0] = *depth + 1;
  return page[0] < 0 ? 0 : fill_stack(page) + page[0];
}

class OverflowsInConfigure : public Controller {
 public:
  void configure(const Setup&) override {
    volatile int depth = 0;
    depth = fill_stack(&depth);
  }
  void control(const EnvView<double>&, State<double>&, ConstValues<double>, Values<double>) const {}
};

}  // namespace

SKYBODY_PLUGIN(OverflowsInConfigure, "overflows_in_configure", "1.0.0",
               "Uses up the stack in configure().");
