#include "reports/report_data.h"

#include "render/input_error.h"
#include "render/scene/json_object.h"

#include <filesystem>

namespace opaline {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

bool is_there(const fs::path& path) {
  std::error_code ignored;
  return fs::exists(path, ignored);
}

/// The document, which must be an object with an array of objects under `list`.
json read_document(const fs::path& path, const char* list) {
  json document = read_json_file(path.string());
  const auto rows = document.is_object() ? document.find(list) : document.end();
  if (rows == document.end() || !rows->is_array())
    throw InputError(path.string(), std::string("/") + list, "must be an array: is this file of another kind?");
  for (const json& row : *rows)
    if (!row.is_object()) throw InputError(path.string(), std::string("/") + list, "must hold objects {...} only");
  return document;
}

std::optional<json> read_if_there(const fs::path& path, const char* list) {
  return is_there(path) ? std::optional(read_document(path, list)) : std::nullopt;
}

/// The truth lies beside the fit, or, for a synthetic dataset, beside the fitted picture.
std::optional<json> find_truth(const fs::path& folder, const json& fit) {
  std::vector<fs::path> places = {folder / "truth.json"};
  for (const json& target : fit.value("targets", json::array()))
    if (target.is_object() && target.value("target", json()).is_string())
      places.push_back(fs::path(target["target"].get<std::string>()).parent_path() / "truth.json");
  for (const fs::path& place : places) {
    if (!is_there(place)) continue;
    const json truth = read_json_file(place.string());
    if (truth.is_object() && truth.contains("parameters")) return truth["parameters"];
    throw InputError(place.string(), "/parameters", "is missing: this is no truth of a dataset");
  }
  return {};
}

FitResult read_fit(const fs::path& folder) {
  FitResult result;
  result.name = folder.filename().string();
  const std::string path = (folder / "fit.json").string();
  result.fit = read_json_file(path);
  if (!result.fit.is_object() || !result.fit.value("parameters", json()).is_object())
    throw InputError(path, "/parameters", "is missing: this is no result of `opaline fit`");
  result.truth = find_truth(folder, result.fit);
  for (const char* name : {"target", "refit", "difference"})
    if (const fs::path image = folder / (std::string(name) + ".exr"); is_there(image))
      result.images[name] = image.string();
  return result;
}

std::vector<FitResult> read_fits(const fs::path& folder) {
  std::vector<fs::path> folders;
  if (is_there(folder))
    for (const auto& entry : fs::directory_iterator(folder))
      if (is_there(entry.path() / "fit.json")) folders.push_back(entry.path());
  std::sort(folders.begin(), folders.end());
  std::vector<FitResult> fits;
  for (const fs::path& path : folders) fits.push_back(read_fit(path));
  return fits;
}

void check_folder(const std::string& directory) {
  std::error_code ignored;
  if (!is_there(directory)) throw InputError(directory, "", "the folder does not exist");
  if (!fs::is_directory(directory, ignored)) throw InputError(directory, "", "is a file, not a folder");
}

}  // namespace

ReportData read_report_data(const std::string& directory) {
  check_folder(directory);
  const fs::path folder(directory);
  ReportData data;
  data.directory = directory;
  if (is_there(folder / "records.jsonl")) {
    RecordFile file = read_records((folder / "records.jsonl").string());
    data.records = std::move(file.records);
    data.superseded = file.superseded;
    data.cut = file.cut;
  }
  data.gates = read_if_there(folder / "gates.json", "gates");
  data.stress = read_if_there(folder / "stress.json", "functions");
  data.fits = read_fits(folder / "fits");
  if (data.records.empty() && !data.stress && data.fits.empty())
    throw InputError(directory, "",
                     "holds nothing to report: no record in records.jsonl (made by `opaline validate --out DIR`), no "
                     "stress.json, no fits/NAME/fit.json");
  return data;
}

}  // namespace opaline
