// `opaline fit`, the binary: its table, its JSON, its exit codes.
#include "datasets_synthetic/dataset.h"
#include "datasets_synthetic/shapes/shapes.h"
#include "tests/render/scene_fixture.h"

#include <gmock/gmock.h>
#include <sys/wait.h>

#include <cstdlib>
#include <sstream>

namespace opaline {
namespace {

using nlohmann::json;
using ::testing::HasSubstr;
using ::testing::StartsWith;

struct Ending {
  int status;
  std::string out, err;
};

std::string content(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

/// A synthetic dataset of a small sphere, and the binary run beside it.
class FitCommand : public ::testing::Test {
 protected:
  FitCommand() {
    json scene = test::valid_document();
    scene["film"] = {{"width", 20}, {"height", 20}};
    scene["camera"]["fov_y_deg"] = 11;
    scene["lights"][0]["direction"] = {-1, 0.3, -0.6};
    scene["objects"] = {{{"shape", "sphere"}, {"radius", 5}, {"triangles", 500}, {"material", "m1"}}};
    Recipe recipe;
    recipe.name = "small", recipe.summary = "a small sphere", recipe.path = folder_.file("recipe.json");
    recipe.scene = scene, recipe.material = "m1";
    recipe.noise_relative = 0.01, recipe.samples = 600, recipe.technique = "hierarchical";
    recipe.settings = {{"discretisation", "fixed"}};  // the cells of the fit
    make_dataset(recipe, folder_.file("data"), synthetic_shapes());
  }

  Ending run(const std::string& arguments) {
    const std::string command = "cd '" + folder_.file("data") + "' && '" OPALINE_BINARY "' fit " + arguments + " >'" +
                                folder_.file("out.txt") + "' 2>'" + folder_.file("err.txt") + "' </dev/null";
    const int status = std::system(command.c_str());
    return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, content(folder_.file("out.txt")),
            content(folder_.file("err.txt"))};
  }

  bool exists(const std::string& name) { return std::filesystem::exists(folder_.file("data/" + name)); }

  test::TempFolder folder_;
};

constexpr const char* quick =
    "scene.json --target target.exr --samples 600 --starts 2 --model standard_dipole --allow-undetermined ";

TEST_F(FitCommand, PrintsTruthAndRecoveryInATable) {
  const Ending e = run(std::string(quick) + "--truth truth.json --out result");
  EXPECT_EQ(e.status, 0) << e.err;
  std::istringstream lines(e.out);
  std::string line;
  std::getline(lines, line);
  for (const char* head : {"parameter", "true", "recovered", "95 % interval", "(sd)"})
    EXPECT_THAT(line, HasSubstr(head));
  const char* expected[7][2] = {{"sigma_a_per_mm[R]", "0.032"},
                                {"sigma_a_per_mm[G]", "0.17"},
                                {"sigma_a_per_mm[B]", "0.48"},
                                {"sigma_s_prime_per_mm[R]", "0.74"},
                                {"sigma_s_prime_per_mm[G]", "0.88"},
                                {"sigma_s_prime_per_mm[B]", "1.01"},
                                {"eta", "1.3"}};
  for (const auto& [name, value] : expected) {
    std::getline(lines, line);
    EXPECT_THAT(line, StartsWith(name));
    EXPECT_THAT(line, HasSubstr(std::string(" ") + value + " "));
    EXPECT_THAT(line, HasSubstr(" .. "));
    EXPECT_THAT(line, HasSubstr(" %"));
  }
  std::getline(lines, line);
  EXPECT_THAT(line, StartsWith("alpha'[R] (derived)"));
  EXPECT_THAT(line, HasSubstr("0.9585"));
  EXPECT_THAT(e.out, HasSubstr("residual"));
  EXPECT_THAT(e.out, HasSubstr("seconds: operator"));
  EXPECT_THAT(e.out, HasSubstr("fit.json"));
  EXPECT_TRUE(exists("result/fit.json"));
  const json document = json::parse(content(folder_.file("data/result/fit.json")));
  EXPECT_EQ(document["format"], "opaline-fit");
}

TEST_F(FitCommand, PrintsTheSameJsonAsItWrites) {
  const Ending e = run(std::string(quick) + "--free sigma_a --json --out result");
  EXPECT_EQ(e.status, 0) << e.err;
  const json printed = json::parse(e.out);
  EXPECT_EQ(printed, json::parse(content(folder_.file("data/result/fit.json"))));
  EXPECT_FALSE(printed["parameters"]["eta"]["free"]);
  EXPECT_TRUE(printed["parameters"]["eta"]["identifiable"]);
}

TEST_F(FitCommand, FixedAndUnknownParametersAreMarkedInTheTable) {
  const Ending e = run(std::string(quick) + "--free sigma_a --truth truth.json --out result");
  EXPECT_EQ(e.status, 0) << e.err;
  EXPECT_THAT(e.out, HasSubstr("fixed"));
  const Ending plain = run(std::string(quick) + "--free sigma_a --out again");
  EXPECT_EQ(plain.out.find("true"), std::string::npos);
}

TEST_F(FitCommand, WithoutDeterminedParametersThereIsNoNumber) {
  Image two_pixels(20, 20, {"Y"});
  two_pixels.at(9, 9, 0) = two_pixels.at(10, 9, 0) = 1;
  write_exr(folder_.file("data/mask.exr"), two_pixels);
  const std::string fit =
      "scene.json --target target.exr --samples 600 --starts 2 --mask mask.exr --model standard_dipole --parabola ";
  const Ending e = run(fit + "--out result");
  EXPECT_EQ(e.status, 1) << e.err;
  EXPECT_THAT(e.err, HasSubstr("the pictures do not determine sigma_a_per_mm[R]"));
  EXPECT_THAT(e.err, HasSubstr("--advise"));
  EXPECT_THAT(e.out, HasSubstr("not determined"));
  EXPECT_FALSE(exists("result/material.json"));
  EXPECT_FALSE(json::parse(content(folder_.file("data/result/fit.json")))["determined"]);
  EXPECT_EQ(run(fit + "--allow-undetermined --out again").status, 0);
  EXPECT_TRUE(exists("again/material.json"));
}

TEST_F(FitCommand, WritesReportExaminationAndExports) {
  const Ending e =
      run(std::string(quick) +
          "--free sigma_a,sigma_s_prime --compare-models --bootstrap 5 --export openpbr,pbrt --out result");
  EXPECT_EQ(e.status, 0) << e.err;
  EXPECT_THAT(e.out, HasSubstr("photon_beam_diffusion"));
  EXPECT_THAT(e.out, HasSubstr("5 repetitions"));
  EXPECT_THAT(content(folder_.file("data/result/material_openpbr.mtlx")), HasSubstr("open_pbr_surface"));
  EXPECT_THAT(content(folder_.file("data/result/material_pbrt.pbrt")), HasSubstr("Material \"subsurface\""));
  const std::string html = content(folder_.file("data/result/report.html"));
  for (const char* part : {"<section", "target.png", "difference.png", "Residual against its noise", "95 % band",
                           "Correlations", "Starts: ", "Other models", "</section>"})
    EXPECT_THAT(html, HasSubstr(part));
  const json document = json::parse(content(folder_.file("data/result/fit.json")));
  EXPECT_GE(document["models"]["fits"].size(), 8u);
  EXPECT_EQ(document["bootstrap"]["repetitions"], 5);
}

TEST_F(FitCommand, WrongInputEndsWithTwoAndWritesNothing) {
  const std::vector<std::pair<std::string, std::string>> wrong = {
      {"scene.json --out result", "--target"},
      {std::string(quick) + "--free sigma_x --out result", "sigma_x"},
      {std::string(quick) + "--prior eta=1.4 --out result", "NAME=MEAN:SD"},
      {std::string(quick) + "--noise loud --out result", "READ,SHOT"},
      {std::string(quick) + "--export maya --out result", "pbrt_medium"},
      {std::string(quick) + "--transfer log --out result", "gamma:G"},
      {std::string(quick) + "--truth scene.json --out result", "scene.json"},
      {"scene.json --target none.exr --out result", "none.exr"},
      {"none.json --target target.exr --out result", "none.json"},
      {std::string(quick) + "--starts 0 --out result", "--starts"}};
  for (const auto& [arguments, part] : wrong) {
    const Ending e = run(arguments);
    EXPECT_EQ(e.status, 2) << arguments << e.err;
    EXPECT_EQ(e.out, "");
    EXPECT_THAT(e.err, HasSubstr(part));
    EXPECT_FALSE(exists("result")) << arguments;
  }
}

}  // namespace
}  // namespace opaline
