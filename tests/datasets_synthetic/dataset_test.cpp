#include "datasets_synthetic/dataset.h"

#include "model/materials/library.h"
#include "render/scene/scene.h"
#include "tests/render/scene_fixture.h"
#include "validate/metrics/metric.h"

#include <gmock/gmock.h>
#include <tbb/global_control.h>

#include <cmath>
#include <filesystem>
#include <numeric>

namespace opaline {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using ::testing::HasSubstr;

/// A picture of an octahedron, small enough to render in no time.
Recipe small_recipe(const std::string& library = "skin1") {
  Recipe recipe;
  recipe.path = "small.json";
  recipe.name = "small";
  recipe.scene = test::valid_document();
  recipe.scene["film"] = {{"width", 24}, {"height", 20}};
  recipe.scene["camera"]["fov_y_deg"] = 11;
  recipe.scene["materials"]["m1"] = {{"library", library}};
  recipe.material = "m1";
  recipe.noise_relative = 0.05;
  recipe.samples = 2000;
  recipe.technique = "hierarchical";
  recipe.settings = {{"discretisation", "fixed"}};
  return recipe;
}

/// Value 2, 4 and 0.5 in R, G and B, covered.
Image flat_image(int width, int height) {
  Image image(width, height, {"R", "G", "B", "A"});
  for (std::size_t p = 0; p < image.pixel_count(); ++p) {
    image.data[4 * p] = 2;
    image.data[4 * p + 1] = 4;
    image.data[4 * p + 2] = 0.5f;
    image.data[4 * p + 3] = 1;
  }
  return image;
}

/// What the noise added to one channel, over its standard deviation.
std::vector<double> deviates(const Image& noisy, const Image& clean, std::size_t channel, double sd) {
  std::vector<double> result;
  for (std::size_t i = channel; i < clean.data.size(); i += 4)
    result.push_back((static_cast<double>(noisy.data[i]) - static_cast<double>(clean.data[i])) / sd);
  return result;
}

double mean_product(const std::vector<double>& a, const std::vector<double>& b) {
  return std::inner_product(a.begin(), a.end(), b.begin(), 0.0) / static_cast<double>(a.size());
}

TEST(Noise, IsGaussianWithTheStatedDeviationAndIndependent) {
  const Image clean = flat_image(200, 200);
  Image noisy = clean;
  const auto sd = add_noise(noisy, 0.1, 3);
  EXPECT_NEAR(sd[0], 0.2, 1e-12);
  EXPECT_NEAR(sd[1], 0.4, 1e-12);
  EXPECT_NEAR(sd[2], 0.05, 1e-12);
  const auto r = deviates(noisy, clean, 0, sd[0]), g = deviates(noisy, clean, 1, sd[1]);
  const double five_sigma = 5 / std::sqrt(40000.0);
  EXPECT_NEAR(std::accumulate(r.begin(), r.end(), 0.0) / 40000, 0, five_sigma);
  EXPECT_NEAR(mean_product(r, r), 1, five_sigma * std::sqrt(2.0));
  EXPECT_NEAR(mean_product(r, g), 0, five_sigma);
  // Neighbours along a row, and the shares a normal distribution has within 1 and 2 sigma.
  EXPECT_NEAR(mean_product({r.begin(), r.end() - 1}, {r.begin() + 1, r.end()}), 0, five_sigma);
  const auto share = [&](double limit) {
    return static_cast<double>(std::count_if(r.begin(), r.end(), [&](double v) { return std::abs(v) < limit; })) /
           40000;
  };
  EXPECT_NEAR(share(1), 0.682689, five_sigma / 2);
  EXPECT_NEAR(share(2), 0.954500, five_sigma / 4);
}

TEST(Noise, TouchesOnlyCoveredPixelsAndNeverAlpha) {
  Image image = flat_image(8, 1);
  image.at(2, 0, 3) = 0;
  image.at(3, 0, 3) = 0.5f;
  const Image clean = image;
  add_noise(image, 0.1, 1);
  for (int x = 0; x < 8; ++x) {
    EXPECT_EQ(image.at(x, 0, 3), clean.at(x, 0, 3));
    for (int c = 0; c < 3; ++c) EXPECT_EQ(image.at(x, 0, c) == clean.at(x, 0, c), x == 2 || x == 3);
  }
}

TEST(Noise, IsNumberedByPixelSoThatOtherPixelsDoNotMatter) {
  Image all = flat_image(16, 16), one = flat_image(16, 16), other_seed = flat_image(16, 16);
  for (int x = 0; x < 15; ++x) one.at(x, 5, 3) = 0;
  add_noise(all, 0.1, 1);
  add_noise(one, 0.1, 1);
  add_noise(other_seed, 0.1, 2);
  EXPECT_EQ(one.at(15, 5, 1), all.at(15, 5, 1));
  EXPECT_EQ(one.at(3, 9, 2), all.at(3, 9, 2));
  EXPECT_NE(other_seed.at(3, 9, 2), all.at(3, 9, 2));
}

TEST(Noise, OfZeroChangesNothing) {
  Image image = flat_image(4, 4);
  EXPECT_EQ(add_noise(image, 0, 1)[0], 0);
  EXPECT_EQ(image.data, flat_image(4, 4).data);
}

TEST(Dataset, StartsFromTheSameMaterialWhateverTheTruth) {
  const Dataset skin = compute_dataset(small_recipe("skin1"), test::test_shapes());
  const Dataset ketchup = compute_dataset(small_recipe("ketchup"), test::test_shapes());
  EXPECT_EQ(skin.scene, ketchup.scene) << "nothing of the answer may show in the scene";
  EXPECT_NE(skin.truth_scene, ketchup.truth_scene);
  const Scene scene = parse_scene(skin.scene, "scene.json", test::test_shapes());
  EXPECT_EQ(scene.materials.at(0).sigma_a, Rgb(0.05));
  EXPECT_EQ(scene.materials.at(0).sigma_s_prime, Rgb(1));
  EXPECT_EQ(scene.materials.at(0).eta, 1.35);
}

TEST(Dataset, TruthIsTheMaterialAndTheNoise) {
  const Dataset d = compute_dataset(small_recipe(), test::test_shapes());
  const MaterialRow& skin = *find_material("skin1");
  EXPECT_EQ(d.truth.at("format"), "opaline-truth");
  EXPECT_EQ(d.truth.at("recipe"), "small");
  EXPECT_EQ(d.truth.at("parameters").at("sigma_a_per_mm"), json(skin.sigma_a));
  EXPECT_EQ(d.truth.at("parameters").at("sigma_s_prime_per_mm"), json(skin.sigma_s_prime));
  EXPECT_EQ(d.truth.at("parameters").at("eta"), skin.eta);
  const Comparison difference = compare_images(d.target, d.clean);
  EXPECT_GT(difference.pixels.size(), 100u);
  for (std::size_t c = 0; c < 3; ++c) {
    // The sample deviation of n values scatters by 1 / sqrt(2 n).
    const double scatter = 1 / std::sqrt(2.0 * static_cast<double>(difference.pixels.size()));
    EXPECT_NEAR(find_metric("rmse", "test").evaluate(difference.channel(c)) / d.truth.at("noise_sd")[c].get<double>(),
                1, 5 * scatter);
    EXPECT_NEAR(find_metric("relative_rmse", "test").evaluate(difference.channel(c)), 0.05, 0.05 * 5 * scatter);
  }
}

TEST(Dataset, IsTheSameForAnyNumberOfThreads) {
  const auto make = [](std::size_t threads) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    return compute_dataset(small_recipe(), test::test_shapes());
  };
  const Dataset one = make(1), four = make(4);
  EXPECT_EQ(one.target.data, four.target.data);
  EXPECT_EQ(one.clean.data, four.clean.data);
}

TEST(Dataset, SeedChangesTheNoiseAlone) {
  Recipe recipe = small_recipe();
  const Dataset first = compute_dataset(recipe, test::test_shapes());
  recipe.seed = 2;
  const Dataset second = compute_dataset(recipe, test::test_shapes());
  EXPECT_EQ(first.clean.data, second.clean.data);
  EXPECT_NE(first.target.data, second.target.data);
}

TEST(MakeDataset, WritesFilesThatRenderToTheCleanImage) {
  const test::TempFolder folder;
  const std::string out = folder.file("new/folder");
  make_dataset(small_recipe(), out, test::test_shapes());
  for (const char* name : {"scene.json", "truth_scene.json", "truth.json", "target.exr", "target.png", "clean.exr"})
    EXPECT_TRUE(fs::exists(fs::path(out) / name)) << name;
  EXPECT_EQ(std::distance(fs::directory_iterator(out), {}), 6) << "something half made was left";
  const Scene truth = load_scene(out + "/truth_scene.json", test::test_shapes());
  RenderOptions options;
  options.shared.samples = 2000;
  options.settings = {{"discretisation", "fixed"}};
  EXPECT_EQ(render_scene(truth, options).image.data, read_image(out + "/clean.exr").data);
  EXPECT_EQ(read_json_file(out + "/truth.json").at("material"), "m1");
  EXPECT_NO_THROW(load_scene(out + "/scene.json", test::test_shapes()));
}

TEST(MakeDataset, FindsTheMeshesOfARecipeElsewhere) {
  const test::TempFolder folder;
  folder.write("tetrahedron.obj", test::tetrahedron_obj);
  Recipe recipe = small_recipe();
  recipe.path = folder.file("recipe.json");
  recipe.scene["camera"]["look_at"] = {0.3, 0.3, 0.3};
  recipe.scene["objects"] = {{{"mesh", "tetrahedron.obj"}, {"material", "m1"}}};
  make_dataset(recipe, folder.file("a/b"), test::test_shapes());
  EXPECT_EQ(load_scene(folder.file("a/b/scene.json"), test::test_shapes()).objects[0].mesh.triangles.size(), 4u);
}

/// The message of a make_dataset that fails; also expects that it left nothing behind.
std::string failure(const Recipe& recipe) {
  const test::TempFolder folder;
  const std::string message = test::message_of([&] { make_dataset(recipe, folder.file("out"), test::test_shapes()); });
  EXPECT_EQ(folder.file_count(), 0u);
  return message;
}

TEST(MakeDataset, SaysWhatIsWrongAndWritesNothing) {
  Recipe recipe = small_recipe();
  recipe.material = "m2";
  EXPECT_THAT(failure(recipe), HasSubstr("valid material of the scenes: m1"));
  recipe = small_recipe();
  recipe.scene["materials"]["m2"] = recipe.scene["materials"]["m1"];
  recipe.material = "m2";
  EXPECT_THAT(failure(recipe), HasSubstr("no object of the scene"));
  recipe = small_recipe();
  recipe.technique = "guessing";
  EXPECT_THAT(failure(recipe), HasSubstr("hierarchical"));
  recipe = small_recipe();
  recipe.scene["camera"]["look_at"] = {0, 0, 120};
  EXPECT_THAT(failure(recipe), HasSubstr("sees no object"));
  recipe = small_recipe();
  recipe.scene["film"]["width"] = 0;
  EXPECT_THAT(failure(recipe), HasSubstr("/film/width"));
}

TEST(MakeDataset, RefusesAFolderThatIsAFile) {
  const test::TempFolder folder;
  const std::string file = folder.write("file", "content");
  EXPECT_THAT(test::message_of([&] { make_dataset(small_recipe(), file, test::test_shapes()); }),
              HasSubstr("is a file"));
}

}  // namespace
}  // namespace opaline
