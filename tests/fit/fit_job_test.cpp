// The fit from files to files: what it finds, reports and writes.
#include "tests/support/fit_job_fixture.h"

#include <limits>
#include <set>

namespace opaline {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using test::FitJobTest;
using test::sphere_document;
using ::testing::AllOf;
using ::testing::HasSubstr;

std::set<std::string> keys(const json& object) {
  std::set<std::string> names;
  for (const auto& [name, value] : object.items()) names.insert(name);
  return names;
}

TEST_F(FitJobTest, RecoversTheMaterialAndReportsIt) {
  std::vector<std::string> stages;
  const FitReport report =
      run_fit(job_, synthetic_shapes(), [&](const std::string& stage) { stages.push_back(stage); });
  EXPECT_EQ(stages, (std::vector<std::string>{"load", "operator 1/1", "reduce", "solve", "check"}));
  const Material truth = test::library_material("skin1");
  for (int c = 0; c < 3; ++c) {
    const ParameterEstimate& a = report.uncertainty.parameters[static_cast<std::size_t>(c)];
    EXPECT_LT(std::abs(a.value - truth.sigma_a[c]), 4 * a.sd);
    EXPECT_DOUBLE_EQ(a.value, report.material.sigma_a[c]);
  }
  EXPECT_EQ(report.material.name, "m1");
  EXPECT_EQ(report.material.g, 0.25);
  EXPECT_LT(report.solution.relative_rmse, 1.05 * 0.01);
  ASSERT_EQ(report.targets.size(), 1u);
  const FittedTarget& t = report.targets[0];
  EXPECT_LT(t.operator_error.rms, 2e-3);
  EXPECT_GT(t.operator_error.rms, 0);
  EXPECT_GT(t.operator_error.at_most, t.operator_error.rms);
  EXPECT_LT(t.operator_error.at_most, t.operator_error.rms + 2e-4);
  EXPECT_GT(t.counters.done.at("rows"), 50u);
  std::size_t fitted = 0;
  for (std::size_t p = 0; p < t.picture.pixel_count(); ++p) {
    fitted += t.difference.data[4 * p + 3] > 0;
    for (std::size_t c = 0; c < 3; ++c) {
      EXPECT_EQ(t.difference.data[4 * p + c], t.refit.data[4 * p + c] - t.picture.data[4 * p + c]);
      EXPECT_EQ(t.picture.data[4 * p + c], t.difference.data[4 * p + 3] > 0 ? picture_.data[4 * p + c] : 0);
    }
  }
  EXPECT_EQ(fitted, t.counters.done.at("rows"));
  EXPECT_GE(report.total_seconds, report.operator_seconds + report.solve_seconds);
}

TEST_F(FitJobTest, SearchesOnlyWhatTheOperatorResolves) {
  const FitReport report = run(job_);
  // r_0 is a fraction of the sphere's bounding diagonal.
  const double r_0 = job_.op.core_fraction * 10 * std::sqrt(3.0);
  EXPECT_NEAR(report.solution.bounds.sigma_max * r_0, 1, 0.01);
  EXPECT_EQ(job_.solve.bounds.sigma_max, 1e4);
}

TEST_F(FitJobTest, FixedParametersStayExactlyAsInTheScene) {
  job_.scenes = {scene_with("known.json", "/materials/m1/sigma_a_per_mm", {0, 0.17, 0.48})};
  job_.solve.free = parse_free("sigma_s_prime");
  const FitReport report = run(job_);
  EXPECT_EQ(report.material.sigma_a, Rgb(0, 0.17, 0.48));
  EXPECT_EQ(report.material.eta, 1.3);
  EXPECT_NE(report.material.sigma_s_prime, Rgb(0.74, 0.88, 1.01));
  const json document = fit_json(report);
  EXPECT_FALSE(document["parameters"]["sigma_a_per_mm"]["free"]);
  EXPECT_TRUE(document["parameters"]["sigma_s_prime_per_mm"]["free"]);
  EXPECT_FALSE(document["parameters"]["eta"]["free"]);
}

TEST_F(FitJobTest, TheJsonHasWhatIsPromised) {
  const FitReport report = run(job_);
  const json document = json::parse(fit_json(report).dump());
  for (const char* key : {"parameters", "rmse", "relative_rmse", "noise_sd", "correlation", "starts", "iterations",
                          "seconds", "notes", "converged", "model", "targets", "alpha_prime"})
    EXPECT_TRUE(document.contains(key)) << key;
  EXPECT_EQ(keys(document["parameters"]), (std::set<std::string>{"sigma_a_per_mm", "sigma_s_prime_per_mm", "eta"}));
  EXPECT_EQ(document["starts"], 2);
  EXPECT_EQ(document["start_records"].size(), 2u);
  EXPECT_GT(document["iterations"], 2);
  EXPECT_EQ(keys(document["seconds"]), (std::set<std::string>{"operator", "solve", "total"}));
  for (const char* name : {"sigma_a_per_mm", "sigma_s_prime_per_mm"}) {
    const json& group = document["parameters"][name];
    for (const char* key : {"value", "sd", "ci95", "identifiable"}) ASSERT_EQ(group[key].size(), 3u) << key;
    for (std::size_t c = 0; c < 3; ++c) {
      const double value = group["value"][c], low = group["ci95"][c][0], high = group["ci95"][c][1];
      EXPECT_LT(low, value);
      EXPECT_LT(value, high);
      EXPECT_GT(group["sd"][c], 0);
      EXPECT_TRUE(group["identifiable"][c].is_boolean());
    }
  }
  const json& eta = document["parameters"]["eta"];
  EXPECT_TRUE(eta["value"].is_number() && eta["sd"].is_number() && eta["identifiable"].is_boolean());
  EXPECT_EQ(eta["ci95"].size(), 2u);
  ASSERT_EQ(document["correlation"].size(), 7u);
  for (const json& row : document["correlation"]) EXPECT_EQ(row.size(), 7u);
  EXPECT_EQ(document["correlation_order"][6], "eta");
  EXPECT_NEAR(document["noise_sd"].get<double>() / document["rmse"].get<double>(), 1, 0.1);
  EXPECT_EQ(document["alpha_prime"]["value"].size(), 3u);
  EXPECT_EQ(document["targets"][0]["target"], job_.targets[0]);
  EXPECT_GT(document["targets"][0]["counters"]["done"]["rows"], 0);
}

TEST_F(FitJobTest, WhatNobodyKnowsIsNull) {
  FitReport report = run(job_);
  report.uncertainty.parameters[1].sd = std::numeric_limits<double>::infinity();
  report.uncertainty.correlation(0, 1) = std::nan("");
  report.solution.starts[0].cost = std::nan("");
  const json document = fit_json(report);
  EXPECT_TRUE(document["parameters"]["sigma_a_per_mm"]["sd"][1].is_null());
  EXPECT_TRUE(document["correlation"][0][1].is_null());
  EXPECT_TRUE(document["start_records"][0]["cost"].is_null());
}

TEST_F(FitJobTest, WritesAllItsFiles) {
  const FitReport report = run(job_);
  const std::string out = folder_.file("results/first");
  const std::vector<std::string> written = write_fit(report, out);
  EXPECT_EQ(written.size(), 9u);
  std::set<std::string> names;
  for (const std::string& path : written) {
    EXPECT_GT(fs::file_size(path), 0u) << path;
    names.insert(fs::path(path).filename().string());
  }
  EXPECT_EQ(names, (std::set<std::string>{"fit.json", "report.html", "material.json", "target.exr", "target.png",
                                          "refit.exr", "refit.png", "difference.exr", "difference.png"}));
  EXPECT_EQ(static_cast<std::size_t>(std::distance(fs::directory_iterator(out), {})), written.size());
  EXPECT_EQ(read_json_file(out + "/fit.json"), fit_json(report));
  EXPECT_EQ(read_image(out + "/refit.exr").data, report.targets[0].refit.data);
  // The fitted material can be pasted into a scene.
  json scene = sphere_document();
  scene["materials"]["m1"] = read_json_file(out + "/material.json");
  const Scene pasted = parse_scene(scene, folder_.file("pasted.json"), synthetic_shapes());
  EXPECT_EQ(pasted.materials[0].sigma_a, report.material.sigma_a);
  EXPECT_EQ(pasted.materials[0].eta, report.material.eta);
}

TEST_F(FitJobTest, TwoTargetsGetTheirOwnPictures) {
  json other = sphere_document();
  other["lights"][0]["direction"] = {1, 0, -0.2};
  job_.scenes.push_back(folder_.write("other.json", other.dump()));
  job_.targets.push_back(image_file("other.exr", picture(other)));
  const FitReport report = run(job_);
  EXPECT_EQ(report.targets[1].scene, job_.scenes[1]);
  EXPECT_EQ(report.targets[1].target, job_.targets[1]);
  const std::vector<std::string> written = write_fit(report, folder_.file("two"));
  EXPECT_EQ(written.size(), 15u);
  EXPECT_TRUE(fs::exists(folder_.file("two/difference_2.exr")));
  EXPECT_FALSE(fs::exists(folder_.file("two/refit.exr")));
  EXPECT_EQ(fit_json(report)["targets"].size(), 2u);
}

TEST_F(FitJobTest, AnOutputFolderThatIsAFileIsNamed) {
  const FitReport report = run(job_);
  const std::string file = folder_.write("taken", "text");
  EXPECT_THAT(test::message_of([&] { write_fit(report, file + "/out"); }),
              AllOf(HasSubstr("taken/out"), HasSubstr("output folder")));
}

TEST(SignedColours, AreBlueWhereTooDarkAndRedWhereTooBright) {
  Image difference(5, 1, {"R", "G", "B", "A"});
  const float means[5] = {-2, -0.5f, 0, 0.5f, 2};
  for (int x = 0; x < 5; ++x) {
    for (int c = 0; c < 3; ++c) difference.at(x, 0, c) = means[x];
    difference.at(x, 0, 3) = 1;
  }
  Image colours = signed_colours(difference, 1);
  const auto pixel = [&](int x) { return glm::vec3(colours.at(x, 0, 0), colours.at(x, 0, 1), colours.at(x, 0, 2)); };
  EXPECT_EQ(pixel(0), glm::vec3(0, 0, 1));
  EXPECT_EQ(pixel(1), glm::vec3(0.5f, 0.5f, 1));
  EXPECT_EQ(pixel(2), glm::vec3(1, 1, 1));
  EXPECT_EQ(pixel(3), glm::vec3(1, 0.5f, 0.5f));
  EXPECT_EQ(pixel(4), glm::vec3(1, 0, 0));
  difference.at(0, 0, 3) = 0;  // not fitted: nothing
  colours = signed_colours(difference, 1);
  EXPECT_EQ(pixel(0), glm::vec3(0));
  EXPECT_EQ(colours.at(0, 0, 3), 0);
}

/// Light in some channels only: the others are unknown, and said to be.
class OneColourTest : public FitJobTest, public ::testing::WithParamInterface<bool> {
 protected:
  static json document() {
    json scene = sphere_document();
    scene["lights"][0]["irradiance"] = {3, 0, 2};
    if (GetParam()) {
      json second = scene["lights"][0];
      second["direction"] = {1, 0, -0.2};
      second["irradiance"] = {1, 0, 2};
      scene["lights"].push_back(second);
    }
    return scene;
  }
  OneColourTest() : FitJobTest(document()) {}
};

TEST_P(OneColourTest, ADarkChannelIsNotIdentified) {
  const FitReport report = run(job_);
  const Uncertainty& u = report.uncertainty;
  for (const std::size_t i : {1u, 4u}) {
    EXPECT_FALSE(u.parameters[i].identifiable);
    EXPECT_FALSE(std::isnan(u.parameters[i].sd));
    EXPECT_FALSE(u.parameters[i].reason.empty());
  }
  EXPECT_FALSE(u.alpha_prime[1].identifiable);
  const Material truth = test::library_material("skin1");
  for (const int c : {0, 2}) {
    const ParameterEstimate& e = u.parameters[static_cast<std::size_t>(c)];
    EXPECT_GT(e.sd, 0);
    EXPECT_LT(std::abs(e.value - truth.sigma_a[c]), 4 * e.sd);
  }
  for (int i = 0; i < parameter_count; ++i)
    for (int j = 0; j < parameter_count; ++j) EXPECT_LE(std::abs(u.correlation(i, j)), 1 + 1e-9);
  EXPECT_NO_THROW(fit_json(report).dump());
}

INSTANTIATE_TEST_SUITE_P(OneAndThreeFields, OneColourTest, ::testing::Bool());

}  // namespace
}  // namespace opaline
