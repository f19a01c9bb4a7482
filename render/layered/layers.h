// The depths at which an object's layers lie, and what part a depth between two of them has in each.
#pragma once

#include <cstddef>
#include <vector>

namespace opaline {

/// Layers at whole multiples of a quantum from the first: few distances occur between them, each needs one kernel.
class Layers {
 public:
  /// Equally far apart between two depths [mm]; one layer if they are equal.
  static Layers uniform(double lo, double hi, int count);
  /// Where surface is: `density` holds the amount of surface that matters in equal parts of [lo, hi], at most 256. The
  /// spacing follows its cube root, which makes the error of linear interpolation least; the first and the last layer
  /// lie where it begins and ends.
  static Layers by_surface(double lo, double hi, int count, const std::vector<double>& density);

  int count() const { return static_cast<int>(place_.size()); }
  double depth(int layer) const { return first_ + quantum_ * place_[static_cast<std::size_t>(layer)]; }
  /// Quanta between two layers: the number of their distance.
  int separation(int a, int b) const;
  int separations() const { return place_.back() + 1; }
  double distance(int separation) const { return quantum_ * separation; }
  double largest_gap() const;
  /// Mean of the squared gaps between neighbours [mm^2].
  double mean_square_gap() const;

  /// A depth lies between `lower` and the next layer, of which it has `share`; outside all layers the nearest one.
  struct Place {
    int lower;
    float share;
  };
  Place place(double depth) const;

 private:
  Layers(double first, double quantum, std::vector<int> place);
  double first_, quantum_;
  std::vector<int> place_, interval_of_;
};

}  // namespace opaline
