#include "fit/cmd/fit_arguments.h"

#include "model/materials/exchange.h"
#include "render/cmd/render_arguments.h"
#include "render/input_error.h"

namespace opaline {
namespace {

void add_inputs(CLI::App& fit, FitArguments& a) {
  fit.add_option("SCENE", a.job.scenes, "Scene file: shape, camera, light; one for all targets, or one each")
      ->required();
  fit.add_option("--target", a.job.targets, "Picture of the scene, R, G, B or grey; may be repeated")
      ->required()
      ->allow_extra_args(false);
  fit.add_option("--mask", a.job.masks, "Image whose first channel is > 0 where pixels count; one for all, or one each")
      ->allow_extra_args(false);
  fit.add_option("--material", a.job.material, "Which material of the scene to fit (default: the only one)");
  fit.add_option("--free", a.free, "What is unknown; the rest stays as in the scene. One channel: sigma_a[R]")
      ->capture_default_str();
  fit.add_option("--prior", a.priors, "What is known beforehand, NAME=MEAN:SD, e.g. eta=1.4:0.05; may be repeated")
      ->allow_extra_args(false);
  fit.add_option("--model", a.job.model, "Profile; transport_table is transport itself")->capture_default_str();
  fit.add_option("--exit", a.exit,
                 "auto: transport_table is tried as exitance and as radiance where a flat object is lit and seen along "
                 "its normal, and the better one taken; exitance: never the latter")
      ->check(CLI::IsMember({"auto", "exitance"}))
      ->capture_default_str();
  fit.add_option("--out", a.out, "Folder for fit.json, material.json, report and pictures; made if missing")
      ->required();
  fit.add_option("--export", a.exports,
                 "Also write the material for: pbrt, openpbr, ... (`opaline material export --help`)")
      ->delimiter(',')
      ->allow_extra_args(false);
  fit.add_option("--truth", a.truth, "truth.json of a synthetic dataset: adds the true values to the table");
}

void add_correction(CLI::App& fit, FitArguments& a) {
  fit.add_option("--correct-with", a.reference,
                 "Make the fit that of this technique, by renders at the solution: path_traced is transport on the "
                 "object's own shape, hierarchical the operator without its interpolation");
  fit.add_option("--correct-set", a.reference_settings, "Setting of that technique, key=value; may be repeated")
      ->allow_extra_args(false);
  fit.add_option("--correct-steps", a.job.correction.max_steps, "Most corrections, a render each")
      ->check(CLI::Range(1, 100))
      ->capture_default_str();
}

void add_reading(CLI::App& fit, FitArguments& a) {
  fit.add_option("--transfer", a.job.reading.transfer,
                 "What the pictures' values are: linear, srgb, rec709, gamma:G or FILE.csv (encoded,linear). Needed "
                 "unless they are .exr, .hdr or .pfm");
  fit.add_option("--exposure", a.job.exposures, "Linear values are this times the scene's radiance; one, or one each")
      ->allow_extra_args(false);
  fit.add_option("--scale", a.scale, "Is the pictures' brightness known, or free (one factor each)?")
      ->check(CLI::IsMember({"known", "free"}))
      ->capture_default_str();
  fit.add_option("--saturation", a.saturation,
                 "Leave out pixels with a stored value at or above (default .999; none for linear formats)")
      ->check(CLI::PositiveNumber);
  fit.add_option("--exclude-specular", a.job.reading.exclude_specular_deg,
                 "Leave out pixels whose mirror direction is this near a light [deg]")
      ->check(CLI::Range(0.0, 90.0));
  fit.add_option("--noise", a.job.reading.noise,
                 "uniform (from the residual), shared (the same, with correlations between channels), flat (read and "
                 "shot noise from flat regions), layer (the renderer's "
                 "variance), or READ[,SHOT] in the pictures' units")
      ->capture_default_str();
  fit.add_option("--repeat", a.job.repeats, "A second capture of each target: averaged, and the noise from the two")
      ->allow_extra_args(false);
  fit.add_option("--loss", a.loss, "How residuals far outside the noise count")
      ->check(CLI::IsMember({"squares", "huber", "cauchy"}))
      ->capture_default_str();
}

void add_examination(CLI::App& fit, FitArguments& a) {
  fit.add_flag("--compare-models", a.job.compare_models, "Fit every isotropic profile to the same operator");
  fit.add_option("--bootstrap", a.job.bootstrap, "Refits with other noise")->check(CLI::Range(0, 100000));
  fit.add_flag("--advise", a.job.advise, "Say which further picture would tighten the fit most");
  fit.add_flag("--parabola", a.parabola, "Intervals from the curvature alone, without likelihood profiles");
  fit.add_flag("--allow-undetermined", a.allow_undetermined,
               "Exit with 0 and write material.json whatever is determined");
}

void add_numbers(CLI::App& fit, FitArguments& a) {
  fit.add_option("--starts", a.job.solve.starts, "Starting points")->check(CLI::Range(1, 1000))->capture_default_str();
  fit.add_option("--samples", a.job.op.samples, "Surface cells over all objects")
      ->check(CLI::Range(1, 100'000'000))
      ->capture_default_str();
  fit.add_option("--light-samples", a.job.op.irradiance.area_samples,
                 "Directions per cell towards disks and environments")
      ->check(CLI::Range(1, 1'000'000))
      ->capture_default_str();
  fit.add_option("--seed", a.job.op.irradiance.seed, "Of the light samples")->capture_default_str();
  add_threads_option(fit, a.threads);
  fit.add_flag("--json", a.json, "Print fit.json instead of the table");
}

}  // namespace

void add_fit_options(CLI::App& fit, FitArguments& a) {
  add_inputs(fit, a);
  add_correction(fit, a);
  add_reading(fit, a);
  add_examination(fit, a);
  add_numbers(fit, a);
}

void complete(FitArguments& a) {
  a.job.solve.free = parse_free(a.free);
  for (const std::string& name : a.exports) find_exchange_format(name);
  for (const std::string& text : a.priors)
    for (const Prior& prior : parse_prior(text)) a.job.solve.priors.push_back(prior);
  if (a.reference.empty() && !a.reference_settings.empty())
    throw InputError("--correct-set", "", "is for the technique of --correct-with, which is missing");
  if (!a.reference.empty()) {
    a.job.reference.emplace().technique = a.reference;
    a.job.reference->settings = parse_assignments(a.reference_settings, "--correct-set");
  }
  a.job.exitance_only = a.exit == "exitance";
  a.job.scale_free = a.scale == "free";
  a.job.profile_intervals = !a.parabola;
  if (a.saturation >= 0) a.job.reading.saturation = a.saturation;
  using Kind = RobustLoss::Kind;
  a.job.solve.loss.kind = a.loss == "huber" ? Kind::huber : a.loss == "cauchy" ? Kind::cauchy : Kind::squares;
}

}  // namespace opaline
