#include "render/cmd/render_stats.h"

#include "render/machine.h"

namespace opaline {
namespace {

using Json = nlohmann::ordered_json;

/// Numbers as numbers, words as words.
Json settings_json(const RenderOptions& options, const RenderResult& result) {
  Json json = Json::object();
  const Settings settings(find_technique(options.technique).settings, options.settings);
  for (const SettingSpec& spec : find_technique(options.technique).settings) {
    if (spec.choices.empty() && !spec.text)
      json[spec.key] = settings.number(spec.key);
    else
      json[spec.key] = result.settings.at(spec.key);
  }
  json["samples"] = options.shared.samples;
  json["light_samples"] = options.shared.irradiance.area_samples;
  json["seed"] = options.shared.irradiance.seed;
  json["exit_lobe"] = exit_lobe_name(options.exit_lobe);
  return json;
}

}  // namespace

Json render_stats(const RenderOptions& options, const RenderResult& result, double load, double total) {
  const RenderSeconds& s = result.seconds;
  return {{"technique", options.technique},
          {"backend", result.backend},
          {"device", result.device.empty() ? cpu_device() : result.device},
          {"seconds",
           {{"load", load},
            {"gbuffer", s.gbuffer},
            {"irradiance", s.irradiance},
            {"prepare", s.prepare},
            {"render", s.render},
            {"total", total}}},
          {"counters", {{"done", result.counters.done}, {"skipped", result.counters.skipped}}},
          {"estimates", result.estimates},
          {"notes", result.notes},
          {"peak_rss_bytes", peak_rss_bytes()},
          {"settings", settings_json(options, result)}};
}

}  // namespace opaline
