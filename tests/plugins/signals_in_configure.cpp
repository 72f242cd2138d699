// Sends itself the signal of a crash in configure().
#include <signal.h>
#include <skybody/plugin.h>
#include <unistd.h>

namespace {

using namespace skybody;

class SignalsInConfigure : public Controller {
 public:
  void configure(const Setup&) override { kill(getpid(), SIGSEGV); }
  void control(const EnvView<double>&, State<double>&, ConstValues<double>, Values<double>) const {}
};

}  // namespace

SKYBODY_PLUGIN(SignalsInConfigure, "signals_in_configure", "1.0.0",
               "Sends itself the signal of a crash in configure().");
