// Pictures: means, errors, colours, and PNGs as another reader sees them.
#include "reports/pictures.h"
#include "render/input_error.h"
#include "render/srgb.h"
#include "reports/gallery.h"
#include "tests/render/scene_fixture.h"
#include "tests/support/report_fixture.h"

#include <gmock/gmock.h>

#include <limits>

namespace opaline {
namespace {

using ::testing::HasSubstr;

/// The PNG, read back by OpenImageIO from disk.
Image decoded(const std::string& png) {
  const test::TempFolder folder;
  return read_image(folder.write("p.png", png));
}

double mean_of(const Image& image, int channel) {
  double sum = 0;
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) sum += static_cast<double>(image.at(x, y, channel));
  return sum / static_cast<double>(image.pixel_count());
}

TEST(Shrunk, KeepsTheMeanAndTheShape) {
  const Image image = test::ball_image(96, 0.3);
  const Image small = shrunk(image, 24);
  EXPECT_EQ(small.width, 24);
  EXPECT_EQ(small.height, 24);
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(mean_of(small, c), mean_of(image, c), 1e-6);
  EXPECT_EQ(shrunk(image, 96).data, image.data);
  Image wide(100, 3, {"R", "G", "B"});
  EXPECT_EQ(shrunk(wide, 10).height, 1) << "never 0";
  EXPECT_EQ(shrunk(Image(37, 23, {"Y"}), 10).width, 10);
}

TEST(RelativeError, IsTheRmsOverTheChannelsWhereTheObjectIs) {
  Image reference(2, 1, {"R", "G", "B", "A"}), image(2, 1, {"R", "G", "B", "A"});
  reference.data = {1, 1, 1, 1, 5, 5, 5, 0};
  image.data = {1.3f, 1.4f, 1, 1, 0, 0, 0, 0};
  const Image error = relative_error(image, reference, 2);
  EXPECT_NEAR(error.at(0, 0, 0), std::sqrt(0.25 / 3) / 2, 1e-6);
  EXPECT_EQ(error.at(1, 0, 1), 0) << "off the object";
  EXPECT_NEAR(rms(reference), 1, 1e-12);
  EXPECT_NEAR(relative_size(image, reference, 1, true).at(0, 0, 0), std::sqrt(3.7 / 3), 1e-6) << "variance: rooted";
  EXPECT_NEAR(relative_size(image, reference, 1, false).at(0, 0, 0), std::sqrt((1.69 + 1.96 + 1) / 3), 1e-6);
  EXPECT_THROW(relative_error(Image(3, 1, {"R", "G", "B"}), reference, 1), InputError);
  EXPECT_THROW(relative_error(Image(2, 1, {"Y"}), reference, 1), InputError);
}

TEST(Png, HoldsTheTonemappedValues) {
  Image image(3, 1, {"R", "G", "B"});
  image.data = {0.25f, 0.5f, 4, -1, std::numeric_limits<float>::quiet_NaN(), 0, 1, 1, 1};
  const Image back = decoded(tonemapped_png(image, 0.5));
  ASSERT_EQ(back.channel_count(), 3);
  EXPECT_NEAR(back.data[0], srgb_from_linear(0.125), 0.5 / 255 + 1e-6);
  EXPECT_NEAR(back.data[1], srgb_from_linear(0.25), 0.5 / 255 + 1e-6);
  EXPECT_EQ(back.data[2], 1) << "clipped";
  EXPECT_EQ(back.data[3], 0);
  EXPECT_EQ(back.data[4], 0) << "NaN is black";
}

TEST(FalseColour, RunsOverTheLogarithmFromDarkToLight) {
  Image errors(6, 1, {"Y", "A"});
  errors.data = {1e-9f, 1, 1e-4f, 1, 1e-2f, 1, 1, 1, 50, 1, 0.1f, 0};
  const Image back = decoded(false_colour_png(errors));
  ASSERT_EQ(back.channel_count(), 4);
  const auto lightness = [&](int x) {
    return 0.2126 * back.at(x, 0, 0) + 0.7152 * back.at(x, 0, 1) + 0.0722 * back.at(x, 0, 2);
  };
  EXPECT_EQ(lightness(0), lightness(1)) << "below the scale: its lower end";
  EXPECT_LT(lightness(1), lightness(2));
  EXPECT_LT(lightness(2), lightness(3));
  EXPECT_EQ(lightness(3), lightness(4)) << "above: its upper end";
  EXPECT_NEAR(255 * back.at(2, 0, 1), 144, 1) << "half way in the logarithm is half way in the colours";
  EXPECT_EQ(back.at(4, 0, 3), 1);
  EXPECT_EQ(back.at(5, 0, 3), 0) << "off the object: transparent";
}

TEST(DataUri, IsBase64OfTheBytes) {
  EXPECT_EQ(data_uri(""), "data:image/png;base64,");
  EXPECT_EQ(data_uri("f"), "data:image/png;base64,Zg==");
  EXPECT_EQ(data_uri("fo"), "data:image/png;base64,Zm8=");
  EXPECT_EQ(data_uri("foobar\xff"), "data:image/png;base64,Zm9vYmFy/w==");
}

TEST(Gallery, FitsItsBudgetByShrinking) {
  const test::TempFolder folder;
  test::write_report_folder(folder.file("d"), {.records = 30, .pictured = 30, .extras = false, .side = 64});
  const ReportData data = read_report_data(folder.file("d"));
  const auto bytes = [&](const Gallery& g) {
    std::size_t sum = 0;
    for (const auto& scene : g.scenes) sum += scene.json.dump().size();
    return sum;
  };
  const Gallery large = make_gallery(data);
  const Gallery small = make_gallery(data, 100'000);
  EXPECT_TRUE(large.problems.empty());
  EXPECT_GT(bytes(large), 200'000u);
  EXPECT_LT(bytes(small), 120'000u) << "pictures, and the words beside them";
  EXPECT_EQ(large.scenes.at(0).json["entries"].size(), small.scenes.at(0).json["entries"].size());
}

TEST(Gallery, SaysWhichImagesAreMissingOrBroken) {
  const test::TempFolder folder;
  test::write_report_folder(folder.file("d"), {.records = 3, .pictured = 3, .extras = false, .side = 16});
  ReportData data = read_report_data(folder.file("d"));
  std::filesystem::remove(folder.file("d/" + data.records[0].images.at("render")));
  std::ofstream(folder.file("d/" + data.records[1].images.at("render"))) << "no image";
  const Gallery gallery = make_gallery(data);
  EXPECT_THAT(gallery.problems, ::testing::Contains(HasSubstr("does not exist")));
  EXPECT_THAT(gallery.problems, ::testing::Contains(HasSubstr("cannot be read")));
  ASSERT_EQ(gallery.scenes.size(), 1u) << "the rest is shown";
}

}  // namespace
}  // namespace opaline
