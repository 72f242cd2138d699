#include "core/model/scenario.h"

#include "core/model/gate.h"

namespace skybody {

std::vector<Shape> obstacle_shapes_of(const Obstacle& obstacle) {
  Shape shape = obstacle.shape;
  shape.pose = Pose{};
  if (!obstacle.is_gate) return {shape};
  std::vector<Shape> bars;
  for (const GateBar& bar : gate_bars(obstacle.shape.size)) {
    shape.pose.position = bar.position;
    shape.size = bar.size;
    bars.push_back(shape);
  }
  return bars;
}

}  // namespace skybody
