#include "validate/metrics/comparison.h"

#include "tests/render/scene_fixture.h"
#include "validate/metrics/metric.h"

#include <gmock/gmock.h>

#include <cmath>
#include <limits>
#include <random>

namespace opaline {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

double value(const std::string& metric, const Comparison& c) { return find_metric(metric, "test").evaluate(c); }

/// Uniform noise in [lo, hi), A = 1.
Image random_image(int width, int height, unsigned seed, float lo = 0, float hi = 1) {
  Image image(width, height, {"R", "G", "B", "A"});
  std::mt19937 engine(seed);
  std::uniform_real_distribution<float> noise(lo, hi);
  for (std::size_t i = 0; i < image.data.size(); ++i) image.data[i] = i % 4 == 3 ? 1.0f : noise(engine);
  return image;
}

TEST(CompareImages, OfAnImageToItselfIsZero) {
  const Image image = random_image(7, 5, 1);
  const Comparison d = compare_images(image, image);
  EXPECT_EQ(value("rmse", d), 0);
  EXPECT_EQ(value("relative_rmse", d), 0);
  EXPECT_EQ(value("mean_error", d), 0);
  EXPECT_EQ(value("max", d), 0);
  EXPECT_EQ(d.pixels.size(), 35u);
  EXPECT_EQ(d.pixels_left_out, 0u);
}

TEST(CompareImages, KnowsTheSignAndTheChannelOfAnOffset) {
  Image reference(4, 4, {"R", "G", "B"});
  std::fill(reference.data.begin(), reference.data.end(), 2.0f);
  Image image = reference;
  for (std::size_t p = 0; p < 16; ++p) image.data[3 * p + 1] -= 0.5f;  // G
  const Comparison d = compare_images(image, reference);
  ASSERT_THAT(d.channels, ElementsAre("R", "G", "B"));
  EXPECT_DOUBLE_EQ(value("rmse", d.channel(0)), 0);
  EXPECT_DOUBLE_EQ(value("rmse", d.channel(1)), 0.5);
  EXPECT_DOUBLE_EQ(value("mean_error", d.channel(1)), -0.5);
  EXPECT_DOUBLE_EQ(value("relative_rmse", d.channel(1)), 0.25);
  EXPECT_DOUBLE_EQ(value("rmse", d), 0.5 / std::sqrt(3.0));
  EXPECT_DOUBLE_EQ(value("mean_error", d), -0.5 / 3);
  EXPECT_DOUBLE_EQ(value("max", d), 0.5);
}

TEST(CompareImages, AgreesWithPlainSums) {
  const Image image = random_image(23, 11, 2), reference = random_image(23, 11, 3, -1, 2);
  double error = 0, squares = 0, reference_squares = 0, most = 0;
  int count = 0;
  for (int y = 0; y < 11; ++y)
    for (int x = 0; x < 23; ++x)
      for (int c = 0; c < 3; ++c, ++count) {
        const double r = static_cast<double>(reference.at(x, y, c)), d = static_cast<double>(image.at(x, y, c)) - r;
        error += d;
        squares += d * d;
        reference_squares += r * r;
        most = std::max(most, std::abs(d));
      }
  const Comparison m = compare_images(image, reference);
  EXPECT_NEAR(value("rmse", m), std::sqrt(squares / count), 1e-12);
  EXPECT_NEAR(value("relative_rmse", m), std::sqrt(squares / reference_squares), 1e-12);
  EXPECT_NEAR(value("mean_error", m), error / count, 1e-12);
  EXPECT_EQ(value("max", m), most);
}

TEST(CompareImages, CountsOnlyPixelsTheReferenceCovers) {
  Image reference = random_image(4, 2, 4);
  Image image = reference;
  reference.at(1, 0, 3) = 0;  // covered by the image alone
  image.at(1, 0, 0) += 100;
  image.at(2, 1, 3) = 0;  // covered by the reference alone
  const Comparison d = compare_images(image, reference);
  EXPECT_EQ(value("max", d), 0);
  EXPECT_EQ(d.pixels.size(), 7u);
  EXPECT_EQ(d.pixels_left_out, 1u);
  EXPECT_EQ(d.coverage_mismatches, 2u);
}

TEST(CompareImages, CountsOnlyPixelsOfTheMaskWhichMayHideBrokenOnes) {
  const Image reference = random_image(4, 2, 5);
  Image image = reference, mask(4, 2, {"Y"});
  image.at(0, 0, 1) = std::numeric_limits<float>::quiet_NaN();
  image.at(3, 1, 2) += 1;
  mask.at(3, 1, 0) = 0.2f;
  mask.at(2, 1, 0) = 1;
  const Comparison d = compare_images(image, reference, &mask);
  EXPECT_EQ(d.pixels.size(), 2u);
  EXPECT_NEAR(value("rmse", d), 1 / std::sqrt(6.0), 1e-6);
}

TEST(CompareImages, IsRelativeToTheReferenceAlone) {
  Image black(2, 2, {"R", "G", "B"}), grey = black;
  std::fill(grey.data.begin(), grey.data.end(), 3.0f);
  EXPECT_EQ(value("relative_rmse", compare_images(black, black)), 0);
  EXPECT_TRUE(std::isinf(value("relative_rmse", compare_images(grey, black))));
  EXPECT_DOUBLE_EQ(value("relative_rmse", compare_images(black, grey)), 1);
}

TEST(CompareImages, ComparesTheReferencesChannelsByName) {
  Image reference(2, 1, {"B", "G", "R"}), image(2, 1, {"R", "G", "B", "A", "Z"});
  image.at(0, 0, 0) = reference.at(0, 0, 2) = 5;
  EXPECT_EQ(value("max", compare_images(image, reference)), 0);
  Image grey(2, 1, {"Y", "A"});
  grey.at(0, 0, 1) = 1;
  EXPECT_THAT(compare_images(grey, grey).channels, ElementsAre("Y"));
  EXPECT_THAT(test::message_of([&] { compare_images(image, grey); }), HasSubstr("no channel Y"));
}

TEST(CompareImages, NamesTheFirstPixelThatIsNotFinite) {
  const Image good = random_image(5, 4, 6);
  Image bad = good;
  bad.at(4, 3, 0) = std::numeric_limits<float>::infinity();
  bad.at(2, 1, 2) = std::numeric_limits<float>::quiet_NaN();
  EXPECT_THAT(test::message_of([&] { compare_images(bad, good); }), HasSubstr("image: pixel (2, 1): channel B is nan"));
  EXPECT_THAT(test::message_of([&] { compare_images(good, bad); }), HasSubstr("reference: pixel (2, 1)"));
}

TEST(CompareImages, NamesBothSizes) {
  const std::string message = test::message_of([] { compare_images(random_image(4, 3, 1), random_image(3, 4, 1)); });
  EXPECT_THAT(message, HasSubstr("4 x 3"));
  EXPECT_THAT(message, HasSubstr("3 x 4"));
}

TEST(CompareImages, RefusesToCompareNothing) {
  const Image nothing(3, 3, {"R", "G", "B", "A"});
  EXPECT_THAT(test::message_of([&] { compare_images(nothing, nothing); }), HasSubstr("no pixel to compare"));
}

TEST(DifferenceImage, AddsUpToTheImage) {
  Image reference = random_image(6, 5, 7);
  const Image image = random_image(6, 5, 8);
  reference.at(2, 2, 3) = 0;
  const Image difference = difference_image(compare_images(image, reference));
  ASSERT_THAT(difference.channels, ElementsAre("R", "G", "B", "A"));
  for (int c = 0; c < 3; ++c) {
    EXPECT_FLOAT_EQ(reference.at(1, 4, c) + difference.at(1, 4, c), image.at(1, 4, c));
    EXPECT_EQ(difference.at(2, 2, c), 0);
  }
  EXPECT_EQ(difference.at(1, 4, 3), 1);
  EXPECT_EQ(difference.at(2, 2, 3), 0);
}

}  // namespace
}  // namespace opaline
