// Names, transforms and bounds of the parameters; what "--free" may say.
#include "fit/parameters.h"
#include "tests/render/scene_fixture.h"
#include "tests/support/render_fixture.h"

#include <gmock/gmock.h>

#include <set>

namespace opaline {
namespace {

using ::testing::HasSubstr;

TEST(Parameters, HaveSevenNames) {
  std::set<std::string> names;
  for (int i = 0; i < parameter_count; ++i) names.insert(parameter_name(i));
  EXPECT_EQ(names, (std::set<std::string>{"sigma_a_per_mm[R]", "sigma_a_per_mm[G]", "sigma_a_per_mm[B]",
                                          "sigma_s_prime_per_mm[R]", "sigma_s_prime_per_mm[G]",
                                          "sigma_s_prime_per_mm[B]", "eta"}));
  EXPECT_EQ(parameter_name(0), "sigma_a_per_mm[R]");
  EXPECT_EQ(parameter_name(5), "sigma_s_prime_per_mm[B]");
  EXPECT_EQ(parameter_name(eta_index), "eta");
}

TEST(Parameters, AMaterialSurvivesTheRoundTrip) {
  Material material = test::library_material("skin1");
  material.g = 0.7;
  const ParameterVector p = to_parameters(material, {});
  EXPECT_DOUBLE_EQ(p[1], std::log(0.17));
  EXPECT_DOUBLE_EQ(p[5], std::log(1.01));
  EXPECT_EQ(p[6], material.eta);
  const Material back = to_material(p, material);
  for (int c = 0; c < 3; ++c) {
    EXPECT_DOUBLE_EQ(back.sigma_a[c], material.sigma_a[c]);
    EXPECT_DOUBLE_EQ(back.sigma_s_prime[c], material.sigma_s_prime[c]);
    EXPECT_DOUBLE_EQ(natural_value(c, p[static_cast<std::size_t>(c)]), material.sigma_a[c]);
  }
  EXPECT_EQ(back.eta, material.eta);
  EXPECT_EQ(back.name, material.name);
  EXPECT_EQ(back.g, 0.7);
  EXPECT_EQ(natural_value(eta_index, 1.4), 1.4);
}

TEST(Parameters, ZeroAbsorptionStartsAtTheSmallestCoefficient) {
  Material material;
  material.sigma_a = {0, 1, 1e-9};
  const ParameterVector p = to_parameters(material, {});
  EXPECT_DOUBLE_EQ(p[0], std::log(1e-6));
  EXPECT_DOUBLE_EQ(p[1], 0);
  EXPECT_DOUBLE_EQ(p[2], std::log(1e-6));
}

TEST(Parameters, BoundsAreThoseOfTheSolversScale) {
  const ParameterBounds bounds{1e-3, 1e2, 1.1, 1.7};
  for (int i = 0; i < eta_index; ++i) {
    EXPECT_DOUBLE_EQ(bounds.lower(i), std::log(1e-3));
    EXPECT_DOUBLE_EQ(bounds.upper(i), std::log(1e2));
  }
  EXPECT_EQ(bounds.lower(eta_index), 1.1);
  EXPECT_EQ(bounds.upper(eta_index), 1.7);
}

TEST(Parameters, FreeWordsInAnyOrder) {
  const FreeParameters all = parse_free("eta,sigma_a,sigma_s_prime");
  for (int i = 0; i < parameter_count; ++i) EXPECT_TRUE(all.is_free(i));
  const FreeParameters one = parse_free("sigma_s_prime");
  for (int i = 0; i < parameter_count; ++i) EXPECT_EQ(one.is_free(i), i >= 3 && i < 6) << i;
  EXPECT_TRUE(parse_free("eta").is_free(eta_index));
  EXPECT_FALSE(parse_free("sigma_a").is_free(eta_index));
}

TEST(Parameters, SingleChannelsAreFreeOrHaveAPrior) {
  const FreeParameters free = parse_free("sigma_a[G],eta");
  for (int i = 0; i < parameter_count; ++i) EXPECT_EQ(free.is_free(i), i == 1 || i == eta_index) << i;
  const std::vector<Prior> eta = parse_prior("eta=1.4:0.05"), blue = parse_prior("sigma_s_prime[B]=2:0.5");
  ASSERT_EQ(eta.size(), 1u);
  EXPECT_EQ(eta[0].parameter, eta_index);
  EXPECT_EQ(eta[0].mean, 1.4);
  EXPECT_EQ(eta[0].sd, 0.05);
  ASSERT_EQ(blue.size(), 1u);
  EXPECT_EQ(blue[0].parameter, 5);
  EXPECT_DOUBLE_EQ(blue[0].mean, std::log(2.0));
  EXPECT_DOUBLE_EQ(blue[0].sd, 0.25);
  EXPECT_EQ(parse_prior("sigma_a=1:1").size(), 3u);
  for (const char* wrong : {"eta", "eta=1.4", "eta=1.4:", "eta=1.4:-1", "gamma=1:1", "eta=x:1", "sigma_a[X]=1:1"})
    EXPECT_THAT(test::message_of([&] { parse_prior(wrong); }), HasSubstr("--prior")) << wrong;
}

TEST(Parameters, WrongFreeWordsAreNamedWithTheValidOnes) {
  for (const char* wrong : {"sigma_s", "sigma_a,,eta", "eta,ETA", "sigma_a eta"}) {
    const std::string message = test::message_of([&] { parse_free(wrong); });
    EXPECT_THAT(message, HasSubstr("--free"));
    EXPECT_THAT(message, HasSubstr("sigma_a, sigma_s_prime, eta"));
  }
  EXPECT_THAT(test::message_of([] { parse_free("sigma_t"); }), HasSubstr("'sigma_t'"));
  EXPECT_THAT(test::message_of([] { parse_free(""); }), HasSubstr("names no parameter"));
}

}  // namespace
}  // namespace opaline
