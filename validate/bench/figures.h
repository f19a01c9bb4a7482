// What the benchmark prints: a figure reached beside the figure asked, on a named machine.
#pragma once

#include "render/scene/scene.h"

#include <functional>
#include <string>
#include <vector>

namespace opaline::bench {

struct Figure {
  std::string name;
  double reached = 0;
  double asked = 0;     ///< 0: nothing was asked
  bool at_most = true;  ///< else at least
  std::string unit, note;
};

void print_figures(const std::string& title, const std::vector<Figure>& figures);

/// Processor, cores, vector instructions, compiler.
std::string machine();

/// Median of the seconds of `runs` calls, after one that is not counted.
double median_seconds(int runs, const std::function<void()>& call);

/// Median of the processor seconds of `runs` calls, over all threads, after one that is not counted: what a busy
/// machine doesn't change.
double median_processor_seconds(int runs, const std::function<void()>& call);

/// Processor time of this thread so far: what a busy machine doesn't stretch.
double thread_seconds();

/// Peak resident memory of this process [bytes].
double peak_rss();

struct SceneChoice {
  std::string mesh;    ///< file; empty: the bust
  double height = 30;  ///< mm
  std::string material = "wholemilk";
  int film = 256;
  std::size_t samples = 100000;
  int runs = 5;
  std::size_t transfer_vertices = 150000;  ///< of the teapot that precomputed transfer is measured on
};

/// Throws InputError for a name that is not in the library.
Material library_material(const std::string& name);

/// The object centred, side-lit by one white directional light, filling most of the film.
Scene bench_scene(const SceneChoice& choice);

/// Inner loops on one core, for every vector target of the processor.
std::vector<Figure> kernel_figures();

struct ModelChoice {
  std::uint64_t samples = 10000000;  ///< per sampler
  std::uint64_t walks = 20000000;    ///< per row of the transport check; 1e8 brings its standard errors below 1e-4
};
std::vector<Figure> model_figures(const ModelChoice& choice);

std::vector<Figure> render_figures(const SceneChoice& choice);
/// The gather alone: about 1e5 points of a sphere of whole milk, one core.
std::vector<Figure> sphere_figures(int runs);
std::vector<Figure> fit_figures(const SceneChoice& choice);
/// Variance against the Cramer-Rao bound and coverage of the intervals, on a small sphere and a mesh (empty: the bust).
std::vector<Figure> calibration_figures(int repetitions, const std::string& mesh);
/// Every `every`-th material of the library from a noise-free picture, on a sphere, a mesh (empty: the bust) and a
/// slab.
/// shapes: of sphere, mesh, slab.
void print_library_figures(const std::string& mesh, std::size_t every, const std::vector<std::string>& shapes);
/// Two views of the object at 512 x 512: operator, models, bootstrap.
std::vector<Figure> examination_figures(const SceneChoice& choice);
/// Of the same object at 64 x 64 pixels, and of a sphere as high.
std::vector<Figure> path_figures(const SceneChoice& choice);

/// Of image_space_sampling: figures and tables, on scenes of its own; `runs` is all that counts of the choice.
void print_image_space_figures(const SceneChoice& choice);

/// Of layered_convolution on the same object at 800 x 800 pixels: figures, and tables of errors and of the skips'
/// ratios.
void print_layered_figures(const SceneChoice& choice);
/// Of subsurface_texture on the layered datasets; `runs` is all that counts of the choice.
void print_subsurface_figures(const SceneChoice& choice);
/// Of precomputed_transfer, on a teapot or the choice's mesh, of marble.
void print_transfer_figures(const SceneChoice& choice);
/// Of its relit frames, on tables of any contents, beside what the machine's memory allows.
std::vector<Figure> transfer_time_figures(int runs);

}  // namespace opaline::bench
