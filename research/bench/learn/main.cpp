// Our networks and Eigen's: nanoseconds per sample and GFLOP/s on one thread, of a small
// network and a wide one, forward and forward with backward. "Eigen, products alone" has neither
// biases nor activations: the time of a bare GEMM of these shapes.
//
//     bench_learn [ROWS]      rows of a batch, default 1024
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <vector>

#include "learn/network/adam.h"
#include "learn/network/network.h"
#include "learn/network/noise.h"
#include "learn/network/recurrent_network.h"
#include "research/bench/learn/eigen_network.h"

namespace skybody::bench {
namespace {

using Clock = std::chrono::steady_clock;

template <class Function>
double quickest(int repeats, const Function& function) {
  double best = 1e9;
  for (int k = 0; k < repeats; ++k) {
    const Clock::time_point begin = Clock::now();
    function();
    best = std::min(best, std::chrono::duration<double>(Clock::now() - begin).count());
  }
  return best;
}

NetworkTimes time_ours(const std::vector<int>& sizes, int rows, int repeats, Isa isa) {
  const learn::Network network(
      {sizes.front(), {sizes.begin() + 1, sizes.end() - 1}, sizes.back(), Activation::kTanh}, isa);
  std::vector<float> parameters(network.parameter_count()), gradient(parameters.size());
  network.initialize(parameters, 1.0, 1, 2);
  learn::TransposedWeights transposed;
  network.transpose(parameters, transposed);
  learn::NetworkActivations memory;
  const int inputs = sizes.front(), outputs = sizes.back();
  AlignedArray<float> x(static_cast<std::size_t>(rows) * static_cast<std::size_t>(inputs));
  learn::draw_normals({}, {x.data(), x.size()}, isa);
  std::vector<float> y(static_cast<std::size_t>(rows * outputs));
  const auto forward = [&] {
    network.forward(parameters, x.data(), inputs, rows, memory, y.data(), outputs);
  };
  NetworkTimes times;
  times.forward = quickest(repeats, forward);
  times.both = quickest(repeats, [&] {
    forward();
    network.backward(transposed, x.data(), inputs, memory, y.data(), outputs, gradient);
  });
  return times;
}

void print_row(const char* what, const NetworkTimes& times, const std::vector<int>& sizes,
               int rows) {
  double forward = 0.0, both = 0.0;  // multiply-adds per sample
  for (std::size_t k = 0; k + 1 < sizes.size(); ++k) {
    const double products = static_cast<double>(sizes[k]) * sizes[k + 1];
    forward += products;
    both += products * (k > 0 ? 3.0 : 2.0);
  }
  const auto rate = [&](double count, double seconds) { return 2e-9 * count * rows / seconds; };
  std::printf("  %-22s %9.1f ns %7.1f GFLOP/s %9.1f ns %7.1f GFLOP/s\n", what,
              1e9 * times.forward / rows, rate(forward, times.forward), 1e9 * times.both / rows,
              rate(both, times.both));
}

void compare(const std::vector<int>& sizes, int rows, int repeats) {
  for (std::size_t k = 0; k < sizes.size(); ++k) std::printf(k > 0 ? "-%d" : "%d", sizes[k]);
  std::printf(", %d rows %17s forward %22s with backward\n", rows, "", "");
  for (const Isa isa : kIsas) {
    if (!machine_has(isa)) continue;
    const std::string label = std::string("ours, ") + name(isa);
    print_row(label.c_str(), time_ours(sizes, rows, repeats, isa), sizes, rows);
  }
  if (machine_has(Isa::v3)) {
    const bool has_v4 = machine_has(Isa::v4);
    const auto time_eigen = has_v4 ? v4::time_eigen : v3::time_eigen;
    print_row(has_v4 ? "Eigen, v4" : "Eigen, v3", time_eigen(sizes, rows, repeats, false), sizes,
              rows);
    print_row("Eigen, products alone", time_eigen(sizes, rows, repeats, true), sizes, rows);
  }
}

/// 32 sequences of 32 steps.
void time_recurrent(int inputs, int units, int outputs) {
  constexpr int kSequences = 32, kSteps = 32, kRows = kSequences * kSteps;
  const Isa isa = best_isa();
  const learn::RecurrentNetwork network({inputs, units, {units}, outputs, Activation::kTanh}, isa);
  std::vector<float> parameters(network.parameter_count()), gradient(parameters.size());
  network.initialize(parameters, 1.0, 1, 2);
  learn::TransposedRecurrent transposed;
  network.transpose(parameters, transposed);
  learn::RecurrentActivations memory;
  std::vector<float> x(static_cast<std::size_t>(kRows * inputs));
  std::vector<float> y(static_cast<std::size_t>(kRows * outputs));
  std::vector<float> states(static_cast<std::size_t>(kSequences * network.state_stride()));
  learn::draw_normals({}, x, isa);
  const auto forward = [&] {
    network.forward(parameters, x.data(), inputs, {kSequences, kSteps}, nullptr, states.data(),
                    memory, y.data(), outputs);
  };
  const double forwards = quickest(50, forward);
  const double both = quickest(50, [&] {
    forward();
    network.backward(transposed, x.data(), inputs, nullptr, memory, y.data(), outputs, gradient);
  });
  std::printf(
      "%d-GRU %d-%d-%d, 32 sequences of 32 steps (%s): forward %.1f ns, with backward %.1f\n",
      inputs, units, units, outputs, name(isa), 1e9 * forwards / kRows, 1e9 * both / kRows);
}

void time_the_rest() {
  const Isa isa = best_isa();
  std::vector<float> values(1 << 16);
  const double noise = quickest(50, [&] { learn::draw_normals({}, values, isa); });
  learn::Adam adam(values.size(), 0.5, isa);
  std::fill(adam.gradient().begin(), adam.gradient().end(), 1e-3f);
  const double step = quickest(50, [&] { adam.step(values, 1e-3); });
  std::printf("noise %.2f ns a normal, Adam %.2f ns a parameter (%s)\n",
              1e9 * noise / static_cast<double>(values.size()),
              1e9 * step / static_cast<double>(values.size()), name(isa));
}

}  // namespace
}  // namespace skybody::bench

int main(int argc, char** argv) {
  const int rows = argc > 1 ? std::atoi(argv[1]) : 1024;
  if (rows < 1) {
    std::fprintf(stderr, "bench_learn: ROWS is %s; allowed: >= 1\n", argv[1]);
    return 2;
  }
  skybody::bench::compare({22, 64, 64, 4}, rows, 200);
  skybody::bench::compare({700, 512, 512, 4}, rows, 12);
  skybody::bench::time_recurrent(22, 64, 4);
  skybody::bench::time_the_rest();
  return 0;
}
