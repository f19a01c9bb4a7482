#include "fit/noise_estimate.h"

#include "render/input_error.h"

#include <fmt/format.h>
#include <Eigen/QR>

#include <algorithm>
#include <cmath>
#include <sstream>

namespace opaline {
namespace {

using Terms = Eigen::Array3d;  ///< coefficients of 1, signal, signal^2

/// One pixel's estimate: `square` has the noise's variance as its mean.
struct Sample {
  double signal, square;
};

/// Median of a squared standard normal.
constexpr double median_of_square = 0.454936423119573;

/// Means over a class.
struct Class {
  double signal = 0, square = 0, variance = 0;
  double of(const Terms& terms) const { return terms[0] + terms[1] * signal + terms[2] * square; }
};

/// Samples of equal number in order of brightness; the variance of each from the median, or the mean where the squares
/// are estimates already.
std::vector<Class> classes(std::vector<Sample> samples, bool squares_of_normals) {
  std::sort(samples.begin(), samples.end(), [](const Sample& a, const Sample& b) { return a.signal < b.signal; });
  const std::size_t count = std::clamp<std::size_t>(samples.size() / 50, 1, 32);
  std::vector<Class> out;
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t first = samples.size() * i / count, last = samples.size() * (i + 1) / count;
    Class c;
    std::vector<double> squares;
    for (std::size_t k = first; k < last; ++k) {
      const double signal = std::max(samples[k].signal, 0.0), share = 1 / static_cast<double>(last - first);
      c.signal += share * signal, c.square += share * signal * signal;
      c.variance += share * samples[k].square;
      squares.push_back(samples[k].square);
    }
    if (squares.empty()) continue;
    if (squares_of_normals) {
      const auto middle = squares.begin() + static_cast<std::ptrdiff_t>(squares.size() / 2);
      std::nth_element(squares.begin(), middle, squares.end());
      c.variance = *middle / median_of_square;
    }
    out.push_back(c);
  }
  return out;
}

/// The non-negative coefficients of the allowed terms that fit best with these weights: the best of all subsets.
Terms best_terms(const Eigen::MatrixXd& rows, const Eigen::VectorXd& values, int allowed) {
  Terms best = Terms::Zero();
  double least = values.squaredNorm();
  for (unsigned subset = 1; subset < 1u << allowed; ++subset) {
    std::vector<Eigen::Index> of;
    for (Eigen::Index i = 0; i < allowed; ++i)
      if (subset >> i & 1u) of.push_back(i);
    const Eigen::MatrixXd some = rows(Eigen::all, of);
    const Eigen::VectorXd x = some.colPivHouseholderQr().solve(values);
    const double left = (some * x - values).squaredNorm();
    if (x.minCoeff() < 0 || !(left < least)) continue;
    least = left, best = Terms::Zero();
    for (std::size_t k = 0; k < of.size(); ++k) best[of[k]] = x[static_cast<Eigen::Index>(k)];
  }
  return best;
}

/// variance = sum of the first `allowed` terms by least squares, weights by the variance itself.
Terms fit_terms(const std::vector<Class>& all, int allowed) {
  const auto n = static_cast<Eigen::Index>(all.size());
  double mean = 0;
  for (const Class& c : all) mean += c.variance / static_cast<double>(all.size());
  if (!(mean > 0)) return Terms::Zero();
  const double least = 1e-6 * mean;  // classes without any noise must not take all the weight
  Terms terms(mean, 0, 0);
  Eigen::VectorXd expected = Eigen::VectorXd::Constant(n, mean);
  for (int round = 0; round < 6; ++round) {
    Eigen::MatrixXd rows(n, 3);
    Eigen::VectorXd values(n);
    for (Eigen::Index i = 0; i < n; ++i) {
      const Class& c = all[static_cast<std::size_t>(i)];
      rows.row(i) = Eigen::RowVector3d(1, c.signal, c.square) / expected[i];
      values[i] = c.variance / expected[i];
    }
    terms = best_terms(rows, values, allowed);
    for (Eigen::Index i = 0; i < n; ++i) expected[i] = std::max(all[static_cast<std::size_t>(i)].of(terms), least);
  }
  return terms;
}

std::vector<int> colours(const Image& image) {
  if (image.channel("R") < 0) return {0};
  return {image.channel("R"), image.channel("G"), image.channel("B")};
}

double value(const Image& image, std::size_t pixel, int channel) {
  return static_cast<double>(image.data[pixel * image.channels.size() + static_cast<std::size_t>(channel)]);
}

bool counts(const std::vector<float>& usable, std::size_t pixel) { return usable.empty() || usable[pixel] > 0; }

NoiseModel model_of(const std::vector<std::vector<Sample>>& samples, bool squares_of_normals, const char* source) {
  NoiseModel noise;
  noise.known = true;
  noise.source = source;
  for (std::size_t c = 0; c < 3; ++c) {
    const std::vector<Sample>& own = samples[std::min(c, samples.size() - 1)];
    const Terms terms = fit_terms(classes(own, squares_of_normals), squares_of_normals ? 2 : 3);
    noise.read_sd[c] = std::sqrt(terms[0]), noise.shot[c] = terms[1], noise.relative[c] = std::sqrt(terms[2]);
  }
  return noise;
}

/// Correlation of deviations in units of their sd, cut at 3.
Eigen::Matrix3d correlation(const std::vector<std::array<double, 3>>& deviations) {
  Eigen::Matrix3d sums = 1e-12 * Eigen::Matrix3d::Identity();
  for (const auto& d : deviations) {
    const Eigen::Vector3d cut(std::clamp(d[0], -3.0, 3.0), std::clamp(d[1], -3.0, 3.0), std::clamp(d[2], -3.0, 3.0));
    sums += cut * cut.transpose();
  }
  const Eigen::Vector3d per_sd = sums.diagonal().cwiseSqrt().cwiseInverse();
  return regular_covariance(per_sd.asDiagonal() * sums * per_sd.asDiagonal());
}

/// deviation(pixel, channel) of unit-variance noise where `use` says so: sizes and correlations.
template <typename Use, typename Signal, typename Deviation>
NoiseModel from_deviations(const Image& picture, const Use& use, const Signal& signal, const Deviation& deviation,
                           const char* source) {
  const std::vector<int> channels = colours(picture);
  std::vector<std::vector<Sample>> samples(channels.size());
  std::vector<std::size_t> pixels;
  for (std::size_t p = 0; p < picture.pixel_count(); ++p) {
    if (!use(p)) continue;
    pixels.push_back(p);
    for (std::size_t c = 0; c < channels.size(); ++c) {
      const double d = deviation(p, channels[c]);
      samples[c].push_back({signal(p, channels[c]), d * d});
    }
  }
  NoiseModel noise = model_of(samples, true, source);
  std::vector<std::array<double, 3>> scaled(pixels.size());
  for (std::size_t i = 0; i < pixels.size(); ++i)
    for (std::size_t c = 0; c < channels.size(); ++c)
      scaled[i][c] = deviation(pixels[i], channels[c]) /
                     std::sqrt(std::max(noise.variance(static_cast<int>(c), signal(pixels[i], channels[c])), 1e-300));
  if (channels.size() == 3 && !pixels.empty()) noise.correlation = correlation(scaled);
  return noise;
}

}  // namespace

NoiseModel noise_from_repeat(const Image& a, const Image& b, const std::vector<float>& usable) {
  return from_deviations(
      a, [&](std::size_t p) { return counts(usable, p); },
      [&](std::size_t p, int c) { return 0.5 * (value(a, p, c) + value(b, p, c)); },
      [&](std::size_t p, int c) { return (value(a, p, c) - value(b, p, c)) / std::sqrt(2.0); }, "two captures");
}

NoiseModel noise_from_flat(const Image& picture, const std::vector<float>& usable) {
  const auto w = static_cast<std::size_t>(picture.width), h = static_cast<std::size_t>(picture.height);
  const auto around = [&](std::size_t p, const auto& body) {
    for (int dy = -1; dy <= 1; ++dy)
      for (int dx = -1; dx <= 1; ++dx)
        body(p + static_cast<std::size_t>(dx) + static_cast<std::size_t>(dy) * w,  // wraps back
             static_cast<double>((dx == 0 ? -2 : 1) * (dy == 0 ? -2 : 1)));
  };
  const auto use = [&](std::size_t p) {
    const std::size_t x = p % w, y = p / w;
    if (x == 0 || y == 0 || x + 1 >= w || y + 1 >= h) return false;
    bool all = true;
    around(p, [&](std::size_t q, double) { all &= counts(usable, q); });
    return all;
  };
  const auto mean = [&](std::size_t p, int c) {
    double sum = 0;
    around(p, [&](std::size_t q, double) { sum += value(picture, q, c) / 9; });
    return sum;
  };
  const auto deviation = [&](std::size_t p, int c) {
    double sum = 0;
    around(p, [&](std::size_t q, double weight) { sum += weight * value(picture, q, c) / 6; });
    return sum;
  };
  return from_deviations(picture, use, mean, deviation, "flat regions of the picture");
}

NoiseModel noise_from_layer(const Image& picture, const Image& layers, const std::vector<float>& usable) {
  const std::vector<int> channels = colours(picture);
  std::vector<std::vector<Sample>> samples(channels.size());
  for (std::size_t c = 0; c < channels.size(); ++c) {
    const int layer = layers.channel(std::string("variance.") + "RGB"[c]);
    if (layer < 0)
      throw InputError("--noise", "", "'layer' needs the channels variance.R, variance.G, variance.B in the picture");
    for (std::size_t p = 0; p < picture.pixel_count(); ++p)
      // Where nothing was seen there is nothing to learn from: beside the object, or where no path found light.
      if (counts(usable, p) && value(layers, p, layer) > 0)
        samples[c].push_back({value(picture, p, channels[c]), value(layers, p, layer)});
  }
  if (samples[0].empty()) throw InputError("--noise", "", "'layer': the picture's variance is 0 everywhere");
  NoiseModel noise = model_of(samples, false, "the renderer's variance");
  noise.rough = true;
  return noise;
}

NoiseModel parse_noise(const std::string& text) {
  NoiseModel noise;
  noise.correlation_known = text != "shared";
  if (text == "uniform" || text == "shared") return noise;
  std::string numbers = text;
  std::replace(numbers.begin(), numbers.end(), ',', ' ');
  std::istringstream in(numbers);
  double read = 0, shot = 0;
  const bool good = static_cast<bool>(in >> read) && (in.eof() || static_cast<bool>(in >> shot)) && in.eof();
  if (!good || read < 0 || shot < 0 || !(read + shot > 0))
    throw InputError(
        "--noise", "",
        "'" + text + "' is not one of uniform, shared, flat, layer, READ, READ,SHOT (numbers in the picture's units)");
  noise.known = true;
  noise.read_sd.fill(read);
  noise.shot.fill(shot);
  noise.source = "the user";
  return noise;
}

}  // namespace opaline
