#include "app/pool_options.h"

#include "app/arguments.h"

namespace skybody {
namespace {

std::string with_default(const std::string& doc, int value) {
  return doc + " (" + std::to_string(value) + ")";
}

}  // namespace

void add_pool_options(CLI::App& command, PoolOptions& options) {
  command.add_option("--envs", options.envs, with_default("Number of environments", options.envs))
      ->type_name("N")
      ->check(whole_number(1, kMostEnvs));
  command
      .add_option("--threads", options.threads,
                  with_default("Number of threads; 0: one per processor", options.threads))
      ->type_name("T")
      ->check(whole_number(0, kMostThreads));
  command
      .add_option("--batch", options.batch,
                  with_default("Environments per batch; 0: all", options.batch))
      ->type_name("B")
      ->check(whole_number(0, kMostEnvs));
  command
      .add_option_function<std::string>(
          "--order",
          [&options](const std::string& name) { options.order = order_from(name).value(); },
          "Order of batches: fixed or arrival (" + to_text(options.order) + ")")
      ->type_name("ORDER")
      ->check(one_of("order", {kOrderNames.begin(), kOrderNames.end()}));
}

}  // namespace skybody
