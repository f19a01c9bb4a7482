#include "model/materials/exchange.h"

#include <cmath>
#include <stdexcept>

namespace opaline {
namespace exchange {

using Settings = ExchangeSettings;
std::string write_pbrt_subsurface(const ExchangeMaterial&, const Settings&);
std::string write_pbrt_medium(const ExchangeMaterial&, const Settings&);
std::string write_mitsuba(const ExchangeMaterial&, const Settings&);
std::string write_openpbr(const ExchangeMaterial&, const Settings&);
std::string write_standard_surface(const ExchangeMaterial&, const Settings&);
std::string write_cycles(const ExchangeMaterial&, const Settings&);
std::string write_cycles_legacy(const ExchangeMaterial&, const Settings&);
std::string write_gltf(const ExchangeMaterial&, const Settings&);
std::string write_unreal(const ExchangeMaterial&, const Settings&);
std::string write_unity(const ExchangeMaterial&, const Settings&);
ExchangeMaterial read_pbrt(const std::string&, const Settings&);
ExchangeMaterial read_mitsuba(const std::string&, const Settings&);
ExchangeMaterial read_openpbr(const std::string&, const Settings&);
ExchangeMaterial read_standard_surface(const std::string&, const Settings&);
ExchangeMaterial read_cycles(const std::string&, const Settings&);
ExchangeMaterial read_cycles_legacy(const std::string&, const Settings&);
ExchangeMaterial read_gltf(const std::string&, const Settings&);
ExchangeMaterial read_unreal(const std::string&, const Settings&);
ExchangeMaterial read_unity(const std::string&, const Settings&);

}  // namespace exchange

namespace {

constexpr const char* openpbr_source = "OpenPBR Surface specification 1.1, Subsurface; MaterialX open_pbr_surface";

std::vector<ExchangeFormat> all_formats() {
  using namespace exchange;
  return {
      {"pbrt", "pbrt", "pbrt-v4, Material \"subsurface\"",
       "sigma_a, sigma_s (unreduced, with g) in 1/mm; scale = mm per scene unit; no albedo",
       "pbrt-v4 file format, subsurface: sigma_a and sigma_s in mm^-1, scaled by scale", 1, false,
       write_pbrt_subsurface, read_pbrt},
      {"pbrt_medium", "pbrt", "pbrt-v4, homogeneous named medium inside a dielectric",
       "sigma_a, sigma_s (unreduced, with g) in 1/mm; scale = mm per scene unit; no albedo",
       "pbrt-v4 file format, MakeNamedMedium homogeneous", 1, false, write_pbrt_medium, read_pbrt},
      {"mitsuba", "xml", "Mitsuba 3, homogeneous medium inside a dielectric",
       "sigma_t in 1/mm with scale = mm per scene unit; albedo = sigma_s/sigma_t, single scattering, unreduced; hg "
       "phase g",
       "Mitsuba 3 documentation, plugin homogeneous (sigma_t and albedo only) and hg", 1, false, write_mitsuba,
       read_mitsuba},
      {"openpbr", "mtlx", "OpenPBR Surface as MaterialX",
       "subsurface_radius x subsurface_radius_scale = 1/sigma_t in scene units (unreduced); subsurface_color by the "
       "chosen meaning of colour",
       openpbr_source, 1, true, write_openpbr, read_openpbr},
      {"standard_surface", "mtlx", "Autodesk Standard Surface as MaterialX",
       "subsurface_radius x subsurface_scale = 1/sigma_t in scene units; subsurface_color by the chosen meaning of "
       "colour",
       "MaterialX standard_surface; subsurface_bsdf of the MaterialX physically based shading nodes", 1, true,
       write_standard_surface, read_standard_surface},
      {"cycles", "py", "Blender Cycles, Principled BSDF, Random Walk since 2026",
       "Subsurface Radius x Scale = 1/sigma_t in scene units; Base Color by the chosen meaning of colour (Cycles: "
       "van_de_hulst)",
       "Blender commit e5f416414 (2026), which took the factor 1/(4 pi) out", 1, true, write_cycles, read_cycles},
      {"cycles_legacy", "py", "Blender Cycles, Principled BSDF of files up to 5.x (Burley, Random Walk)",
       "Subsurface Radius x Scale = 4 pi/sigma_t' in scene units; Base Color by the chosen meaning of colour",
       "Blender, bssrdf_setup_radius (4 pi in both methods; Burley's d = l/s(A) is applied inside)", 1, true,
       write_cycles_legacy, read_cycles_legacy},
      {"gltf", "json", "glTF material with KHR_materials_volume and KHR_materials_volume_scatter",
       "extinction sigma_t = -ln(attenuationColor)/attenuationDistance in metres; multiscatterColor by the chosen "
       "meaning "
       "of colour (glTF: van_de_hulst)",
       "Khronos glTF pull request 2453 (draft); attenuation read as extinction, not absorption", 1000, true, write_gltf,
       read_gltf},
      {"unreal", "json", "Unreal Engine, subsurface profile (Burley, mean free path)",
       "mean_free_path_color x mean_free_path_distance x world_unit_scale = 1/sigma_t' in cm; surface_albedo by the "
       "chosen "
       "meaning of colour",
       "Unreal Engine API, FSubsurfaceProfileStruct with bEnableBurley and bEnableMeanFreePath", 1, true, write_unreal,
       read_unreal},
      {"unity", "json", "Unity HDRP, diffusion profile",
       "scattering distance d = 1/(sigma_t' s(A)) in mm with Burley's s; max radius holds 99.7 %; base_color is A by "
       "the "
       "chosen meaning of colour",
       "Unity HDRP diffusion profile: shape parameter S = 1/D; Christensen, Burley 2015 for s(A)", 1000, true,
       write_unity, read_unity},
  };
}

void check(const ExchangeMaterial& m) {
  const auto fail = [&](const std::string& what) { throw std::invalid_argument("the material's " + what); };
  for (std::size_t c = 0; c < 3; ++c) {
    const double a = m.sigma_a[c], s = m.sigma_s_prime[c];
    if (!std::isfinite(a) || a < 0) fail("sigma_a must be finite and not below 0 (1/mm)");
    if (!std::isfinite(s) || s < 0) fail("sigma_s' must be finite and not below 0 (1/mm)");
    if (!(a + s > 0)) fail("sigma_a + sigma_s' must be above 0 in every channel");
  }
  if (!(m.eta > 0) || !std::isfinite(m.eta)) fail("eta must be above 0");
  if (!(std::abs(m.g) < 1)) fail("g must lie between -1 and 1");
}

ExchangeSettings completed(const ExchangeFormat& format, ExchangeSettings settings) {
  if (settings.mm_per_unit == 0) settings.mm_per_unit = format.mm_per_unit;
  if (!(settings.mm_per_unit > 0) || !std::isfinite(settings.mm_per_unit))
    throw std::invalid_argument("mm per unit must be above 0");
  return settings;
}

}  // namespace

const std::vector<ExchangeFormat>& exchange_formats() {
  static const std::vector<ExchangeFormat> formats = all_formats();
  return formats;
}

const ExchangeFormat& find_exchange_format(const std::string& name) {
  std::string names;
  for (const ExchangeFormat& format : exchange_formats()) {
    if (format.name == name) return format;
    names += (names.empty() ? "" : ", ") + format.name;
  }
  throw std::invalid_argument("no format '" + name + "'; valid: " + names);
}

std::string write_material(const ExchangeFormat& format, const ExchangeMaterial& material, ExchangeSettings settings) {
  check(material);
  return format.write(material, completed(format, settings));
}

ExchangeMaterial read_material(const ExchangeFormat& format, const std::string& text, ExchangeSettings settings) {
  const ExchangeMaterial material = format.read(text, completed(format, settings));
  check(material);
  return material;
}

}  // namespace opaline
