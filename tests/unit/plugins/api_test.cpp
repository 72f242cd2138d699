// Compile-time properties of the headers for plugin authors.
#include <gtest/gtest.h>
#include <skybody/plugin.h>

#include <fstream>
#include <iterator>
#include <string>

namespace skybody {
namespace {

class InPacks : public Controller {
 public:
  void configure(const Setup&) override {}
  template <class Real>
  void control(const EnvView<Real>&, State<Real>&, ConstValues<Real>, Values<Real>) const {}
};

/// For one width of packs only, which not every machine supports.
class InFours : public Controller {
 public:
  void configure(const Setup&) override {}
  template <class Real>
  requires(std::is_same_v<Real, double> ||
           std::is_same_v<Real, Pack<4>>) void control(const EnvView<Real>&, State<Real>&,
                                                       ConstValues<Real>, Values<Real>) const {}
};

TEST(PluginApi, LaneCodeServesPacksOfEveryWidth) {
  EXPECT_TRUE(plugin_export::kVectorized<InPacks>);
  EXPECT_FALSE(plugin_export::kVectorized<InFours>);
}

TEST(PluginApi, NumbersInMessagesKeepTheirSize) {
  EXPECT_EQ(to_text(1.9533e-6), "1.9533e-06");
  EXPECT_EQ(to_text(4.0), "4");
}

/// abi.h and the hash of its structures list the same structures, in the same order.
TEST(PluginApi, HandshakeCoversEveryStructure) {
  // All words between `before` and `after` that begin with Skybody.
  const auto names = [](const std::string& file, const std::string& before,
                        const std::string& after) {
    std::ifstream in(std::string(SKYBODY_SOURCE_DIR) + file);
    const std::string text{std::istreambuf_iterator<char>(in), {}};
    std::string all;
    for (std::size_t at = text.find(before); at != std::string::npos;
         at = text.find(before, at + 1)) {
      const std::size_t begin = at + before.size(), end = text.find(after, begin);
      const std::string name = text.substr(begin, end - begin);
      if (name.rfind("Skybody", 0) == 0 && name.find('\n') == std::string::npos) all += name + " ";
    }
    return all;
  };
  const std::string declared = names("/core/plugin_abi/abi.h", "typedef struct ", " {");
  EXPECT_NE(declared, "");
  EXPECT_EQ(declared, names("/core/plugin_abi/structures.h", "sizeof(", ")"));
}

}  // namespace
}  // namespace skybody
