// Pictures as people have them: curves, exposures, saturation, highlights, and the noise found in them.
#include "fit/target_picture.h"
#include "fit/noise_estimate.h"
#include "fit/transfer_curve.h"
#include "render/srgb.h"
#include "tests/support/fit_job_fixture.h"

#include <random>

namespace opaline {
namespace {

using ::testing::HasSubstr;

TEST(TransferCurve, InvertsWhatEncodes) {
  for (const double linear : {0.0, 0.001, 0.02, 0.2, 0.7, 1.0}) {
    EXPECT_NEAR(TransferCurve::parse("srgb").to_linear(srgb_from_linear(linear)), linear, 1e-7);
    EXPECT_NEAR(TransferCurve::parse("gamma:2.2").to_linear(std::pow(linear, 1 / 2.2)), linear, 1e-12);
    const double rec709 = linear < 0.018 ? 4.5 * linear : 1.099 * std::pow(linear, 0.45) - 0.099;
    EXPECT_NEAR(TransferCurve::parse("rec709").to_linear(rec709), linear, 2e-4);  // the standard's digits don't meet
    EXPECT_EQ(TransferCurve().to_linear(linear), linear);
  }
  EXPECT_NEAR(TransferCurve::parse("srgb").to_linear(-0.5), -linear_from_srgb(0.5), 1e-12);
}

TEST(TransferCurve, ReadsATable) {
  const test::TempFolder folder;
  const TransferCurve curve = TransferCurve::parse(folder.write("curve.csv", "encoded,linear\n0,0\n0.5,0.1\n1,1\n"));
  EXPECT_DOUBLE_EQ(curve.to_linear(0.25), 0.05);
  EXPECT_DOUBLE_EQ(curve.to_linear(0.75), 0.55);
  EXPECT_EQ(curve.to_linear(2), 1);
  EXPECT_THAT(test::message_of([&] { TransferCurve::parse(folder.write("bad.csv", "0,0\n1,1\n0.5,2\n")); }),
              HasSubstr("line 3"));
  EXPECT_THAT(test::message_of([] { TransferCurve::parse("log"); }), HasSubstr("srgb, rec709, gamma:G"));
}

/// A ramp from .2 to 1 with read and shot noise of each channel, half of the green noise shared with red.
Image noisy_ramp(double read, double shot, unsigned seed) {
  Image image(160, 120, {"R", "G", "B"});
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) {
      const double signal = 0.2 + 0.8 * x / image.width, red = normal(random);
      for (int c = 0; c < 3; ++c) {
        const double own = normal(random), unit = c == 0 ? red : c == 1 ? 0.5 * red + std::sqrt(0.75) * own : own;
        const double level = signal / (c + 1);
        image.at(x, y, c) = static_cast<float>(level + std::sqrt(read * read + shot * level) * unit);
      }
    }
  return image;
}

void expect_noise(const NoiseModel& noise, double read, double shot, double tolerance) {
  EXPECT_TRUE(noise.known);
  for (int c = 0; c < 3; ++c)
    for (const double signal : {0.3, 0.6, 1.0})
      EXPECT_NEAR(noise.variance(c, signal / (c + 1)) / (read * read + shot * signal / (c + 1)), 1, tolerance)
          << c << " " << signal;
}

TEST(NoiseEstimate, FindsReadAndShotNoise) {
  const Image a = noisy_ramp(0.01, 0.0004, 1), b = noisy_ramp(0.01, 0.0004, 2);
  // 600 pixels a class, medians: 9 % per class; a line through 32 classes: about 3 %.
  const NoiseModel pair = noise_from_repeat(a, b, {}), flat = noise_from_flat(a, {});
  expect_noise(pair, 0.01, 0.0004, 0.12);
  expect_noise(flat, 0.01, 0.0004, 0.15);
  for (const NoiseModel* noise : {&pair, &flat}) {
    EXPECT_NEAR(noise->correlation(0, 1), 0.5, 0.04);
    EXPECT_NEAR(noise->correlation(0, 2), 0, 0.04);
  }
}

TEST(NoiseEstimate, ReadsARenderersVariance) {
  const Image picture = noisy_ramp(0.01, 0.0004, 3);
  Image variance(picture.width, picture.height, {"R", "G", "B"});
  for (std::size_t i = 0; i < variance.data.size(); ++i)
    variance.data[i] = static_cast<float>(1e-4 + 4e-4 * std::max(0.0, static_cast<double>(picture.data[i])));
  const NoiseModel noise = noise_from_layer(picture, with_layers(picture, {{"variance", variance}}), {});
  expect_noise(noise, 0.01, 0.0004, 0.02);
  EXPECT_TRUE(noise.correlation_known);
  EXPECT_EQ(noise.correlation, Eigen::Matrix3d::Identity());
  EXPECT_TRUE(noise.rough);
  EXPECT_THAT(test::message_of([&] { noise_from_layer(picture, picture, {}); }), HasSubstr("variance.R"));
  // Beside the object there is neither light nor noise.
  Image beside = picture;
  const std::size_t half = variance.data.size() / 6 * 3;
  std::fill_n(variance.data.begin(), half, 0.0f);
  std::fill_n(beside.data.begin(), half / 3 * beside.channels.size(), 0.0f);
  const Image seen = with_layers(beside, {{"variance", variance}});
  expect_noise(noise_from_layer(beside, seen, {}), 0.01, 0.0004, 0.02);
  std::fill(variance.data.begin(), variance.data.end(), 0.0f);
  const Image none = with_layers(beside, {{"variance", variance}});
  EXPECT_THAT(test::message_of([&] { noise_from_layer(beside, none, {}); }), HasSubstr("0 everywhere"));
}

TEST(NoiseEstimate, FindsARenderersNoiseThatGrowsWithTheSignal) {
  Image picture(100, 30, {"R", "G", "B"}), variance = picture;
  for (std::size_t i = 0; i < picture.data.size(); ++i) {
    const double s = 0.5 * static_cast<double>(i + 1) / static_cast<double>(picture.data.size());
    picture.data[i] = static_cast<float>(s);
    variance.data[i] = static_cast<float>(4e-10 + 1e-5 * s + 9e-4 * s * s);
  }
  const NoiseModel noise = noise_from_layer(picture, with_layers(picture, {{"variance", variance}}), {});
  for (const double s : {1e-3, 0.01, 0.1, 0.4})
    EXPECT_NEAR(noise.variance(1, s) / (4e-10 + 1e-5 * s + 9e-4 * s * s), 1, 0.02) << s;
  EXPECT_NEAR(noise.relative[1], 0.03, 0.001);
}

TEST(NoiseEstimate, ReadsNumbers) {
  EXPECT_FALSE(parse_noise("uniform").known);
  EXPECT_EQ(parse_noise("0.02,0.003").shot[1], 0.003);
  EXPECT_EQ(parse_noise("0.02").read_sd[2], 0.02);
  for (const char* text : {"-1", "0", "loud", "0.1,x"})
    EXPECT_THAT(test::message_of([&] { parse_noise(text); }), HasSubstr("READ,SHOT")) << text;
}

class TargetPictures : public test::FitJobTest {
 protected:
  Scene scene() const { return load_scene(job_.scenes[0], synthetic_shapes()); }
};

TEST_F(TargetPictures, APngNeedsItsCurveAndLosesSaturatedPixels) {
  const std::string path = folder_.file("photo.png");
  const double exposure = 1.5 * auto_exposure(picture_);
  write_png(path, picture_, exposure);
  EXPECT_THAT(test::message_of([&] { read_target(path, scene(), {}); }), HasSubstr("--transfer linear, srgb"));
  TargetOptions options;
  options.transfer = "srgb", options.exposure = exposure;
  const TargetPicture read = read_target(path, scene(), options);
  std::size_t full = 0;
  for (std::size_t p = 0; p < picture_.pixel_count(); ++p) {
    bool over = false;
    for (std::size_t c = 0; c < 3; ++c) {
      const double value = static_cast<double>(picture_.data[4 * p + c]) * exposure;
      over |= value > 0.998;
      // Eight bits: half a step of 1/255 times the curve's slope of at most 2.3.
      if (!(value > 0 && value < 1)) continue;
      EXPECT_NEAR(static_cast<double>(read.linear.data[3 * p + c]) * exposure, value, 0.0046);
    }
    full += over;
    EXPECT_EQ(read.usable[p] > 0, !over);
  }
  EXPECT_GT(full, 3u);
  EXPECT_EQ(read.saturated, full);
}

TEST_F(TargetPictures, HighlightsAreWhereTheMirrorShowsALight) {
  Scene s = scene();
  s.lights = {DirectionalLight{glm::normalize(glm::dvec3(0, 0, -1)), Rgb(1), 0}};  // from the camera
  const std::vector<float> away = away_from_highlights(s, 40);
  const RayScene rays(s);
  std::size_t left_out = 0;
  for (const VisiblePoint& p : make_gbuffer(s, rays).points) {
    // The mirror direction leaves the view by twice the angle to the normal; the light is nearly the view.
    const double angle = glm::degrees(2 * std::acos(std::min(1.0, static_cast<double>(p.cos_o))));
    if (angle < 34 || angle > 46) {
      EXPECT_EQ(away[p.pixel], angle < 34 ? 0 : 1);
    }
    left_out += away[p.pixel] == 0;
  }
  EXPECT_GT(left_out, 5u);
}

TEST_F(TargetPictures, TwoCapturesAreAveragedAndTellTheirNoise) {
  Image second = picture(test::sphere_document());
  const std::array<double, 3> sd = add_noise(second, 0.02, 77);
  write_exr(folder_.file("second.exr"), second);
  TargetOptions options;
  options.repeat = folder_.file("second.exr");
  Image mask(picture_.width, picture_.height, {"Y"});
  for (std::size_t p = 0; p < mask.data.size(); ++p) mask.data[p] = picture_.data[4 * p + 3];
  options.mask = image_file("object.exr", mask);
  const TargetPicture read = read_target(job_.targets[0], scene(), options);
  EXPECT_TRUE(read.noise.known);
  // The captures differ by that noise alone: each has its root half, their mean half. Medians of some 80 pixels: 25 %.
  for (int c = 0; c < 3; ++c) {
    double mean = 0, count = 0;
    for (std::size_t p = 0; p < picture_.pixel_count(); ++p)
      if (picture_.data[4 * p + 3] > 0)
        mean += static_cast<double>(picture_.data[4 * p + static_cast<std::size_t>(c)]), ++count;
    EXPECT_NEAR(std::sqrt(read.noise.variance(c, mean / count)) / (sd[static_cast<std::size_t>(c)] / 2), 1, 0.6);
  }
  EXPECT_FLOAT_EQ(read.linear.data[300], 0.5f * (picture_.data[400] + second.data[400]));
}

TEST_F(TargetPictures, AJobReadsExposuresOfOneSceneAsOneFit) {
  Image bright = picture_;
  for (std::size_t i = 0; i < bright.data.size(); ++i)
    if (i % 4 != 3) bright.data[i] *= 4;
  const FitReport one = run(job_);
  job_.targets.push_back(image_file("bright.exr", bright));
  job_.exposures = {1, 4};
  job_.reading.saturation = 3 * auto_exposure(picture_);
  const FitReport two = run(job_);
  ASSERT_EQ(two.targets.size(), 2u);
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(two.material.sigma_a[c] / one.material.sigma_a[c], 1, 0.05);
}

TEST_F(TargetPictures, AFreeScaleIsFoundAndCostsCertainty) {
  Image dim = picture_;
  for (std::size_t i = 0; i < dim.data.size(); ++i)
    if (i % 4 != 3) dim.data[i] *= 0.37f;
  job_.solve.free = parse_free("sigma_a,sigma_s_prime");
  job_.model = "standard_dipole";
  const FitReport known = run(job_);
  job_.targets = {image_file("dim.exr", dim)};
  job_.scale_free = true;
  const FitReport free = run(job_);
  EXPECT_NEAR(free.targets[0].scale, 0.37, 4 * 0.37 * free.uncertainty.scale_sd[0]);
  EXPECT_EQ(free.uncertainty.correlation.rows(), 8);
  EXPECT_EQ(fit_json(free)["correlation_order"][7], "ln scale[1]");
  for (std::size_t i = 0; i < eta_index; ++i)
    EXPECT_GE(free.uncertainty.covariance(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(i)) * 1.02,
              known.uncertainty.covariance(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(i)));
}

}  // namespace
}  // namespace opaline
