// Which form of transport a fit takes: by the pictures, where a flat object is lit and seen along its normal.
#include "fit/straight_view.h"
#include "tests/support/fit_job_fixture.h"

#include <gmock/gmock.h>

namespace opaline {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;

nlohmann::json beam_document() {
  nlohmann::json scene = test::sphere_document();
  scene["film"] = {{"width", 24}, {"height", 24}};
  scene["camera"] = {
      {"type", "orthographic"}, {"position", {0, 0, 5}}, {"look_at", {0, 0, 0}}, {"up", {0, 1, 0}}, {"height", 8}};
  scene["lights"] = {{{"type", "projector"},
                      {"position", {0, 0, 40}},
                      {"look_at", {0, 0, 0}},
                      {"intensity", {5000, 5000, 5000}},
                      {"disk_radius_deg", 1.43}}};
  scene["objects"] = {{{"shape", "slab"}, {"size", {40, 40, 20}}, {"triangles", 2000}, {"material", "m1"}}};
  return scene;
}

Scene scene_of(const nlohmann::json& document) { return parse_scene(document, "scene.json", synthetic_shapes()); }

TEST(StraightView, IsTheLargestAngleOfViewAndLight) {
  nlohmann::json document = beam_document();
  EXPECT_NEAR(off_straight_deg(scene_of(document), 0), 1.43, 0.2);
  document["lights"][0]["position"] = {28.3, 0, 28.3};
  EXPECT_NEAR(off_straight_deg(scene_of(document), 0), 45, 2);
  document["lights"][0]["position"] = {0, 0, 40};
  document["camera"]["position"] = {5, 0, 10};
  EXPECT_NEAR(off_straight_deg(scene_of(document), 0), std::atan(.5) * 180 / pi, 0.1);
  document["lights"] = {{{"type", "directional"}, {"direction", {0, 0, 1}}, {"irradiance", 1}}};
  document["camera"]["position"] = {0, 0, 5};
  EXPECT_NEAR(off_straight_deg(scene_of(document), 0), 0, 1e-3) << "light from below falls on another side";
  EXPECT_EQ(off_straight_deg(scene_of(test::sphere_document()), 0), 180);
}

/// Pictures of both kinds by the operator itself: each fit takes the form that its picture was made with.
class BothForms : public test::FitJobTest {
 protected:
  BothForms() : FitJobTest(beam_document()) {}

  FitReport fit_of(const char* made_with, bool exitance_only = false) {
    const Scene scene = scene_of(beam_document());
    const TransportOperator op = build_operator(scene, 0, EtaNodes(scene.materials[0].eta), job_.op);
    Image picture = operator_image(op, *find_profile(made_with), scene.materials[0]);
    add_noise(picture, 0.01, 1);
    FitJob job = job_;
    job.targets = {image_file("beam.exr", picture)};
    job.model = "transport_table";
    job.exitance_only = exitance_only;
    job.solve.free.eta = false;
    job.solve.starts = 1;
    return run(job);
  }
};

TEST_F(BothForms, TakesTheOneThePictureShows) {
  const FitReport radiance = fit_of("transport_radiance"), exitance = fit_of("transport_table"),
                  held = fit_of("transport_radiance", true);
  EXPECT_EQ(radiance.job.model, "transport_radiance");
  EXPECT_EQ(exitance.job.model, "transport_table");
  EXPECT_EQ(held.job.model, "transport_table");
  EXPECT_THAT(radiance.uncertainty.notes, Contains(HasSubstr("radiance along the normal")));
  EXPECT_THAT(exitance.uncertainty.notes, Contains(HasSubstr("alike in all directions")));
  const ParameterVector truth = to_parameters(scene_of(beam_document()).materials[0], {});
  for (int i = 0; i < eta_index; ++i) {
    const auto at = static_cast<std::size_t>(i);
    const double value = natural_value(i, truth[at]);
    for (const FitReport* report : {&radiance, &exitance}) {
      const ParameterEstimate& e = report->uncertainty.parameters[at];
      EXPECT_LT(std::abs(e.value - value), 4 * e.sd) << parameter_name(i);
    }
  }
  // The wrong form is as far off as the notes say.
  EXPECT_GT(held.solution.relative_rmse, 3 * radiance.solution.relative_rmse);
}

}  // namespace
}  // namespace opaline
