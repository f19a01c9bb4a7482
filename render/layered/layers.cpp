#include "render/layered/layers.h"

#include <algorithm>
#include <cmath>

namespace opaline {

Layers::Layers(double first, double quantum, std::vector<int> place)
    : first_(first), quantum_(quantum), place_(std::move(place)) {
  for (std::size_t i = 0; i + 1 < place_.size(); ++i)
    interval_of_.insert(interval_of_.end(), static_cast<std::size_t>(place_[i + 1] - place_[i]), static_cast<int>(i));
}

Layers Layers::uniform(double lo, double hi, int count) {
  if (!(hi > lo) || count < 2) return Layers(lo, 1, {0});
  std::vector<int> place;
  for (int i = 0; i < count; ++i) place.push_back(i);
  return Layers(lo, (hi - lo) / (count - 1), std::move(place));
}

Layers Layers::by_surface(double lo, double hi, int count, const std::vector<double>& density) {
  const int parts = static_cast<int>(density.size());
  int begin = 0, end = parts;
  while (begin < end && !(density[static_cast<std::size_t>(begin)] > 0)) ++begin;
  while (end > begin && !(density[static_cast<std::size_t>(end - 1)] > 0)) --end;
  if (!(hi > lo) || count < 2 || end - begin + 1 <= count) return uniform(lo, hi, count);
  std::vector<double> sum = {0};
  for (int i = begin; i < end; ++i) sum.push_back(sum.back() + std::cbrt(density[static_cast<std::size_t>(i)]));
  std::vector<int> place;
  for (int i = 0; i < count; ++i) {
    const double wanted = sum.back() * i / (count - 1);
    const auto at = static_cast<int>(std::lower_bound(sum.begin(), sum.end(), wanted) - sum.begin());
    // Every layer has a place of its own, and leaves one for each that follows.
    const int least = place.empty() ? 0 : place.back() + 1;
    place.push_back(std::clamp(at, least, end - begin - (count - 1 - i)));
  }
  const double quantum = (hi - lo) / parts;
  return Layers(lo + quantum * begin, quantum, std::move(place));
}

int Layers::separation(int a, int b) const {
  return std::abs(place_[static_cast<std::size_t>(a)] - place_[static_cast<std::size_t>(b)]);
}

double Layers::largest_gap() const {
  double largest = 0;
  for (int i = 0; i + 1 < count(); ++i) largest = std::max(largest, distance(separation(i, i + 1)));
  return largest;
}

double Layers::mean_square_gap() const {
  double sum = 0;
  for (int i = 0; i + 1 < count(); ++i) sum += std::pow(distance(separation(i, i + 1)), 2);
  return count() > 1 ? sum / (count() - 1) : 0;
}

Layers::Place Layers::place(double depth) const {
  if (count() < 2) return {0, 0};
  const double q = std::clamp((depth - first_) / quantum_, 0.0, static_cast<double>(place_.back()));
  const auto part = std::min(static_cast<std::size_t>(q), interval_of_.size() - 1);
  const int lower = interval_of_[part];
  const int at = place_[static_cast<std::size_t>(lower)], next = place_[static_cast<std::size_t>(lower + 1)];
  return {lower, static_cast<float>((q - at) / (next - at))};
}

}  // namespace opaline
