// Refuses every scenario with a std::exception.
#include <skybody/plugin.h>

#include <stdexcept>

namespace {

using namespace skybody;

class ThrowsError : public Controller {
 public:
  void configure(const Setup& setup) override {
    throw std::runtime_error("needs 6 rotors, robot `" + std::string(setup.robots()[0].name) +
                             "` has 4");
  }
  void control(const EnvView<double>&, State<double>&, ConstValues<double>, Values<double>) const {}
};

}  // namespace

SKYBODY_PLUGIN(ThrowsError, "throws_error", "1.0.0", "Throws in configure.");
