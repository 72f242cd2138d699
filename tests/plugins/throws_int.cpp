// Refuses every scenario with an int.
#include <skybody/plugin.h>

namespace {

using namespace skybody;

class ThrowsInt : public Controller {
 public:
  void configure(const Setup&) override { throw 3; }
  void control(const EnvView<double>&, State<double>&, ConstValues<double>, Values<double>) const {}
};

}  // namespace

SKYBODY_PLUGIN(ThrowsInt, "throws_int", "1.0.0", "Throws something else in configure.");
