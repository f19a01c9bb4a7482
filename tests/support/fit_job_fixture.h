// A folder with a small scene and its picture, and the fit of it: what the tests of fit jobs share.
#pragma once

#include "fit/fit_job.h"
#include "fit/fit_output.h"
#include "tests/render/scene_fixture.h"
#include "tests/support/fit_fixture.h"

#include <gmock/gmock.h>

namespace opaline::test {

inline nlohmann::json sphere_document() {
  nlohmann::json scene = valid_document();
  scene["film"] = {{"width", 16}, {"height", 12}};
  scene["camera"]["fov_y_deg"] = 11;
  scene["lights"][0]["direction"] = {-1, 0.3, -0.6};
  scene["objects"] = {{{"shape", "sphere"}, {"radius", 5}, {"triangles", 500}, {"material", "m1"}}};
  return scene;
}

/// A folder with a small scene and its picture with noise.
class FitJobTest : public ::testing::Test {
 protected:
  FitJobTest() : FitJobTest(sphere_document()) {}
  explicit FitJobTest(const nlohmann::json& document) {
    folder_.write("scene.json", document.dump());
    job_.scenes = {folder_.file("scene.json")};
    job_.targets = {folder_.file("target.exr")};
    job_.op = small_operator(800);
    job_.solve.starts = 2;
    job_.model = "standard_dipole";  // what the picture is made with
    write_exr(job_.targets[0], picture_ = picture(document));
  }

  Image picture(const nlohmann::json& document) const {
    const Scene scene = parse_scene(document, folder_.file("scene.json"), synthetic_shapes());
    Image image =
        picture_of(scene, job_.op, "hierarchical", {{"max_relative_error", "1e-4"}, {"discretisation", "fixed"}});
    add_noise(image, 0.01, 1);
    return image;
  }

  /// A copy of the scene with the value at a JSON pointer replaced.
  std::string scene_with(const std::string& name, const std::string& pointer, const nlohmann::json& value) const {
    nlohmann::json document = sphere_document();
    document[nlohmann::json::json_pointer(pointer)] = value;
    return folder_.write(name, document.dump());
  }

  std::string image_file(const std::string& name, const Image& image) const {
    write_exr(folder_.file(name), image);
    return folder_.file(name);
  }

  FitReport run(const FitJob& job) const { return run_fit(job, synthetic_shapes()); }

  /// Expects an InputError whose message has all parts, and nothing written.
  void expect_wrong(const FitJob& job, const std::vector<std::string>& parts) const {
    const std::size_t files = folder_.file_count();
    const std::string message = message_of([&] { write_fit(run(job), folder_.file("out")); });
    for (const std::string& part : parts) EXPECT_THAT(message, ::testing::HasSubstr(part));
    EXPECT_EQ(folder_.file_count(), files) << "something was written";
  }

  TempFolder folder_;
  FitJob job_;
  Image picture_;
};

}  // namespace opaline::test
