// A folder as `opaline validate`, `stress` and `fit` leave it, made up: numbers follow simple laws, so that tests know
// what a report must say. Not measurements.
#pragma once

#include "render/image.h"
#include "validate/record.h"

#include <fmt/format.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

namespace opaline::test {

struct ReportFolder {
  std::size_t records = 60;
  std::size_t pictured = 0;  ///< so many of the first records have images
  bool extras = true;        ///< stress.json, gates.json, fits/
  int side = 32;             ///< of the images
};

/// A lit ball in the middle of the film; `noise` makes its error, tint its colour.
inline Image ball_image(int side, double noise, double brightness = 1) {
  Image image(side, side, {"R", "G", "B", "A"});
  for (int y = 0; y < side; ++y) {
    for (int x = 0; x < side; ++x) {
      const double u = 2.2 * (x + 0.5) / side - 1.1, v = 2.2 * (y + 0.5) / side - 1.1, r2 = u * u + v * v;
      if (r2 > 1) continue;
      const double light = brightness * std::max(0.03, 0.5 * (1 - u) * std::sqrt(1 - r2) + 0.1);
      const double wave = 1 + noise * std::sin(37.0 * x + 11.0 * y * y);
      image.at(x, y, 0) = static_cast<float>(light * wave), image.at(x, y, 1) = static_cast<float>(0.8 * light * wave);
      image.at(x, y, 2) = static_cast<float>(0.5 * light * wave), image.at(x, y, 3) = 1;
    }
  }
  return image;
}

/// The law of the made-up errors and times: error falls as the root of the samples, time grows with them.
inline double law_of_error(std::size_t technique, int samples) {
  return (0.2 + 0.3 * static_cast<double>(technique)) / std::sqrt(samples);
}
inline double law_of_time(std::size_t technique, int samples) {
  return 2e-4 * samples / (1 + static_cast<double>(technique));
}

inline Record made_up_record(const std::string& scene, const std::string& material, const std::string& technique,
                             std::size_t t, const std::string& backend, int samples) {
  Record r;
  const double gpu = backend == "gpu" ? 1.6 : 1;
  r.cell = fmt::format("{:016x}",
                       std::hash<std::string>{}(scene + material + technique + backend + std::to_string(samples)));
  r.suite = "made_up", r.scene = scene, r.material = material, r.technique = technique, r.backend = backend;
  r.settings = {{"samples", std::to_string(samples)}};
  const double time = gpu * law_of_time(t, samples), error = law_of_error(t, samples);
  r.seconds.prepare = make_timing({0.01, 0.012, 0.011});
  r.seconds.render = make_timing({time, 1.02 * time, 0.99 * time});
  if (samples == 64)
    r.seconds.edits = {{"camera", {time + 0.01, 0.01, 0, time}},
                       {"light", {time + 0.03, 0.02, 0.01, time}},
                       {"material", {time + 0.02, 0.01, 0.01, time}}};
  r.error = {{"relative_rmse", error},
             {"rmse", 0.3 * error},
             {"flip", 0.5 * error},
             {"mean_error", -0.1 * error},
             {"psnr", -20 * std::log10(error)}};
  r.truth_error = {{"relative_rmse", error + 0.05}};
  r.reference.certified_relative_error = 8e-4, r.reference.truth_standard_error = 0.01;
  r.peak_rss_bytes = 123'456'789;
  r.done = {{"samples", 1000u * static_cast<unsigned>(samples)}};
  r.skipped = {{"samples", 3000u * static_cast<unsigned>(samples)}, {"equal_channels", 2}};
  r.machine = {"Made-up processor",   2, backend == "gpu" ? "software renderer" : "", "0.1.0", "g++ 12.2.0", "0123abcd",
               "2026-01-02T03:04:05Z"};
  r.seed = 1;
  r.command = fmt::format("opaline render {}.json --technique {} --backend {} --set samples={} --out image.exr", scene,
                          technique, backend, samples);
  return r;
}

/// Scenes x techniques x backends x samples until there are enough; the last technique has no GPU (not applicable), and
/// one cell failed. The first scene's name is hostile to every format.
inline std::vector<Record> made_up_records(std::size_t count) {
  const std::vector<std::string> techniques = {"hierarchical", "image_space_sampling", "brute_force",
                                               "external_renderer"};
  std::vector<Record> records;
  for (int scene = 0; records.size() < count; ++scene) {
    const std::string name = scene == 0 ? "bust <b>\"front\"</b> & 'side' | x" : fmt::format("scene_{}", scene);
    for (std::size_t t = 0; t < techniques.size(); ++t)
      for (const std::string backend : {"cpu", "gpu"})
        for (const int samples : {8, 64, 512}) {
          if (records.size() >= count) break;
          Record r = made_up_record(name, scene % 2 ? "wholemilk" : "skin1", techniques[t], t, backend, samples);
          if (t == 3 && backend == "gpu")
            r.status = CellStatus::not_applicable, r.reason = "the command has no GPU backend";
          if (scene == 0 && t == 2 && samples == 512) r.status = CellStatus::failed, r.reason = "out of <memory>";
          if (r.status != CellStatus::done)
            r.error.clear(), r.truth_error.reset(), r.seconds = {}, r.done.clear(), r.skipped.clear();
          records.push_back(r);
        }
  }
  return records;
}

inline void write_text(const std::filesystem::path& path, const std::string& text) {
  std::filesystem::create_directories(path.parent_path());
  std::ofstream(path, std::ios::binary) << text;
}

/// Images for the first records.
inline void write_images(const std::filesystem::path& folder, std::vector<Record>& records,
                         const ReportFolder& options) {
  const int side = options.side;
  std::filesystem::create_directories(folder / "images");
  const auto write = [&](const std::string& name, const Image& image) {
    write_exr((folder / "images" / name).string(), image);
    return "images/" + name;
  };
  const std::string reference = write("reference.exr", ball_image(side, 0)),
                    bound = write("reference-bound.exr", ball_image(side, 0, 1e-3)),
                    truth = write("truth.exr", ball_image(side, 0.02)),
                    variance = write("truth-variance.exr", ball_image(side, 0, 1e-4));
  for (std::size_t i = 0; i < std::min(options.pictured, records.size()); ++i) {
    Record& r = records[i];
    if (r.status != CellStatus::done) continue;
    const double error = r.error.at("relative_rmse");
    r.images = {{"render", write(r.cell + ".exr", ball_image(side, 1.4 * error))}, {"reference", reference}};
    r.images["bound"] = bound, r.images["truth"] = truth, r.images["variance"] = variance;
  }
}

inline const char* made_up_stress = R"({"count": 1000, "points": 100, "seed": 1, "functions": [
  {"name": "fresnel", "derivative": false, "inputs": ["eta", "cos"], "points": 100, "limit": 4, "checked": 1000, "nan": 0, "infinite": 0,
   "negative": 0, "not_monotone": 0, "passed": true, "worst_ulp_per_condition": {"value": 1.25, "condition": 2, "at": [1.3, 0.5]}, "worst_ulp": {"value": 3, "condition": 2, "at": [1.3, 0.5]}},
  {"name": "broken <profile>", "derivative": true, "inputs": ["r"], "points": 100, "limit": 4, "checked": 1000, "nan": 7, "infinite": 0,
   "negative": 0, "not_monotone": 0, "passed": false, "worst_ulp_per_condition": {"value": 9.5, "condition": 2, "at": [20]}, "worst_ulp": {"value": null, "condition": 2, "at": [20]}}]})";

inline const char* made_up_gates =
    R"({"gates": [{"name": "error of hierarchical", "outcome": "passed", "value": 0.0008, "max": 0.001, "where": "scene_1", "message": ""},
  {"name": "GPU <over> CPU", "outcome": "failed", "value": 3.5, "max": 2, "where": "scene_1", "message": "too slow"},
  {"name": "an external one", "outcome": "skipped", "value": null, "min": 2, "where": "", "message": "not applicable everywhere"}]})";

inline const char* made_up_fit =
    R"({"format": "opaline-fit", "version": 1, "model": "standard_dipole", "starts": 2, "iterations": 12, "converged": true,
  "rmse": 0.01, "relative_rmse": 0.012, "noise_sd": 0.0014, "notes": ["sigma_a and eta trade off"],
  "parameters": {"sigma_a_per_mm": {"value": [0.0321, 0.17, 0.48], "sd": [0.0001, 0.0001, 0.0002], "ci95": [[0.0319, 0.0323], [0.1698, 0.1702], [0.4796, 0.4804]],
    "identifiable": [true, true, false], "free": true, "reason": ["", "", "flat"]},
    "eta": {"value": 1.299, "sd": 0.0003, "ci95": [1.2984, 1.2996], "identifiable": true, "free": true, "reason": ""}},
  "start_records": [{"cost_history": [1e6, 1e3, 750.0]}, {"cost_history": [2e5, 900.0, 751.0, 750.0]}], "seconds": {"total": 3.2}})";

inline void write_extras(const std::filesystem::path& folder, int side) {
  write_text(folder / "stress.json", made_up_stress);
  write_text(folder / "gates.json", made_up_gates);
  write_text(folder / "fits/ball/fit.json", made_up_fit);
  write_text(folder / "fits/ball/truth.json", R"({"parameters": {"sigma_a_per_mm": [0.032, 0.17, 0.48], "eta": 1.3}})");
  write_exr((folder / "fits/ball/target.exr").string(), ball_image(side, 0));
  write_exr((folder / "fits/ball/refit.exr").string(), ball_image(side, 0.01));
  write_exr((folder / "fits/ball/difference.exr").string(), ball_image(side, 0, 0.01));
}

inline void write_report_folder(const std::string& path, const ReportFolder& options = {}) {
  const std::filesystem::path folder(path);
  std::filesystem::create_directories(folder);
  std::vector<Record> records = made_up_records(options.records);
  if (options.pictured > 0) write_images(folder, records, options);
  std::string lines;
  for (const Record& r : records) lines += to_json(r).dump() + "\n";
  write_text(folder / "records.jsonl", lines);
  if (options.extras) write_extras(folder, options.side);
}

}  // namespace opaline::test
