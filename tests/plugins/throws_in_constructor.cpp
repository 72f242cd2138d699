// Throws in its constructor, while the library is being loaded.
#include <skybody/plugin.h>

#include <stdexcept>

namespace {

using namespace skybody;

class ThrowsInConstructor : public Controller {
 public:
  ThrowsInConstructor() { throw std::runtime_error("no licence"); }
  void configure(const Setup&) override {}
  void control(const EnvView<double>&, State<double>&, ConstValues<double>, Values<double>) const {}
};

}  // namespace

SKYBODY_PLUGIN(ThrowsInConstructor, "throws_in_constructor", "1.0.0", "Throws when constructed.");
