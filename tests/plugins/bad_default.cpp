// Declares a parameter whose default is outside its own range.
#include <skybody/plugin.h>

namespace {

using namespace skybody;

class BadDefault : public Controller {
 public:
  void configure(const Setup&) override {}
  void control(const EnvView<double>&, State<double>&, ConstValues<double>, Values<double>) const {}

 private:
  RealParameter tau_{
      this, {.name = "tau", .unit = "s", .value = 0.5, .min = 1.0, .max = 2.0, .doc = "time"}};
};

}  // namespace

SKYBODY_PLUGIN(BadDefault, "bad_default", "1.0.0", "Has a default outside its range.");
