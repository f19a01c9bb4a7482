// Metrics against independent values: OpenImageIO, closed forms, and the published implementation of FLIP.
#include "validate/metrics/metric.h"

#include "tests/render/scene_fixture.h"
#include "validate/metrics/flip_difference.h"

#include <OpenImageIO/imagebufalgo.h>
#include <gmock/gmock.h>

#include <cmath>
#include <limits>

namespace opaline {
namespace {

using ::testing::HasSubstr;

double value(const std::string& metric, const Comparison& c) { return find_metric(metric, "test").evaluate(c); }

/// R, G, B of a formula of (x, y, channel).
template <typename Formula>
Image picture(int width, int height, const Formula& formula) {
  Image image(width, height, {"R", "G", "B"});
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      for (int c = 0; c < 3; ++c) image.at(x, y, c) = static_cast<float>(formula(x, y, c));
  return image;
}

/// Test pairs by formula, so that any implementation can be fed the same: image, reference.
struct Pair {
  Image image, reference;
};

Pair waves() {
  const auto wave = [](double x, double y, double c) { return std::sin(0.2 * x + 0.13 * y + c); };
  return {
      picture(64, 48, [&](int x, int y, int c) { return 0.45 + 0.4 * wave(x, y, c + 0.3) + 0.05 * std::cos(1.7 * x); }),
      picture(64, 48, [&](int x, int y, int c) { return 0.5 + 0.4 * wave(x, y, c); })};
}

Pair faint() {
  Pair pair = waves();
  pair.image = pair.reference;
  for (float& v : pair.image.data) v *= 1.01f;
  return pair;
}

/// A checker board of two colours, and the same moved by a pixel.
Pair edges() {
  const auto board = [](int shift) {
    return picture(64, 48, [shift](int x, int y, int c) {
      const int m = ((x + shift) / 7 + y / 5) % 2;
      return c == 0 ? 0.1 + 0.8 * m : c == 1 ? 0.2 + 0.5 * m : 0.7 - 0.6 * m;
    });
  };
  return {board(1), board(0)};
}

/// Values from .03 to 1.5 against .02 to 2.
Pair high_range() {
  const auto hills = [](double contrast) {
    return picture(64, 48, [contrast](int x, int y, int c) {
      return 0.2 * std::exp(contrast * std::sin(0.15 * x - 0.11 * y + c));
    });
  };
  return {hills(2.3), hills(2)};
}

Comparison compared(const Pair& pair) { return compare_images(pair.image, pair.reference); }

TEST(Metrics, OfAnImageToItselfArePerfect) {
  const Pair pair = high_range();
  const Comparison c = compare_images(pair.reference, pair.reference);
  for (const Metric& metric : metrics()) {
    SCOPED_TRACE(metric.name);
    const double perfect = metric.better == Metric::Better::higher ? std::numeric_limits<double>::infinity()
                           : metric.better == Metric::Better::one  ? 1
                                                                   : 0;
    if (perfect == 1)
      EXPECT_NEAR(metric.evaluate(c), perfect, 1e-12);
    else
      EXPECT_EQ(metric.evaluate(c), perfect);
    EXPECT_FALSE(metric.formula.empty());
  }
}

TEST(Metrics, AreWorseForTheWorseImage) {
  const Comparison good = compared(faint()), bad = compared(waves());
  for (const Metric& metric : metrics()) {
    SCOPED_TRACE(metric.name);
    const auto distance = [&](const Comparison& c) {
      const double v = metric.evaluate(c);
      switch (metric.better) {
        case Metric::Better::higher:
          return -v;
        case Metric::Better::one:
          return std::abs(v - 1);
        default:
          return std::abs(v);
      }
    };
    EXPECT_LT(distance(good), distance(bad));
  }
}

TEST(Metrics, AreFiniteOrInfiniteButNeverNan) {
  const Image black = picture(9, 7, [](int, int, int) { return 0; }),
              grey = picture(9, 7, [](int, int, int) { return 1; });
  const Image negative = picture(9, 7, [](int x, int, int) { return x - 5; });
  const Image huge = picture(9, 7, [](int x, int, int) { return 1e30 * x; });
  for (const Image* image : {&black, &grey, &negative, &huge})
    for (const Image* reference : {&black, &grey, &negative, &huge})
      for (const auto& [name, v] : evaluate_metrics(compare_images(*image, *reference)))
        EXPECT_FALSE(std::isnan(v)) << name;
  EXPECT_EQ(value("psnr", compare_images(grey, black)), -std::numeric_limits<double>::infinity());
  EXPECT_EQ(value("scale_factor", compare_images(black, grey)), 1);
  EXPECT_EQ(value("scaled_residual", compare_images(black, grey)), 1);
}

TEST(Metrics, AgreeWithOpenImageIo) {
  // Its PSNR takes the largest value of both images as the peak, so that one stands in the reference here.
  Pair pair = waves();
  pair.reference.at(3, 4, 1) = 1.5f;
  const OIIO::ImageSpec spec(64, 48, 3, OIIO::TypeDesc::FLOAT);
  OIIO::ImageBuf image(spec, pair.image.data.data()), reference(spec, pair.reference.data.data());
  const OIIO::ImageBufAlgo::CompareResults theirs = OIIO::ImageBufAlgo::compare(image, reference, 1e-3f, 1e-3f);
  const Comparison c = compared(pair);
  EXPECT_NEAR(value("rmse", c), theirs.rms_error, 1e-6);
  EXPECT_NEAR(value("psnr", c), theirs.PSNR, 1e-4);
  EXPECT_NEAR(value("max", c), theirs.maxerror, 1e-6);
}

TEST(Metrics, PercentileLeavesOnePerCentAbove) {
  const Image zero = picture(20, 5, [](int, int, int) { return 0; });
  const Image ramp = picture(20, 5, [](int x, int y, int c) { return -(1 + c + 3 * (x + 20 * y)); });
  EXPECT_EQ(value("p99", compare_images(ramp, zero)), 297) << "of 1 .. 300";
}

TEST(Metrics, RelativeSquaresAndScaleAreTheirFormulas) {
  const Image reference = picture(2, 1, [](int x, int, int) { return x == 0 ? 0.5 : 2; });
  const Image image = picture(2, 1, [](int x, int, int) { return x == 0 ? 1 : 4; });
  const Comparison c = compare_images(image, reference);
  EXPECT_NEAR(value("relmse", c), (0.25 / 0.26 + 4 / 4.01) / 2, 1e-12);
  EXPECT_NEAR(value("scale_factor", c), 0.5, 1e-12);
  EXPECT_NEAR(value("scaled_residual", c), 0, 1e-12);
  EXPECT_NEAR(value("relative_rmse", c), 1, 1e-12);
  const Image tilted = picture(2, 1, [](int x, int, int) { return x == 0 ? 3 : 1; });
  // s = (1.5 + 2) / (9 + 1), residual^2 = |r|^2 - s (i r)
  EXPECT_NEAR(value("scale_factor", compare_images(tilted, reference)), 0.35, 1e-12);
  EXPECT_NEAR(value("scaled_residual", compare_images(tilted, reference)), std::sqrt((4.25 - 0.35 * 3.5) / 4.25), 1e-7);
}

// Expected: scipy's correlations with the two-dimensional window.
TEST(Ssim, AgreesWithAnIndependentComputation) {
  EXPECT_NEAR(value("ssim", compared(waves())), 0.797648, 1e-4);
  EXPECT_NEAR(value("ssim", compared(edges())), 0.688599, 1e-4);
  EXPECT_NEAR(value("ssim", compared(high_range())), 0.969780, 1e-4);
  EXPECT_NEAR(value("ssim", compared(faint())), 0.999983, 1e-5);
}

TEST(Ssim, OfConstantsIsTheLuminanceTermAlone) {
  const Image reference = picture(16, 16, [](int, int, int) { return 0.9; });
  const Image image = picture(16, 16, [](int, int, int) { return 0.0031308; });
  // As sRGB: .95469 and .04045.
  const double a = 1.055 * std::pow(0.9, 1 / 2.4) - 0.055, b = 12.92 * 0.0031308;
  EXPECT_NEAR(value("ssim", compare_images(image, reference)), (2 * a * b + 1e-4) / (a * a + b * b + 1e-4), 1e-6);
}

// Expected: what the authors' published implementation (numpy version, two-dimensional filters) gives for these pairs.
TEST(Flip, AgreesWithThePublishedImplementation) {
  struct Row {
    Pair pair;
    double ldr, ldr_at_10_20, hdr, first, last;
    int exposures;
  };
  const Row rows[] = {{waves(), 0.401591, 0.336888, 0.395205, 1.31636, 2.08410, 2},
                      {edges(), 0.222013, 0.032963, 0.157496, 1.59952, 3.30196, 2},
                      {high_range(), 0.213079, 0.262993, 0.226327, 0.78453, 2.86416, 3},
                      {faint(), 0.037775, 0.035294, 0.020200, 1.31636, 2.08410, 2}};
  for (const Row& row : rows) {
    SCOPED_TRACE(row.ldr);
    const Comparison c = compared(row.pair);
    EXPECT_NEAR(value("ldr_flip", c), row.ldr, 2e-5);
    EXPECT_NEAR(ldr_flip(c)[20 * 64 + 10], row.ldr_at_10_20, 2e-5);
    EXPECT_NEAR(value("flip", c), row.hdr, 1e-3);
    const FlipExposures e = flip_exposures(c);
    EXPECT_NEAR(e.first, row.first, 1e-4);
    // numpy's median is the mean of the middle two, here it is the upper one as in the C++ version.
    EXPECT_NEAR(e.last, row.last, 5e-3);
    EXPECT_EQ(e.count, row.exposures);
  }
}

TEST(Flip, OfConstantColoursHasNoFeatures) {
  const auto flip_of = [](glm::dvec3 image, glm::dvec3 reference) {
    const auto constant = [](glm::dvec3 v) { return picture(30, 30, [v](int, int, int c) { return v[c]; }); };
    return value("ldr_flip", compare_images(constant(image), constant(reference)));
  };
  EXPECT_NEAR(flip_of({0, 0, 1}, {0, 1, 0}), 1, 1e-6) << "the pair that is furthest apart, by definition";
  EXPECT_NEAR(flip_of({1, 1, 1}, {0, 0, 0}), 0.967380, 1e-5);
  EXPECT_NEAR(flip_of({0.4, 0.25, 0.1}, {0.5, 0.2, 0.1}), 0.289203, 1e-5);
}

TEST(Flip, TakesOneChannelAsGreyAndNoOtherSet) {
  const Pair pair = waves();
  const Comparison one = compared(pair).channel(0);
  Comparison grey = one;
  grey.channels = {"R", "G", "B"};
  grey.image.resize(3, one.image[0]);
  grey.reference.resize(3, one.reference[0]);
  EXPECT_NEAR(value("ldr_flip", one), value("ldr_flip", grey), 1e-12);
  Image two(4, 4, {"U", "V"});
  const auto values = evaluate_metrics(compare_images(two, two));
  EXPECT_EQ(values.count("flip"), 0u);
  EXPECT_EQ(values.count("rmse"), 1u);
}

TEST(Flip, LooksAtComparedPixelsAlone) {
  const Pair pair = high_range();
  Image image(64, 48, {"R", "G", "B", "A"}), reference = image;
  for (int y = 0; y < 48; ++y)
    for (int x = 0; x < 64; ++x)
      for (int c = 0; c < 4; ++c) {
        image.at(x, y, c) = c == 3 ? 1 : pair.image.at(x, y, c);
        reference.at(x, y, c) = c == 3 ? (x < 20 ? 1.0f : 0.0f) : pair.reference.at(x, y, c);
      }
  const FlipExposures before = flip_exposures(compare_images(image, reference));
  for (int y = 0; y < 48; ++y) reference.at(40, y, 1) = 1000, image.at(50, y, 2) = 77;
  const FlipExposures after = flip_exposures(compare_images(image, reference));
  EXPECT_EQ(before.first, after.first);
  EXPECT_EQ(before.last, after.last);
}

TEST(Metrics, NameTheValidOnes) {
  EXPECT_THAT(test::message_of([] { find_metric("rmsee", "--max"); }), HasSubstr("did you mean \"rmse\"?"));
}

}  // namespace
}  // namespace opaline
