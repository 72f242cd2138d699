// User code with the renderer alone: the depth of a sphere in front of a camera.
#include <cmath>
#include <cstdio>
#include <vector>

#include "core/base/simd/isa.h"
#include "render/renderer.h"

int main() {
  using namespace skybody;
  render::PlacedShape sphere;
  sphere.position = {0.0, 0.0, 5.0};
  sphere.axes = Mat3<double>::identity();
  sphere.half = {1.0, 1.0, 1.0};
  sphere.instance = 1;
  const render::Pinhole camera;
  const render::Renderer renderer(camera, 1, 100.0, render::kernels_of(best_isa()));
  std::vector<double> scratch(renderer.scratch_size());
  std::vector<float> depth(64 * 64);
  render::Frame frame;
  frame.depth = depth.data();
  const render::Eye eye{{0.0, 0.0, 0.0}, Mat3<double>::identity()};
  renderer.draw(eye, {&sphere, 1}, {}, scratch.data(), frame);
  const float center = depth[32 * 64 + 32];
  std::printf("depth of the sphere %.4f m, of nothing %.0f m\n", center, depth[0]);
  return std::abs(center - 4.0f) < 0.01f && depth[0] == 100.0f ? 0 : 1;
}
