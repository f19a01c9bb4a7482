#include "render/image.h"

#include "render/srgb.h"
#include "tests/render/scene_fixture.h"

#include <OpenImageIO/imageio.h>
#include <gmock/gmock.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <random>

namespace opaline {
namespace {

using test::message_of;
using test::TempFolder;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::StartsWith;

Image noise(int width, int height, std::vector<std::string> channels) {
  Image image(width, height, std::move(channels));
  std::mt19937 random(7);
  std::normal_distribution<float> value(0, 10);
  for (float& v : image.data) v = value(random);
  return image;
}

std::string bytes_of(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

TEST(Image, IndexesRowsFromTheTopWithChannelsInterleaved) {
  Image image(3, 2, {"R", "G"});
  image.at(2, 1, 0) = 5;
  EXPECT_EQ(image.data.size(), 12u);
  EXPECT_EQ(image.data[10], 5);
  EXPECT_EQ(image.channel("G"), 1);
  EXPECT_EQ(image.channel("B"), -1);
}

TEST(WriteExr, RoundTripIsExactAndKeepsChannelNames) {
  TempFolder folder;
  Image image = noise(37, 19, {"R", "G", "B", "A"});
  image.at(3, 4, 1) = std::numeric_limits<float>::infinity();
  image.at(5, 6, 2) = 1e-42f;
  write_exr(folder.file("a.exr"), image);
  const Image read = read_image(folder.file("a.exr"));
  EXPECT_EQ(read.width, 37);
  EXPECT_EQ(read.height, 19);
  EXPECT_THAT(read.channels, ElementsAre("R", "G", "B", "A"));
  EXPECT_EQ(std::memcmp(read.data.data(), image.data.data(), image.data.size() * sizeof(float)), 0);
  EXPECT_EQ(folder.file_count(), 1u);
}

TEST(WriteExr, IsFloatZipWithTheGivenHeader) {
  TempFolder folder;
  write_exr(folder.file("a.exr"), noise(4, 4, {"depth", "id"}), {{"opaline:technique", "hierarchical"}});
  const auto input = OIIO::ImageInput::open(folder.file("a.exr"));
  ASSERT_TRUE(input);
  EXPECT_EQ(input->spec().get_string_attribute("opaline:technique"), "hierarchical");
  EXPECT_EQ(input->spec().get_string_attribute("compression"), "zip");
  EXPECT_EQ(input->spec().format, OIIO::TypeDesc::FLOAT);
  EXPECT_THAT(input->spec().channelnames, ElementsAre("depth", "id"));
}

TEST(WriteExr, MissingFolderAndWrongNameAreErrors) {
  TempFolder folder;
  const Image image(2, 2, {"R", "G", "B"});
  const std::string path = folder.file("absent/a.exr");
  EXPECT_THAT(message_of([&] { write_exr(path, image); }), StartsWith(path + ": cannot be written: the folder"));
  EXPECT_THAT(message_of([&] { write_exr(folder.file("a.jpg"), image); }), HasSubstr("must end in .exr"));
  EXPECT_THAT(message_of([&] { write_exr(folder.file("a.exr"), Image()); }), HasSubstr("no pixels"));
  EXPECT_EQ(folder.file_count(), 0u);
}

// IEC 61966-2-1: the two pieces meet at .0031308, and mid grey .2140 encodes to one half.
TEST(Srgb, MeetsPublishedValues) {
  EXPECT_NEAR(srgb_from_linear(0.0031308), 0.04045, 1e-6);
  EXPECT_NEAR(srgb_from_linear(std::nextafter(0.0031308, 1)), 0.04045, 1e-6);
  EXPECT_NEAR(srgb_from_linear(0.2140411), 0.5, 1e-6);
  EXPECT_NEAR(srgb_from_linear(1), 1, 1e-12);
}

TEST(WritePng, EncodesClipsAndExposes) {
  TempFolder folder;
  Image image(4, 1, {"R", "G", "B", "A"});
  const float values[4] = {0.5f * 0.5028865f, 3.0f, -1.0f, std::nanf("")};
  for (int x = 0; x < 4; ++x) image.at(x, 0, 0) = values[x];
  write_png(folder.file("a.png"), image, 2);
  const Image read = read_image(folder.file("a.png"));
  EXPECT_THAT(read.channels, ElementsAre("R", "G", "B"));
  EXPECT_EQ(std::lround(255 * read.at(0, 0, 0)), 188);  // .5028865 is the linear value of code 188
  EXPECT_EQ(read.at(1, 0, 0), 1);
  EXPECT_EQ(read.at(2, 0, 0), 0);
  EXPECT_EQ(read.at(3, 0, 0), 0);
  EXPECT_EQ(read.at(0, 0, 1), 0);
}

TEST(WritePng, OneChannelIsGrey) {
  TempFolder folder;
  write_png(folder.file("a.png"), Image(2, 2, {"depth"}));
  EXPECT_EQ(read_image(folder.file("a.png")).channel_count(), 1);
}

TEST(WritePng, FailureLeavesTheOldFileAndNoTemporary) {
  TempFolder folder;
  const std::string old = folder.write("a.png", "old");
  Image too_wide(1, 1, {"R", "G", "B"});
  too_wide.width = 1000001;  // beyond what libpng takes
  too_wide.data.resize(too_wide.pixel_count() * 3);
  EXPECT_THAT(message_of([&] { write_png(old, too_wide); }), StartsWith(old + ": cannot be written: "));
  EXPECT_EQ(bytes_of(old), "old");
  EXPECT_EQ(folder.file_count(), 1u);
}

TEST(ReadImage, MissingEmptyFolderAndUnknownFormatAreErrors) {
  TempFolder folder;
  const std::string missing = folder.file("no.exr");
  EXPECT_EQ(message_of([&] { read_image(missing); }), missing + ": the file does not exist");
  EXPECT_THAT(message_of([&] { read_image(folder.write("e.exr", "")); }), HasSubstr("is empty"));
  EXPECT_THAT(message_of([&] { read_image(folder.file("")); }), HasSubstr("is a folder"));
  const std::string text = folder.write("t.txt", "hello");
  EXPECT_THAT(message_of([&] { read_image(text); }), StartsWith(text + ": cannot be read as an image: "));
  const std::string fake = folder.write("f.exr", "hello, this is no image");
  EXPECT_THAT(message_of([&] { read_image(fake); }), AllOf(StartsWith(fake), HasSubstr("not an OpenEXR file")));
}

TEST(ReadImage, FileThatEndsEarlyIsAnErrorNotZeros) {
  TempFolder folder;
  const Image image = noise(80, 60, {"R", "G", "B"});
  write_exr(folder.file("a.exr"), image);
  write_png(folder.file("a.png"), image);
  for (const std::string extension : {".exr", ".png"}) {
    const std::string bytes = bytes_of(folder.file("a" + extension));
    for (double fraction : {0.1, 0.5, 0.95}) {
      const auto size = static_cast<std::size_t>(fraction * static_cast<double>(bytes.size()));
      const std::string path = folder.write("cut" + extension, bytes.substr(0, size));
      EXPECT_THAT(message_of([&] { read_image(path); }), StartsWith(path + ": ")) << fraction << extension;
    }
  }
}

/// OpenImageIO fills the missing strips of a cut TIFF with zeros and returns true.
TEST(ReadImage, CutTiffIsAnErrorThoughTheReaderReturnsTrue) {
  TempFolder folder;
  const Image image = noise(80, 60, {"R", "G", "B"});
  OIIO::ImageSpec spec(80, 60, 3, OIIO::TypeDesc::FLOAT);
  const auto output = OIIO::ImageOutput::create("a.tif");
  ASSERT_TRUE(output && output->open(folder.file("a.tif"), spec));
  ASSERT_TRUE(output->write_image(OIIO::TypeDesc::FLOAT, image.data.data()) && output->close());
  const std::string bytes = bytes_of(folder.file("a.tif"));
  EXPECT_EQ(read_image(folder.file("a.tif")).data, image.data);
  // The directory of a TIFF may stand at its end; a hole in the pixels is what a cut leaves otherwise.
  const std::string path = folder.write("cut.tif", bytes.substr(0, bytes.size() * 3 / 4));
  EXPECT_THAT(message_of([&] { read_image(path); }), StartsWith(path + ": "));
}

TEST(ReadImage, AlphaDoesNotMultiplyStoredColour) {
  TempFolder folder;
  OIIO::ImageSpec spec(1, 1, 4, OIIO::TypeDesc::UINT8);
  spec.attribute("oiio:UnassociatedAlpha", 1);
  const unsigned char pixel[4] = {200, 100, 50, 51};
  const auto output = OIIO::ImageOutput::create("a.png");
  ASSERT_TRUE(output && output->open(folder.file("a.png"), spec));
  ASSERT_TRUE(output->write_image(OIIO::TypeDesc::UINT8, pixel) && output->close());
  const Image read = read_image(folder.file("a.png"));
  EXPECT_NEAR(read.at(0, 0, 0), 200 / 255.0, 1e-6);
  EXPECT_NEAR(read.at(0, 0, 3), 51 / 255.0, 1e-6);
}

TEST(AutoExposure, PutsThe99thPercentileAtNineTenths) {
  Image image(101, 1, {"R", "G", "B"});
  for (int x = 0; x < 101; ++x) image.at(x, 0, x % 3) = static_cast<float>(x);
  EXPECT_NEAR(auto_exposure(image), 0.9 / 99, 1e-12);
  image.at(100, 0, 1) = std::numeric_limits<float>::infinity();  // leaves 100 values, 0 .. 99
  EXPECT_NEAR(auto_exposure(image), 0.9 / 98, 1e-12);
}

TEST(AutoExposure, BlackIsOneAndASpotIsScaledByItsPeak) {
  Image image(200, 10, {"R", "G", "B"});
  EXPECT_EQ(auto_exposure(image), 1);
  image.at(0, 0, 2) = 3;
  EXPECT_NEAR(auto_exposure(image), 0.3, 1e-7);
}

}  // namespace
}  // namespace opaline
