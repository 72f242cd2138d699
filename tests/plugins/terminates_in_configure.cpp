// Sends itself SIGTERM, as a user could, in configure().
#include <signal.h>
#include <skybody/plugin.h>
#include <unistd.h>

namespace {

using namespace skybody;

class TerminatesInConfigure : public Controller {
 public:
  void configure(const Setup&) override { kill(getpid(), SIGTERM); }
  void control(const EnvView<double>&, State<double>&, ConstValues<double>, Values<double>) const {}
};

}  // namespace

SKYBODY_PLUGIN(TerminatesInConfigure, "terminates_in_configure", "1.0.0",
               "Sends itself SIGTERM, as a user would, in configure().");
