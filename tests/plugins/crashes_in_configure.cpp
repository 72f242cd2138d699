// Aborts in configure().
#include <skybody/plugin.h>
#include <stdlib.h>

namespace {

using namespace skybody;

class CrashesInConfigure : public Controller {
 public:
  void configure(const Setup&) override { abort(); }
  void control(const EnvView<double>&, State<double>&, ConstValues<double>, Values<double>) const {}
};

}  // namespace

SKYBODY_PLUGIN(CrashesInConfigure, "crashes_in_configure", "1.0.0", "Aborts in configure().");
