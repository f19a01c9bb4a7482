#include "validate/matrix.h"

#include "datasets_synthetic/layered/layered_datasets.h"
#include "render/input_error.h"
#include "render/scene/json_object.h"
#include "render/stopwatch.h"
#include "validate/measure.h"

#include <algorithm>
#include <filesystem>
#include <memory>
#include <optional>

namespace opaline {
namespace {

namespace fs = std::filesystem;

/// The GL of the run, opened when the first gpu cell comes.
class LazyContext {
 public:
  explicit LazyContext(std::string api) : api_(std::move(api)) {}
  const gl::Context* get() {
    if (!tried_) open();
    return context_.get();
  }
  const std::string& why_not() const { return why_not_; }

 private:
  void open() {
    tried_ = true;
    try {
      context_ = gl::Context::create(gl::parse_api(api_));
    } catch (const MachineError& error) {
      why_not_ = error.what();
    }
  }
  std::string api_, why_not_;
  std::unique_ptr<gl::Context> context_;
  bool tried_ = false;
};

/// Records of an earlier run by the cell's hash; those that failed are measured again.
std::map<std::string, Record> known_records(const std::string& path, bool remeasure) {
  std::map<std::string, Record> known;
  if (remeasure || !fs::exists(path)) return known;
  for (Record& record : read_records(path).records)
    if (record.status != CellStatus::failed) known[record.cell] = std::move(record);
  return known;
}

/// Are the dataset's files there, with what it would write? Their bytes are part of the cells' hashes, and an EXR has
/// the time it was written in it: written again, all cells would be others.
bool is_written(const LayeredDataset& dataset, const std::string& folder) {
  try {
    const Image depths = dataset.depths(), found = read_image(folder + "/depths.exr");
    return found.channels == depths.channels && found.data == depths.data &&
           read_json_file(folder + "/scene.json") == dataset.scene();
  } catch (const InputError&) {
    return false;
  }
}

/// The suite with the files of its layered datasets in the run's folder.
Suite with_dataset_files(Suite suite, const RunOptions& options) {
  const std::vector<std::string>& chosen = options.choice.scenes;
  for (SuiteScene& scene : suite.scenes) {
    if (scene.dataset.empty()) continue;
    if (!chosen.empty() && std::find(chosen.begin(), chosen.end(), scene.name) == chosen.end()) continue;
    const std::string folder = options.folder + "/scenes/" + scene.dataset;
    const LayeredDataset& dataset = *find_layered_dataset(scene.dataset);
    if (!is_written(dataset, folder)) write_layered_dataset(dataset, folder);
    scene.path = folder + "/scene.json";
  }
  return suite;
}

class Run {
 public:
  Run(const Suite& suite, const RunOptions& options, const ShapeLibrary& shapes)
      : suite_(with_dataset_files(suite, options)),
        options_(options),
        shapes_(shapes),
        cases_(scene_cases(suite_, options.choice)),
        cells_(enumerate_cells(suite_, cases_, options.choice)),
        context_(options.choice.gl) {
    gl::parse_api(options.choice.gl);  // throws
    make_folder();
    const std::string path = options.folder + "/records.jsonl";
    known_ = known_records(path, options.remeasure);
    writer_.emplace(path);
  }

  RunSummary run(const CellObserver& observer) {
    Stopwatch whole;
    for (std::size_t i = 0; i < cells_.size(); ++i) {
      const auto known = known_.find(cells_[i].hash);
      if (known != known_.end())
        summary_.records.push_back(known->second);
      else
        measure(i, observer);
    }
    summary_.seconds = whole.lap();
    return std::move(summary_);
  }

 private:
  void make_folder() {
    std::error_code error;
    fs::create_directories(options_.folder, error);
    if (error) throw InputError(options_.folder, "", "cannot be made: " + error.message());
  }

  std::string marker() const { return options_.folder + "/measuring"; }

  void measure(std::size_t index, const CellObserver& observer) {
    Stopwatch watch;
    const Cell& cell = cells_[index];
    Record record = new_record(suite_, cases_[cell.scene], cell);
    if (observer) observer(record.name(), index, cells_.size());
    write_text_atomically(marker(), cell.hash);
    const auto failed = options_.failed.find(cell.hash);
    if (failed != options_.failed.end()) {
      record.status = CellStatus::failed;
      record.reason = failed->second;
    } else if (MeasuredScene* scene = scene_of(cell, record)) {
      const gl::Context* gl = cell.backend == "gpu" ? context_.get() : nullptr;
      measure_cell({suite_, options_.folder, gl, context_.why_not(), options_.choice}, cell, *scene, record);
      watch.lap();
    }
    writer_->append(record);
    fs::remove(marker());
    summary_.overhead_seconds += record.seconds.harness_overhead + watch.lap();
    ++summary_.measured;
    summary_.records.push_back(std::move(record));
  }

  /// The scene of the cell; null, and the record failed, where it cannot be loaded.
  MeasuredScene* scene_of(const Cell& cell, Record& record) {
    if (!scene_ || scene_index_ != cell.scene) {
      scene_.reset();
      scene_index_ = cell.scene;
      scene_error_.clear();
      try {
        scene_ = std::make_unique<MeasuredScene>(suite_, cases_[cell.scene], shapes_, options_.folder);
      } catch (const std::exception& error) {
        scene_error_ = error.what();
      }
    }
    if (scene_) return scene_.get();
    record.status = CellStatus::failed;
    record.reason = scene_error_;
    return nullptr;
  }

  const Suite suite_;
  const RunOptions& options_;
  const ShapeLibrary& shapes_;
  std::vector<SceneCase> cases_;
  std::vector<Cell> cells_;
  LazyContext context_;
  std::map<std::string, Record> known_;
  std::optional<RecordWriter> writer_;
  std::unique_ptr<MeasuredScene> scene_;
  std::size_t scene_index_ = 0;
  std::string scene_error_;
  RunSummary summary_;
};

}  // namespace

RunSummary run_suite(const Suite& suite, const RunOptions& options, const ShapeLibrary& shapes,
                     const CellObserver& observer) {
  return Run(suite, options, shapes).run(observer);
}

}  // namespace opaline
