// Ends the process with status 0 in configure().
#include <skybody/plugin.h>
#include <stdlib.h>

namespace {

using namespace skybody;

class ExitsInConfigure : public Controller {
 public:
  void configure(const Setup&) override { exit(0); }
  void control(const EnvView<double>&, State<double>&, ConstValues<double>, Values<double>) const {}
};

}  // namespace

SKYBODY_PLUGIN(ExitsInConfigure, "exits_in_configure", "1.0.0",
               "Ends the process, as if all were well, in configure().");
