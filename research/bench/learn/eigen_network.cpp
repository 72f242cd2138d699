#include "research/bench/learn/eigen_network.h"

#include <Eigen/Dense>
#include <algorithm>
#include <chrono>

namespace skybody::bench::SKYBODY_KERNEL_SET {
namespace {

using Matrix = Eigen::MatrixXf;  // a column is a row of the batch: fastest for Eigen
using Clock = std::chrono::steady_clock;

struct Layer {
  Matrix weight, gradient, output, slope;
  Eigen::VectorXf bias, bias_gradient;
};

class EigenNetwork {
 public:
  EigenNetwork(const std::vector<int>& sizes, int rows, bool bare)
      : bare_(bare), x_(Matrix::Random(sizes[0], rows)) {
    for (std::size_t k = 0; k + 1 < sizes.size(); ++k) {
      const int in = sizes[k], out = sizes[k + 1];
      const Matrix zero = Matrix::Zero(out, rows);
      layers_.push_back({Matrix::Random(out, in) * 0.05f, Matrix::Zero(out, in), zero, zero,
                         Eigen::VectorXf::Zero(out), Eigen::VectorXf::Zero(out)});
    }
  }

  void forward() {
    const Matrix* input = &x_;
    for (Layer& layer : layers_) {
      layer.output.noalias() = layer.weight * *input;
      if (!bare_) {
        layer.output.colwise() += layer.bias;
        if (&layer != &layers_.back()) layer.output = layer.output.array().tanh();
      }
      input = &layer.output;
    }
  }

  void backward() {
    layers_.back().slope = layers_.back().output * 1e-3f;
    for (std::size_t k = layers_.size(); k-- > 0;) {
      Layer& layer = layers_[k];
      layer.gradient.noalias() += layer.slope * (k > 0 ? layers_[k - 1].output : x_).transpose();
      if (!bare_) layer.bias_gradient += layer.slope.rowwise().sum();
      if (k == 0) return;
      Layer& before = layers_[k - 1];
      before.slope.noalias() = layer.weight.transpose() * layer.slope;
      if (!bare_) before.slope.array() *= 1.0f - before.output.array().square();
    }
  }

 private:
  bool bare_;
  Matrix x_;
  std::vector<Layer> layers_;
};

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

}  // namespace

NetworkTimes time_eigen(const std::vector<int>& sizes, int rows, int repeats, bool bare) {
  EigenNetwork network(sizes, rows, bare);
  return {quickest(repeats, [&] { network.forward(); }), quickest(repeats, [&] {
            network.forward();
            network.backward();
          })};
}

}  // namespace skybody::bench::SKYBODY_KERNEL_SET
