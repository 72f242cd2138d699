#include "app/commands/race_line.h"

#include <algorithm>

#include "core/base/math/random.h"
#include "core/base/system/error.h"

namespace skybody {
namespace {

using reference::derivative;
using reference::Spline;
using reference::SplineEnds;

constexpr int kCoarse = 24,
              kFine = 400;  // samples per piece: during the search, and for the result
constexpr double kShortest =
    1e-3;  // [m] between points; lower bound for durations in proportion to distances
constexpr double kFirstStep = 0.3;   // of logarithms of durations, and of offsets in reaches
constexpr double kLeastStep = 1e-3;  // below it the search restarts around the best line
constexpr double kGrowth = 1.22, kDecay = 0.95;  // in balance if one sample in five is better
constexpr double kFarthest = 0.7071;  // of a reach, along each of two axes: keeps within a circle
constexpr double kAtRest = 1.5;  // factor on the duration of a piece that begins or ends at rest

/// The sampled values: logarithms of the pieces' durations, then two offsets per gate, in reaches.
struct Genes {
  std::vector<double> durations, offsets;
};

class Planner {
 public:
  Planner(const RaceCourse& course, const control::FlightEnvelope& envelope)
      : course_(course), envelope_(envelope) {}

  Genes first_guess() const {
    Genes genes;
    genes.offsets.assign(2 * course_.gates.size(), 0.0);
    const std::vector<Vec3<double>> points = points_of(genes);
    for (std::size_t i = 1; i < points.size(); ++i) {
      const bool is_at_rest = i == 1 || i + 1 == points.size();
      const double way = std::max(kShortest, norm(points[i] - points[i - 1]));
      genes.durations.push_back(log(way * (is_at_rest ? kAtRest : 1.0)));
    }
    return genes;
  }

  /// The line at the fastest feasible pace; none if it takes longer than `bound`.
  /// @param samples  of each piece
  bool line(const Genes& genes, double bound, int samples, Spline& out) const {
    const Spline spline = spline_of(genes);
    const double length = spline.end() - spline.begin();
    if (bound < kInfinity && !flies(spline, length / bound, samples)) return false;
    double low = 0.0, high = bound < kInfinity ? length / bound : 1.0;
    while (high < 1e6 && flies(spline, high, samples)) {
      low = high;
      high *= 1.25;
    }
    for (int k = 0; low == 0.0 && k < 60; ++k) {
      high *= 0.5;
      if (!flies(spline, high, samples)) continue;
      low = high;
      high *= 2.0;
    }
    if (low == 0.0) return false;
    while (high - low > 1e-3 * low) {
      const double middle = 0.5 * (low + high);
      (flies(spline, middle, samples) ? low : high) = middle;
    }
    out = spline.stretched(1.0 / low);
    return true;
  }

 private:
  std::vector<Vec3<double>> points_of(const Genes& genes) const {
    std::vector<Vec3<double>> points = {course_.start};
    for (std::size_t g = 0; g < course_.gates.size(); ++g) {
      const RaceGate& gate = course_.gates[g];
      const Vec3<double> side = across(gate.direction);
      const Vec3<double> up = cross(gate.direction, side);
      points.push_back(gate.position + side * (gate.reach * genes.offsets[2 * g]) +
                       up * (gate.reach * genes.offsets[2 * g + 1]));
    }
    points.push_back(course_.finish);
    return points;
  }

  /// A horizontal unit vector perpendicular to a direction, or zero for a zero direction.
  static Vec3<double> across(const Vec3<double>& direction) {
    if (norm(direction) == 0.0) return {0.0, 0.0, 0.0};
    const Vec3<double> side{-direction.y, direction.x, 0.0};
    const double size = norm(side);
    return size > 1e-6 ? side / size : Vec3<double>{0.0, 1.0, 0.0};
  }

  Spline spline_of(const Genes& genes) const {
    const std::vector<Vec3<double>> points = points_of(genes);
    std::vector<double> times = {0.0}, values;
    for (const double duration : genes.durations) {
      times.push_back(times.back() + exp(duration));
    }
    for (const Vec3<double>& p : points) values.insert(values.end(), {p.x, p.y, p.z, 0.0});
    return Spline(times, values, SplineEnds::kRest);
  }

  bool flies(const Spline& spline, double scale, int samples_of_piece) const {
    const auto samples = samples_of_piece * static_cast<int>(spline.pieces());
    const double length = spline.end() - spline.begin();
    for (int k = 0; k <= samples; ++k) {
      const auto at = spline.at<reference::kOrders>(length / samples * k);
      ReferencePoint<double> point{};
      double power = scale;
      for (Vec3<double>* part : {&point.velocity, &point.acceleration, &point.jerk, &point.snap}) {
        const int order = part == &point.velocity       ? 1
                          : part == &point.acceleration ? 2
                          : part == &point.jerk         ? 3
                                                        : 4;
        *part = derivative(at.point, order) * power;
        power *= scale;
      }
      if (envelope_.breach(point, 0.0)) return false;
    }
    return true;
  }

  const RaceCourse& course_;
  const control::FlightEnvelope& envelope_;
};

Genes changed(const Genes& genes, double step, Random<double>& random) {
  Genes out = genes;
  for (double& duration : out.durations) duration += step * random.normal();
  for (double& offset : out.offsets) {
    offset = std::clamp(offset + step * random.normal(), -kFarthest, kFarthest);
  }
  return out;
}

double time_of(const Spline& spline) { return spline.end() - spline.begin(); }

}  // namespace

RaceLine plan_race_line(const RaceCourse& course, const control::FlightEnvelope& envelope,
                        int samples, std::uint64_t seed,
                        const std::function<bool(int, double)>& tell) {
  const Planner planner(course, envelope);
  Genes best = planner.first_guess();
  RaceLine line;
  if (!planner.line(best, kInfinity, kCoarse, line.spline)) {
    throw Error(
        "the vehicle cannot fly this course at any pace: look at its thrust, and at points "
        "that lie on one another");
  }
  line.first_time = time_of(line.spline);
  double step = kFirstStep;
  for (int k = 0; k < samples; ++k) {
    Random<double> random(RandomKey{seed, 0}, 0, static_cast<std::uint64_t>(k),
                          derive_stream("plan.race_line"));
    const Genes tried = changed(best, step, random);
    Spline spline;
    if (planner.line(tried, time_of(line.spline), kCoarse, spline)) {
      line.spline = spline;
      best = tried;
      step *= kGrowth;
    } else {
      step *= kDecay;
    }
    if (step < kLeastStep) step = kFirstStep;
    if (!tell(k + 1, time_of(line.spline))) break;
  }
  if (!planner.line(best, kInfinity, kFine, line.spline)) {
    throw Error(
        "the best line that was found cannot be flown at any pace when it is looked at closely: "
        "take another seed or more samples");
  }
  line.peak_speed = line.spline.peak_speed();
  return line;
}

}  // namespace skybody
