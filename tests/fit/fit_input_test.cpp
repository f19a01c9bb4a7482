// What a fit says of input that is wrong: file, place and the valid choices; and that nothing is written.
#include "tests/support/fit_job_fixture.h"

#include <limits>

namespace opaline {
namespace {

using nlohmann::json;
using test::sphere_document;

class FitInput : public test::FitJobTest {};

TEST_F(FitInput, WrongCounts) {
  FitJob job = job_;
  job.targets.clear();
  expect_wrong(job, {"--target"});
  job = job_;
  job.scenes = {job.scenes[0], job.scenes[0]};
  expect_wrong(job, {"2 scenes for 1 targets", "one each"});
  job = job_;
  job.scenes.clear();
  expect_wrong(job, {"SCENE", "0 scenes"});
  job = job_;
  job.masks = {job.targets[0], job.targets[0]};
  expect_wrong(job, {"--mask", "2 masks for 1 targets"});
}

TEST_F(FitInput, UnknownNames) {
  FitJob job = job_;
  job.model = "standart_dipole";
  expect_wrong(job, {"--model", "standart_dipole", "standard_dipole"});
  job = job_;
  job.material = "m2";
  expect_wrong(job, {"scene.json", "--material", "\"m2\"", "m1"});
  job = job_;
  job.targets = {folder_.file("none.exr")};
  expect_wrong(job, {"none.exr", "does not exist"});
  job = job_;
  job.scenes = {folder_.file("none.json")};
  expect_wrong(job, {"none.json"});
}

TEST_F(FitInput, ATargetOfTheWrongSize) {
  job_.targets = {image_file("small.exr", Image(8, 12, {"R", "G", "B"}))};
  expect_wrong(job_, {"small.exr", "8 x 12", "16 x 12"});
}

TEST_F(FitInput, ATargetWithoutColours) {
  job_.targets = {image_file("grey.exr", Image(16, 12, {"Y", "A"}))};
  expect_wrong(job_, {"grey.exr", "R, G, B", "Y"});
  job_.targets = {image_file("two.exr", Image(16, 12, {"R", "G"}))};
  expect_wrong(job_, {"two.exr", "R, G, B"});
}

TEST_F(FitInput, ATargetCutShort) {
  std::ifstream in(job_.targets[0], std::ios::binary);
  const std::string bytes{std::istreambuf_iterator<char>(in), {}};
  job_.targets = {folder_.write("cut.exr", bytes.substr(0, bytes.size() / 2))};
  expect_wrong(job_, {"cut.exr"});
  job_.targets = {folder_.write("empty.exr", "")};
  expect_wrong(job_, {"empty.exr"});
}

TEST_F(FitInput, ABlackTarget) {
  job_.targets = {image_file("black.exr", Image(16, 12, {"R", "G", "B"}))};
  expect_wrong(job_, {"black.exr", "black on every fitted pixel"});
}

TEST_F(FitInput, ValuesThatAreNotFiniteCountOnlyOnFittedPixels) {
  Image image = picture_;
  image.at(0, 0, 1) = std::nanf("");  // a corner: off the sphere
  job_.targets = {image_file("corner.exr", image)};
  EXPECT_NO_THROW(run(job_));
  image.at(7, 5, 2) = std::nanf("");
  job_.targets = {image_file("nan.exr", image)};
  expect_wrong(job_, {"nan.exr", "pixel (7, 5)", "channel B", "--mask"});
  image.at(7, 5, 2) = std::numeric_limits<float>::infinity();
  job_.targets = {image_file("infinite.exr", image)};
  expect_wrong(job_, {"infinite.exr", "pixel (7, 5)"});
  Image mask(16, 12, {"Y"});
  std::fill(mask.data.begin(), mask.data.end(), 1.0f);
  mask.at(7, 5, 0) = 0;
  job_.masks = {image_file("mask.exr", mask)};
  const FitReport report = run(job_);
  EXPECT_EQ(report.targets[0].difference.at(7, 5, 3), 0);
  EXPECT_EQ(report.targets[0].counters.skipped.at("masked_pixels"), 1u);
}

TEST_F(FitInput, WrongMasks) {
  job_.masks = {image_file("large.exr", Image(16, 13, {"Y"}))};
  expect_wrong(job_, {"large.exr", "mask", "16 x 13", "16 x 12"});
  job_.masks = {image_file("none.exr", Image(16, 12, {"Y"}))};
  expect_wrong(job_, {"target.exr", "no pixel takes part", "masked"});
  job_.masks = {folder_.file("missing.png")};
  expect_wrong(job_, {"missing.png"});
}

TEST_F(FitInput, ChannelsInAnotherOrderAreFoundByName) {
  Image shuffled(16, 12, {"Z", "B", "G", "R"});
  for (int y = 0; y < 12; ++y)
    for (int x = 0; x < 16; ++x)
      for (int c = 0; c < 3; ++c) shuffled.at(x, y, 3 - c) = picture_.at(x, y, c);
  FitJob job = job_;
  job.targets = {image_file("shuffled.exr", shuffled)};
  EXPECT_EQ(run(job).solution.parameters, run(job_).solution.parameters);
}

TEST_F(FitInput, SeveralMaterialsNeedAChoice) {
  json document = sphere_document();
  document["materials"]["m2"] = {{"library", "marble"}};
  document["materials"]["unused"] = {{"library", "ketchup"}};
  json second = document["objects"][0];
  second["material"] = "m2";
  second["radius"] = 2;
  second["transform"] = {{"translate", {3, 3, 4}}};
  document["objects"].push_back(second);
  job_.scenes = {folder_.write("many.json", document.dump())};
  job_.targets = {image_file("many.exr", picture(document))};
  expect_wrong(job_, {"many.json", "several materials", "--material", "m1, m2"});
  job_.material = "unused";
  expect_wrong(job_, {"--material", "\"unused\"", "m1, m2"});
  job_.material = "m2";
  EXPECT_EQ(run(job_).material.name, "m2");
}

TEST_F(FitInput, AFixedEtaMustAgree) {
  job_.scenes.push_back(scene_with("eta.json", "/materials/m1/eta", 1.4));
  job_.targets.push_back(job_.targets[0]);
  job_.solve.free = parse_free("sigma_a,sigma_s_prime");
  expect_wrong(job_, {"eta.json", "eta is 1.4", "1.3", "scene.json"});
  job_.solve.free = {};
  EXPECT_NO_THROW(run(job_));
}

TEST_F(FitInput, WithoutLightThereIsNothingToFit) {
  FitJob job = job_;
  job.scenes = {scene_with("dark.json", "/lights/0/irradiance", {0, 0, 0})};
  expect_wrong(job, {"dark.json", "/lights", "no light reaches"});
  // A projector that looks past the sphere.
  job.scenes = {scene_with("past.json", "/lights/0",
                           {{"type", "projector"},
                            {"position", {0, 0, 40}},
                            {"look_at", {30, 0, 0}},
                            {"intensity", {9, 9, 9}},
                            {"disk_radius_deg", 2}})};
  expect_wrong(job, {"past.json", "/lights", "no light reaches"});
}

TEST_F(FitInput, AnObjectOutOfViewHasNoPixels) {
  job_.scenes = {scene_with("away.json", "/camera/look_at", {0, 0, 200})};
  expect_wrong(job_, {"target.exr", "no pixel takes part", "out of view"});
}

}  // namespace
}  // namespace opaline
