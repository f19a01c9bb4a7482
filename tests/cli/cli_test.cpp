// The real binary, run as a user would: exit codes, messages, files.
#include "render/image.h"
#include "tests/render/scene_fixture.h"

#include <gmock/gmock.h>
#include <sys/wait.h>

#include <atomic>
#include <cstdlib>
#include <filesystem>
#include <future>
#include <sstream>

namespace opaline {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using ::testing::AllOf;
using ::testing::HasSubstr;

struct Ending {
  int status;
  std::string out, err;
};

std::string content(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

/// A folder with a small scene, in which commands run.
class Cli : public ::testing::Test {
 protected:
  Cli() {
    json scene = test::valid_document();
    scene["film"] = {{"width", 16}, {"height", 16}};
    scene["camera"]["fov_y_deg"] = 11;
    scene["objects"] = {{{"shape", "sphere"}, {"radius", 5}, {"triangles", 500}, {"material", "m1"}}};
    folder_.write("scene.json", scene.dump());
  }

  /// environment: "NAME=value ...", or none.
  Ending run(const std::string& arguments, const std::string& environment = "") {
    const std::string number = std::to_string(runs_++), out = logs_.file("out" + number),
                      err = logs_.file("err" + number);
    const std::string command = "cd '" + folder_.file("") + "' && " + environment + " '" OPALINE_BINARY "' " +
                                arguments + " >'" + out + "' 2>'" + err + "' </dev/null";
    const int status = std::system(command.c_str());
    return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, content(out), content(err)};
  }

  /// Expects exit code 2, one message on stderr that names all of `parts`, and no new file.
  void expect_wrong(const std::string& arguments, const std::vector<std::string>& parts) {
    SCOPED_TRACE(arguments);
    const std::size_t files = folder_.file_count();
    const Ending e = run(arguments);
    EXPECT_EQ(e.status, 2) << e.err;
    EXPECT_EQ(e.out, "");
    EXPECT_EQ(e.err.rfind("opaline: ", 0), 0u) << e.err;
    for (const std::string& part : parts) EXPECT_THAT(e.err, HasSubstr(part));
    EXPECT_EQ(folder_.file_count(), files) << "something was written";
  }

  test::TempFolder folder_, logs_;
  std::atomic<int> runs_{0};
};

constexpr const char* fast_render = "render scene.json --technique hierarchical --samples 500 --out ";

TEST_F(Cli, HelpOfEveryCommandHasAnExample) {
  std::map<std::string, std::future<Ending>> endings;  // starting up takes longest: side by side
  for (const std::string command : {"profile", "profile list", "material", "material list", "material show", "dataset",
                                    "dataset list", "dataset make", "render", "compare", "validate", "fit", "transport",
                                    "transport walk", "transport table", "transport errors", "report", "depth-texture"})
    endings[command] = std::async(std::launch::async, [this, command] { return run(command + " --help"); });
  for (auto& [command, ending] : endings) {
    SCOPED_TRACE(command);
    const Ending e = ending.get();
    EXPECT_EQ(e.status, 0);
    EXPECT_EQ(e.err, "");
    EXPECT_THAT(e.out, HasSubstr("Example: opaline " + command));
  }
}

TEST_F(Cli, AloneItPrintsTheHelp) {
  const Ending alone = run(""), help = run("--help");
  EXPECT_EQ(alone.status, 0);
  EXPECT_EQ(alone.out, help.out);
  for (const char* command : {"profile", "material", "dataset", "render", "compare", "fit"})
    EXPECT_THAT(alone.out, HasSubstr(command));
  EXPECT_THAT(run("--version").out, ::testing::ContainsRegex("^opaline [0-9]+\\.[0-9]+\\.[0-9]+\n$"));
}

TEST_F(Cli, NamesTheValidChoices) {
  expect_wrong("rendr scene.json", {"did you mean \"render\"?", "compare"});
  expect_wrong("render scene.json --technique guess --out a.exr", {"guess", "hierarchical", "brute_force"});
  expect_wrong(std::string(fast_render) + "a.exr --set color=red", {"color", "max_relative_error"});
  expect_wrong(std::string(fast_render) + "a.exr --set quality=good", {"quality", "good"});
  expect_wrong(std::string(fast_render) + "a.exr --backend tpu", {"tpu", "cpu", "gpu"});
  expect_wrong(std::string(fast_render) + "a.exr --backend gpu --gl vulkan", {"--gl", "vulkan", "egl", "osmesa"});
  expect_wrong(std::string(fast_render) + "a.exr --exit-lobe round", {"round", "normalised", "jensen"});
  expect_wrong("dataset make bust --out d", {"bust_skin1", "sphere_wholemilk"});
}

TEST_F(Cli, NamesTheFileAndThePlace) {
  json bad = test::valid_document();
  bad["objects"][0]["material"] = "m2";
  folder_.write("bad.json", bad.dump());
  expect_wrong("render bad.json --technique hierarchical --out a.exr", {"bad.json", "/objects/0/material", "m1"});
  expect_wrong("render none.json --technique hierarchical --out a.exr", {"none.json", "does not exist"});
  expect_wrong("dataset make none.json --out d", {"none.json", "does not exist"});
  expect_wrong("compare none.exr none.exr", {"none.exr", "does not exist"});
}

TEST_F(Cli, RefusesWrongArgumentsBeforeAnyWork) {
  expect_wrong("render scene.json --out a.exr", {"--technique", "--list"});
  expect_wrong("render scene.json --technique hierarchical", {"--out"});
  expect_wrong("render --technique hierarchical --out a.exr", {"SCENE"});
  expect_wrong(std::string(fast_render) + "a.jpg", {"a.jpg", ".exr"});
  expect_wrong(std::string(fast_render) + "no/a.exr", {"no/a.exr", "does not exist"});
  expect_wrong(std::string(fast_render) + "a.exr --threads 0", {"--threads", "1"});
  expect_wrong("dataset make slab_uniform --out d --size 0", {"--size"});
  expect_wrong("dataset make slab_uniform --out scene.json", {"scene.json", "is a file"});
}

TEST_F(Cli, ProfilesAreComparedAndTabulated) {
  const std::string medium = " --sigma-a 0.1 --sigma-s-prime 1 --eta 1.3 --r 0:4:2 ";
  const json one = json::parse(run("profile --json" + medium).out);
  EXPECT_EQ(one["model"], "standard_dipole");
  EXPECT_EQ(one["channels"][0]["r"], (std::vector<double>{0, 2, 4}));
  EXPECT_EQ(one["channels"][0]["R"].size(), 3u);
  EXPECT_GT(one["channels"][0]["total"], one["channels"][0]["cumulative"][2]);

  const Ending two = run("profile --json --model standard_dipole --model multipole --set thickness_mm=1" + medium);
  const json models = json::parse(two.out)["models"];
  EXPECT_THAT(two.err, AllOf(HasSubstr("outside the domain of multipole"), HasSubstr("1.1 transport mean free paths")));
  EXPECT_EQ(models[0]["channels"], one["channels"]);
  EXPECT_EQ(models[1]["channels"][0]["T"].size(), 3u);
  EXPECT_NE(models[1]["against_standard_dipole"][0]["mean_abs_log_ratio"], 0);

  const Ending stack = run("profile --model layered --all --layer 0.01,1,1.4,3 --layer 0.1,2,1.4,inf --r 0:4:2");
  EXPECT_EQ(stack.out.rfind("r_mm,R_per_mm2,cumulative,T_per_mm2\n0,", 0), 0u) << stack.out;
  folder_.write("measured.csv", "r,R\n0.1,2\n0.2,1\n0.5,0.1\n");
  const Ending measured = run("profile --model tabulated --set samples=measured.csv --r 0.1:0.5:0.4");
  EXPECT_EQ(measured.out, "r_mm,R_per_mm2\n0.1,2\n0.5,0.1\n");
  const json list = json::parse(run("profile list --json").out);
  EXPECT_GE(list.size(), 11u);
  for (const json& row : list) EXPECT_NE(row["citation"], "");
}

TEST_F(Cli, WrongProfileParametersAreNamed) {
  folder_.write("bad.csv", "r,R\n0.1,2\n0.2,1\n\n0.3,-1\n");
  expect_wrong("profile --model tabulated --set samples=bad.csv", {"bad.csv: line 5", "R must be positive"});
  expect_wrong("profile --model tabulated --set samples=none.csv", {"none.csv"});
  expect_wrong("profile --model tabulated", {"tabulated", "needs samples"});
  expect_wrong("profile --model multipole --material skin1 --set thick=1", {"thick", "thickness_mm", "index_below"});
  expect_wrong("profile --model multipole --material skin1 --set thickness_mm=0", {"thickness_mm", "1e-60"});
  expect_wrong("profile --model layered --layer 1,2", {"1,2", "sigma_a,sigma_s_prime,eta,thickness_mm"});
  expect_wrong("profile --model layered --layer 1,2,1.3,inf --layer 1,2,1.3,inf", {"thickness_mm"});
  expect_wrong("profile --model layers --material skin1", {"layers", "layered"});
}

TEST_F(Cli, RendersWithStats) {
  const Ending e = run(std::string(fast_render) + "a.exr --png a.png --stats s.json --set max_relative_error=1e-2");
  ASSERT_EQ(e.status, 0) << e.err;
  EXPECT_EQ(e.out + e.err, "");
  EXPECT_TRUE(fs::exists(folder_.file("a.png")));
  const Image image = read_image(folder_.file("a.exr"));
  EXPECT_EQ(image.width, 16);
  EXPECT_GT(image.at(8, 8, 0), 0);
  const json stats = json::parse(content(folder_.file("s.json")));
  EXPECT_EQ(stats.at("technique"), "hierarchical");
  EXPECT_EQ(stats.at("backend"), "cpu");
  EXPECT_FALSE(stats.at("device").get<std::string>().empty());
  EXPECT_EQ(stats.at("settings").at("max_relative_error"), 1e-2);
  EXPECT_EQ(stats.at("settings").at("samples"), 500);
  EXPECT_GE(stats.at("counters").at("done").at("surface_cells"), 500);
  EXPECT_TRUE(stats.at("counters").at("skipped").is_object());
  EXPECT_GT(stats.at("peak_rss_bytes"), 1'000'000);
  double sum = 0;
  for (const char* stage : {"load", "gbuffer", "irradiance", "prepare", "render"}) {
    EXPECT_GE(stats.at("seconds").at(stage), 0);
    sum += stats.at("seconds").at(stage).get<double>();
  }
  EXPECT_GE(stats.at("seconds").at("total"), sum);
}

TEST_F(Cli, APathTracedPictureHasAVarianceLayerAndCompares) {
  const std::string trace = "render scene.json --technique path_traced --set paths=4 --out ";
  const Ending e = run(trace + "a.exr --png a.png --stats s.json --seed 3");
  ASSERT_EQ(e.status, 0) << e.err;
  const Image image = read_image(folder_.file("a.exr"));
  const int variance = image.channel("variance.G");
  ASSERT_GE(variance, 0);
  EXPECT_GT(image.at(8, 8, image.channel("G")), 0);
  EXPECT_GT(image.at(8, 8, variance), 0);
  EXPECT_EQ(image.at(0, 0, variance), 0);
  const json stats = json::parse(content(folder_.file("s.json")));
  EXPECT_EQ(stats.at("settings").at("paths"), 4);
  EXPECT_GT(stats.at("counters").at("done").at("scatterings"), 0);
  ASSERT_EQ(run(trace + "b.exr --seed 3 --threads 1").status, 0);
  EXPECT_EQ(run("compare a.exr b.exr --max-rmse 0").status, 0);
  ASSERT_EQ(run(trace + "c.exr --seed 4").status, 0);
  EXPECT_EQ(run("compare c.exr b.exr --max-rmse 0").status, 1);
  expect_wrong("render scene.json --technique path_traced --out a.exr --set paths=1.5",
               {"paths", "1.5", "whole number"});
  folder_.write("open.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\n");
  json open = test::valid_document();
  open["objects"] = {{{"mesh", "open.obj"}, {"material", "m1"}}};
  folder_.write("open.json", open.dump());
  expect_wrong("render open.json --technique path_traced --out a.exr", {"open.json", "not closed"});
}

TEST_F(Cli, ThreadsDoNotChangeAPixelAndExitLobesDifferByAConstant) {
  ASSERT_EQ(run(std::string(fast_render) + "one.exr --threads 1").status, 0);
  ASSERT_EQ(run(std::string(fast_render) + "two.exr --threads 2").status, 0);
  ASSERT_EQ(run(std::string(fast_render) + "jensen.exr --threads 2 --exit-lobe jensen").status, 0);
  const Image n = read_image(folder_.file("one.exr")), j = read_image(folder_.file("jensen.exr"));
  EXPECT_EQ(n.data, read_image(folder_.file("two.exr")).data);
  const float ratio = j.at(8, 8, 1) / n.at(8, 8, 1);
  EXPECT_NEAR(ratio, 0.94, 0.01) << "6 % darker at eta 1.3";
  EXPECT_NEAR(j.at(10, 6, 2), ratio * n.at(10, 6, 2), 1e-6);
}

TEST_F(Cli, ComparesAndFailsTheGate) {
  Image image(2, 2, {"R", "G", "B", "A"});
  std::fill(image.data.begin(), image.data.end(), 1.0f);
  write_exr(folder_.file("ref.exr"), image);
  for (std::size_t i = 0; i < 16; i += 4) image.data[i] = 1.3f;
  write_exr(folder_.file("img.exr"), image);
  const Ending e = run("compare img.exr ref.exr --json --max-rmse 0.2");
  EXPECT_EQ(e.status, 0) << e.err;
  const json metrics = json::parse(e.out).at("metrics");
  EXPECT_NEAR(metrics.at("rmse").get<double>(), 0.3 / std::sqrt(3.0), 1e-6);
  EXPECT_NEAR(metrics.at("mean_error").get<double>(), 0.1, 1e-6);
  EXPECT_NEAR(metrics.at("max").get<double>(), 0.3, 1e-6);
  EXPECT_NEAR(metrics.at("per_channel").at("R").at("relative_rmse").get<double>(), 0.3, 1e-6);
  // sum(i r) / sum(i^2) of values 1.3, 1, 1.
  EXPECT_NEAR(metrics.at("scale_factor").get<double>(), 3.3 / 3.69, 1e-6);
  EXPECT_GT(metrics.at("flip"), 0);
  EXPECT_EQ(run("compare img.exr ref.exr --max flip=0.9 --max mean_error=0.2 --min psnr=10").status, 0);
  const Ending both = run("compare img.exr ref.exr --max max=0.2 --min psnr=40");
  EXPECT_EQ(both.status, 1);
  EXPECT_THAT(both.err, AllOf(HasSubstr("max 0.3"), HasSubstr("psnr"), HasSubstr("below the limit 40")));
  const Ending failed = run("compare img.exr ref.exr --max-relative-rmse 0.1 --error-image e.exr");
  EXPECT_EQ(failed.status, 1);
  EXPECT_THAT(failed.err, AllOf(HasSubstr("relative_rmse"), HasSubstr("0.1")));
  EXPECT_NEAR(read_image(folder_.file("e.exr")).at(1, 1, 0), 0.3, 1e-6);
}

TEST_F(Cli, RefusesToCompareWhatCannotBe) {
  Image small(2, 2, {"R", "G", "B"}), large(3, 2, {"R", "G", "B"});
  write_exr(folder_.file("small.exr"), small);
  write_exr(folder_.file("large.exr"), large);
  small.at(1, 0, 2) = std::nanf("");
  write_exr(folder_.file("nan.exr"), small);
  expect_wrong("compare small.exr large.exr", {"2 x 2", "3 x 2"});
  expect_wrong("compare small.exr small.exr --max flop=1", {"--max", "flop", "flip"});
  expect_wrong("compare small.exr small.exr --min psnr", {"--min", "psnr", "METRIC=NUMBER"});
  expect_wrong("compare small.exr small.exr --min psnr=high", {"--min", "high"});
  expect_wrong("compare small.exr nan.exr", {"nan.exr", "pixel (1, 0)"});
}

TEST_F(Cli, MakesADatasetThatComparesAsItsNoise) {
  const Ending e = run("dataset make sphere_wholemilk --out d --size 24 --noise 0.04 --samples 2000 --threads 2");
  ASSERT_EQ(e.status, 0) << e.err;
  const json compared = json::parse(run("compare d/target.exr d/clean.exr --json").out);
  // The deviation of n values scatters by 1 / sqrt(2 n).
  const double n = 3 * compared.at("pixels").get<double>();
  EXPECT_GT(n, 600);
  EXPECT_NEAR(compared.at("metrics").at("relative_rmse").get<double>(), 0.04, 0.04 * 5 / std::sqrt(2 * n));
  // The recipe's own settings, so that every pixel must come again.
  const std::string settings =
      "--technique hierarchical --set max_relative_error=1e-4 --set discretisation=fixed --samples 2000";
  ASSERT_EQ(run("render d/truth_scene.json " + settings + " --out again.exr").status, 0);
  EXPECT_EQ(run("compare again.exr d/clean.exr --max-rmse 0").status, 0);
  EXPECT_EQ(run("render d/scene.json --technique hierarchical --samples 2000 --out start.exr").status, 0);
  EXPECT_EQ(run("compare start.exr d/clean.exr --max-relative-rmse 0.05").status, 1) << "the start isn't the answer";
}

TEST_F(Cli, WithoutGlTheGpuBackendEndsWith3AndTheProcessorWorks) {
  // Found first and no libraries at all: a machine without GL.
  const std::string folder = folder_.file("lib");
  fs::create_directory(folder);
  for (const char* name : {"lib/libOSMesa.so.8", "lib/libEGL.so.1"}) folder_.write(name, "not a library\n");
  const std::string no_gl = "LD_LIBRARY_PATH='" + folder + "'";
  const Ending gpu = run(std::string(fast_render) + "a.exr --backend gpu", no_gl);
  EXPECT_EQ(gpu.status, 3);
  EXPECT_THAT(gpu.err, AllOf(HasSubstr("no OpenGL 4.3"), HasSubstr("libOSMesa.so.8"), HasSubstr("libEGL.so.1")));
  EXPECT_FALSE(fs::exists(folder_.file("a.exr")));
  EXPECT_EQ(run(std::string(fast_render) + "a.exr", no_gl).status, 0);
}

TEST_F(Cli, ListsRecipesAndTechniques) {
  const json rows = json::parse(run("dataset list --json").out);
  EXPECT_GE(rows.size(), 8u);
  EXPECT_EQ(rows.at(0).at("film").at("width"), 256);
  const Ending e = run("render --list");
  EXPECT_EQ(e.status, 0);
  EXPECT_THAT(e.out, AllOf(HasSubstr("brute_force"), HasSubstr("Jensen"), HasSubstr("max_relative_error=1e-3")));
}

TEST_F(Cli, WalksAndComparesModelsWithTransport) {
  const std::string medium = "--sigma-a 0.1 --sigma-s-prime 0.9 --eta 1.5 --walks 200000 --r 0:2:1";
  const json walk = json::parse(run("transport walk " + medium).out);
  const json reflected = walk.at("reflected");
  // Giovanelli's half space, per flux that has entered (science notes B.1).
  const double error = reflected.at("standard_error");
  EXPECT_LT(std::abs(reflected.at("value").get<double>() - .229082), 4 * error);
  EXPECT_LT(error, 2e-3);
  EXPECT_EQ(walk.at("reflectance").size(), 2u);
  const json slab = json::parse(run("transport walk --thickness 1 " + medium).out);
  EXPECT_GT(slab.at("transmitted").at("value").get<double>(), .1);
  const Ending errors = run("transport errors");
  EXPECT_THAT(errors.out, AllOf(HasSubstr("| standard_dipole | "), HasSubstr("eta 1.5"), HasSubstr("| 0.999 |")));
  expect_wrong("transport walk --sigma-a 0.1 --sigma-s-prime 0.9 --eta 1.5 --thickness 0", {"--thickness"});
  expect_wrong("transport walk --sigma-a 0.1,1,1 --sigma-s-prime 0.9 --eta 1.5", {"--sigma-a", "one channel"});
  expect_wrong("transport table --out no/table.inc", {"--out", "no/table.inc"});
}

}  // namespace
}  // namespace opaline
