// Exports come back as they went, in every format; the two meanings of colour are those of the tables.
#include "model/materials/exchange.h"
#include "model/materials/library.h"

#include <gmock/gmock.h>

#include <cmath>
#include <functional>

namespace opaline {
namespace {

using ::testing::HasSubstr;

ExchangeMaterial material_of(const MaterialRow& row, double g) {
  ExchangeMaterial m;
  m.name = "test";
  m.sigma_a = row.sigma_a, m.sigma_s_prime = row.sigma_s_prime, m.eta = row.eta, m.g = g;
  return m;
}

/// Everything but the engines' profiles carries g.
bool has_phase(const ExchangeFormat& format) { return format.name != "unreal" && format.name != "unity"; }

TEST(Exchange, EveryMaterialComesBackFromEveryFormat) {
  for (const ExchangeFormat& format : exchange_formats())
    for (const ColourMeaning colour : {ColourMeaning::van_de_hulst, ColourMeaning::rendered}) {
      if (colour == ColourMeaning::rendered && !format.uses_colour) continue;
      for (std::size_t k = 0; k < material_library().size(); k += colour == ColourMeaning::rendered ? 23 : 1)
        for (const double mm_per_unit : {0.0, 2.5}) {
          const MaterialRow& row = material_library()[k];
          SCOPED_TRACE(format.name + " " + row.name);
          const ExchangeMaterial m = material_of(row, has_phase(format) ? 0.6 : 0);
          const ExchangeSettings settings{mm_per_unit, colour};
          const ExchangeMaterial back = read_material(format, write_material(format, m, settings), settings);
          for (std::size_t c = 0; c < 3; ++c) {
            // An absorption of 0 returns as rounding of sigma_t'.
            EXPECT_NEAR(back.sigma_a[c], m.sigma_a[c], 1e-6 * m.sigma_a[c] + 1e-11 * m.sigma_t_prime(c));
            EXPECT_NEAR(back.sigma_s_prime[c], m.sigma_s_prime[c],
                        1e-6 * m.sigma_s_prime[c] + 1e-11 * m.sigma_t_prime(c));
          }
          EXPECT_NEAR(back.g, m.g, 1e-12);
          EXPECT_NEAR(back.eta, m.eta, 1e-12);
        }
    }
}

TEST(Exchange, FieldsHaveTheirConventionsUnits) {
  ExchangeMaterial m;
  m.sigma_a = {0.1, 0.2, 0.4}, m.sigma_s_prime = {0.9, 0.8, 1.6}, m.g = 0.5, m.eta = 1.4;
  const auto text = [&](const char* name, double mm_per_unit) {
    return write_material(find_exchange_format(name), m, {mm_per_unit, ColourMeaning::van_de_hulst});
  };
  // sigma_s = 1.8, 1.6, 3.2; sigma_t = 1.9, 1.8, 3.6 per mm.
  EXPECT_THAT(text("pbrt", 10), HasSubstr("\"rgb sigma_s\" [ 1.8 1.6000000000000001 3.2000000000000002 ]"));
  EXPECT_THAT(text("pbrt", 10), HasSubstr("\"float scale\" [ 10 ]"));
  EXPECT_THAT(text("pbrt_medium", 1), HasSubstr("MakeNamedMedium \"opaline\""));
  EXPECT_THAT(text("mitsuba", 1), HasSubstr("<rgb name=\"albedo\" value=\"0.9473684210526315"));
  EXPECT_THAT(text("openpbr", 1),
              HasSubstr("<input name=\"subsurface_radius\" type=\"float\" value=\"0.5555555555555"));
  EXPECT_THAT(text("openpbr", 1000),
              HasSubstr("<input name=\"subsurface_radius\" type=\"float\" value=\"0.0005555555555"));
  EXPECT_THAT(text("cycles_legacy", 1), HasSubstr("[\"Subsurface Radius\"].default_value = (12.56637061435917"));
  EXPECT_THAT(text("gltf", 0), HasSubstr("\"attenuationDistance\": 0.000277777777"));  // 1/3.6 mm in metres
  EXPECT_THAT(text("unreal", 0), HasSubstr("\"mean_free_path_distance\": 1,"));        // mm, with a scale of .1 cm
  EXPECT_THAT(text("unreal", 0), HasSubstr("\"world_unit_scale\": 0.1"));
}

TEST(Exchange, TheVanDeHulstColourIsTheFormulaInPrint) {
  for (const double colour : {0.05, 0.1, 0.3, 0.5, 0.7, 0.9, 0.98}) {
    // OpenPBR and Kulla, Conty print the inverse with six digits.
    const double s = 4.09712 + 4.20863 * colour - std::sqrt(9.59217 + 41.6808 * colour + 17.7126 * colour * colour);
    EXPECT_NEAR(van_de_hulst_absorbed(colour), s * s, 2e-5);
    EXPECT_NEAR(van_de_hulst_colour(van_de_hulst_absorbed(colour)), colour, 1e-14);
  }
  EXPECT_EQ(van_de_hulst_absorbed(1.0), 0);
  EXPECT_EQ(van_de_hulst_absorbed(0.0), 1);
  EXPECT_NEAR(1 - van_de_hulst_absorbed(0.5), 0.91171, 1e-5);
}

TEST(Exchange, TheRenderedColourIsTransportsOwn) {
  // 1 - alpha' of colour .5, normal beam per transmitted flux, by deterministic solution elsewhere: eta 1.4 and 1.5.
  EXPECT_NEAR(1 - absorbed_of_colour(0.5, 1.4, ColourMeaning::rendered), 0.97755, 2e-5);
  EXPECT_NEAR(1 - absorbed_of_colour(0.5, 1.5, ColourMeaning::rendered), 0.98232, 2e-5);
  EXPECT_NEAR(1 - absorbed_of_colour(0.5, 1.0, ColourMeaning::rendered), 0.93817, 2e-5);
}

TEST(Exchange, ReducedAndFullAlbedosAreInverse) {
  for (const double g : {-0.5, 0.0, 0.9})
    for (const double absorbed : {1e-9, 1e-3, 0.5, 1.0}) {
      const double full = unreduced_absorbed(absorbed, g);
      EXPECT_NEAR(reduced_absorbed(full, g) / absorbed, 1, 1e-12);
      // (1 - alpha) sigma_t = (1 - alpha') sigma_t' with sigma_t' = sigma_t (1 - g alpha).
      EXPECT_NEAR(full / (absorbed * (1 - g * (1 - full))), 1, 1e-12);
    }
}

std::string message_of(const std::function<void()>& body) {
  try {
    body();
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "nothing was thrown";
}

TEST(Exchange, WhatIsWrongIsNamed) {
  ExchangeMaterial m;
  m.sigma_a = {0.1, 0.1, 0.1}, m.sigma_s_prime = {1, 1, 1};
  const ExchangeFormat& pbrt = find_exchange_format("pbrt");
  EXPECT_THAT(message_of([] { find_exchange_format("maya"); }), HasSubstr("pbrt_medium, mitsuba, openpbr"));
  EXPECT_THAT(message_of([&] { read_material(pbrt, "Material \"subsurface\"\n", {}); }), HasSubstr("float g"));
  std::string two = write_material(pbrt, m, {});
  two.replace(two.find("\"rgb sigma_a\""), 14, "\"rgb sigma_a\" [ 1 2 ]\n");
  EXPECT_THAT(message_of([&] { read_material(pbrt, two, {}); }), HasSubstr("needs 3 numbers"));
  EXPECT_THAT(message_of([&] { write_material(pbrt, m, {-1, {}}); }), HasSubstr("above 0"));
  m.g = 1;
  EXPECT_THAT(message_of([&] { write_material(pbrt, m, {}); }), HasSubstr("g must lie"));
  m.g = 0, m.sigma_a[1] = std::nan("");
  EXPECT_THAT(message_of([&] { write_material(pbrt, m, {}); }), HasSubstr("sigma_a"));
  EXPECT_THAT(message_of([] { parse_colour_meaning("albedo"); }), HasSubstr("van_de_hulst, rendered"));
}

}  // namespace
}  // namespace opaline
