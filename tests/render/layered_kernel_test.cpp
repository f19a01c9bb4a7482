// The parts of layered convolution against independent values: transforms, spectra, kernels, layers, splatted flux.
#include "datasets_synthetic/shapes/shapes.h"
#include "model/quadrature.h"
#include "render/layered/convolve.h"
#include "render/layered/splat.h"
#include "tests/support/render_fixture.h"

#include <gmock/gmock.h>

#include <complex>
#include <numeric>

namespace opaline {
namespace {

std::unique_ptr<Profile> profile_of(const std::string& name, double sigma_a = 0.05, double sigma_s_prime = 1) {
  return find_profile(name)->make({sigma_a, sigma_s_prime, 1.3});
}

// --- transforms -------------------------------------------------------------------------------------

TEST(LayerFft, IsTheSumItSays) {
  constexpr int width = 10, height = 6, rows = 4;
  LayerStack stack(width, height, 2);
  std::vector<float> image(width * height);
  for (int y = 0; y < height; ++y) std::fill_n(stack.row(1, y), width + 2, 0.0f);  // with the room for the sums
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const float value = y < rows ? std::sin(1.7f * static_cast<float>(x * x) + 0.9f * static_cast<float>(y)) : 0;
      image[static_cast<std::size_t>(y * width + x)] = stack.row(1, y)[x] = value;
    }
  stack.forward(1, rows);
  for (int v = 0; v < height; ++v)
    for (int u = 0; u <= width / 2; ++u) {
      std::complex<double> sum = 0;
      for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
          sum += static_cast<double>(image[static_cast<std::size_t>(y * width + x)]) *
                 std::polar(1.0, -2 * pi * (u * x / double{width} + v * y / double{height}));
      EXPECT_NEAR(static_cast<double>(stack.row(1, v)[2 * u]), sum.real(), 1e-5);
      EXPECT_NEAR(static_cast<double>(stack.row(1, v)[2 * u + 1]), sum.imag(), 1e-5);
    }
  stack.backward(1, rows);
  for (int y = 0; y < rows; ++y)
    for (int x = 0; x < width; ++x)
      EXPECT_NEAR(stack.row(1, y)[x] / (width * height), image[static_cast<std::size_t>(y * width + x)], 1e-6f);
}

TEST(LayerFft, SizesAreEvenAndSmooth) {
  EXPECT_EQ(good_fft_size(1), 2);
  EXPECT_EQ(good_fft_size(97), 100);
  EXPECT_EQ(good_fft_size(121), 128);
  EXPECT_EQ(good_fft_size(1025), 1080);
}

// --- spectra between planes -------------------------------------------------------------------------

class ClosedSpectrum : public testing::TestWithParam<std::string> {};

// Two ways to the same number, and with k = 0 a third: the plain integral.
TEST_P(ClosedSpectrum, IsTheHankelTransform) {
  for (const double sigma_a : {0.0, 0.01, 1.0}) {
    const auto profile = profile_of(GetParam(), sigma_a);
    const PlaneSpectrum spectrum(*profile);
    ASSERT_TRUE(spectrum.closed());
    for (const double z : {0.0, 0.3, 4.0}) {
      const double whole = spectrum(0, z);
      for (const double k : {0.01, 0.2, 1.0, 5.0, 20.0})
        EXPECT_NEAR(spectrum.by_hankel(k, z), spectrum(k, z), 1e-5 * whole) << sigma_a << " " << z << " " << k;
      const double integral = integrate_half_line<double>(
          [&](double r) { return r < 1e15 ? 2 * pi * r * profile->evaluate(std::hypot(r, z)) : 0; });
      EXPECT_NEAR(whole, integral, 1e-6 * whole + (sigma_a == 0 ? 1e-3 * whole : 0)) << sigma_a << " " << z;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Profiles, ClosedSpectrum,
                         testing::Values("standard_dipole", "better_dipole", "normalised_diffusion"),
                         [](const auto& row) { return row.param; });

class EveryProfile : public testing::TestWithParam<std::string> {};

TEST_P(EveryProfile, KeepsItsEnergyForAnySizeOfPixel) {
  const auto profile = profile_of(GetParam());
  const PlaneSpectrum spectrum(*profile);
  for (const double step : {0.05, 1.0, 30.0}) {
    constexpr int size = 32;
    const KernelTable table(spectrum, {0.0}, 1.5 * pi / step, {.range = size * step});
    // Light in one node, on a plane; what arrives, summed over the grid.
    std::vector<LayerStack> source;
    source.emplace_back(size, size, 1);
    std::fill(source[0].row(0, 0), source[0].row(0, 0) + source[0].stride() * size, 0.0f);
    source[0].row(0, size / 2)[size / 2] = 1;
    source[0].forward(0, size);
    LayerStack out(size, size, 1);
    for (const int power : {1, 0, -2}) {
      const GridAxis axis = grid_axis(size, step, power);
      sum_layers(source, table, axis, axis, 1.0f / (size * size), {{0, {{0, 0, 0}}}}, out);
      out.backward(0, size);
      double sum = 0;
      for (int y = 0; y < size; ++y) sum = std::accumulate(out.row(0, y), out.row(0, y) + size, sum);
      EXPECT_NEAR(sum, profile->total(), 1e-4 * profile->total()) << step << " " << power;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Profiles, EveryProfile, testing::ValuesIn(medium_profile_names()),
                         [](const auto& row) { return row.param; });

/// What a unit of light in the middle of a grid makes along a row, as R [1/mm^2].
std::vector<double> kernel_row(const Profile& profile, double z, double step, int size, const CutOff& cut) {
  const KernelTable table(PlaneSpectrum(profile), {z}, 1.5 * pi / step, cut);
  std::vector<LayerStack> source;
  source.emplace_back(size, size, 1);
  std::fill(source[0].row(0, 0), source[0].row(0, 0) + source[0].stride() * static_cast<std::size_t>(size), 0.0f);
  source[0].row(0, 0)[0] = 1;
  source[0].forward(0, size);
  LayerStack out(size, size, 1);
  const GridAxis axis = grid_axis(size, step, 0);
  sum_layers(source, table, axis, axis, static_cast<float>(1 / (step * step * size * size)), {{0, {{0, 0, 0}}}}, out);
  out.backward(0, size);
  return std::vector<double>(out.row(0, 0), out.row(0, 0) + size / 2);
}

// Nothing absorbs: the profile reaches far beyond the grid, whose repetitions would add up without the cut-off.
TEST(CutOffKernel, IsTheProfileAndDoesNotWrapAround) {
  for (const std::string name : {"standard_dipole", "extended_source"}) {
    const auto profile = profile_of(name, 1e-4, 1);
    for (const double z : {0.0, 3.0}) {
      // Grid of 500 x 0.25 mm = 125 mm: the object is 55 mm across.
      const auto row = kernel_row(*profile, z, 0.25, 500, {.range = 66, .start = 55, .end = 66});
      // What light that is linear between nodes sees: their alternating part cancels.
      const auto exact = [&](int i) { return profile->evaluate(std::hypot(0.25 * i, z)); };
      for (const std::size_t i : {8u, 21u, 80u, 161u, 216u}) {
        const int at = static_cast<int>(i);
        const double wanted = (exact(at - 1) + 2 * exact(at) + exact(at + 1)) / 4;
        EXPECT_NEAR((row[i - 1] + 2 * row[i] + row[i + 1]) / 4, wanted, 0.004 * wanted + 2e-7)
            << name << " " << z << " " << i;
      }
    }
  }
}

// --- layers -----------------------------------------------------------------------------------------

TEST(Layers, GiveEveryDepthToTheTwoAround) {
  const Layers layers = Layers::uniform(2, 12, 6);
  EXPECT_EQ(layers.count(), 6);
  EXPECT_DOUBLE_EQ(layers.largest_gap(), 2);
  for (const double z : {2.0, 3.1, 8.0, 11.9, 12.0}) {
    const Layers::Place p = layers.place(z);
    const double back = layers.depth(p.lower) + static_cast<double>(p.share) * 2;
    EXPECT_NEAR(back, z, 1e-6);
  }
  EXPECT_EQ(layers.place(-5).lower, 0);
  EXPECT_FLOAT_EQ(layers.place(99).share, 1);
  EXPECT_EQ(Layers::uniform(3, 3, 8).count(), 1);
}

TEST(Layers, LieWhereSurfaceIs) {
  std::vector<double> density(100, 0.001);
  std::fill(density.begin() + 40, density.begin() + 60, 8.0);
  std::fill(density.begin(), density.begin() + 10, 0.0);
  const Layers layers = Layers::by_surface(0, 100, 12, density);
  ASSERT_EQ(layers.count(), 12);
  EXPECT_DOUBLE_EQ(layers.depth(0), 10);
  EXPECT_DOUBLE_EQ(layers.depth(11), 100);
  int dense = 0;
  for (int i = 0; i < 12; ++i) dense += layers.depth(i) >= 38 && layers.depth(i) <= 62;
  EXPECT_GE(dense, 7);
  for (int i = 1; i < 12; ++i) EXPECT_GT(layers.depth(i), layers.depth(i - 1));
}

// --- splatted flux ----------------------------------------------------------------------------------

/// Flux and its first moments [mm] on the layers.
glm::dvec4 moments(const LayerSources& sources, int first, int stacks, const FrameGrid& grid, const Layers& layers) {
  glm::dvec4 sum(0);
  for (int s = first; s < first + stacks; ++s)
    for (int l = 0; l < layers.count(); ++l)
      for (int y = 0; y < grid.height; ++y)
        for (int x = 0; x < grid.width; ++x) {
          const double f = static_cast<double>(sources.stacks[static_cast<std::size_t>(s)].row(l, y)[x]);
          sum += f * glm::dvec4(1, grid.corner.x + x * grid.step, grid.corner.y + y * grid.step, layers.depth(l));
        }
  return sum;
}

TEST(Splat, KeepsFluxAndItsMeanPlace) {
  for (const auto type : {Camera::Type::orthographic, Camera::Type::perspective}) {
    Scene scene = test::make_scene(make_torus(6, 2, 800), test::library_material("skin1"), 20, 40);
    scene.camera.type = type, scene.camera.position = {20, 30, 80}, scene.camera.fov_y_deg = 14;
    const SharedScene shared(scene, {3000, {}});
    const ObjectPoints points = points_of_object(shared.view, 0);
    const ParallelFrame frame = parallel_frame(shared.view, points.positions);
    const FrameBox box = frame_box(frame, scene.objects[0].mesh.positions);
    const Layers layers = Layers::uniform(box.lo.z, box.hi.z, 7);
    glm::dvec4 exact(0);
    for (std::size_t i = 0; i < shared.cells[0].size(); ++i) {
      const SurfaceCell& cell = shared.cells[0][i];
      const double flux = static_cast<double>(shared.irradiance[0].values[i] * cell_area(cell));
      exact += flux * glm::dvec4(1, frame.point(cell_centroid(cell)));
    }
    for (const double nodes : {0.25, 1.0})
      for (const bool facing : {false, true}) {
        const FrameGrid grid = frame_grid(frame, box, nodes, 2048);
        const LayerSources sources = splat_cells(shared.cells[0], shared.irradiance[0], frame, grid, grid.width + 2,
                                                 grid.height + 3, layers, {false, facing});
        const glm::dvec4 found = moments(sources, 0, facing ? 2 : 1, grid, layers);
        EXPECT_NEAR(found[0], exact[0], 2e-5 * exact[0]);
        for (int i = 1; i < 4; ++i) EXPECT_NEAR(found[i], exact[i], 2e-4 * exact[0]) << i;
        EXPECT_EQ(sources.cells_outside, 0u);
      }
    const FrameGrid grid = frame_grid(frame, box, 1, 2048);
    const LayerSources halves =
        splat_cells(shared.cells[0], shared.irradiance[0], frame, grid, grid.width, grid.height, layers, {true, false});
    EXPECT_NEAR(moments(halves, 0, 1, grid, layers)[0], exact[0], 2e-5 * exact[0]);
  }
}

// Seen from above, half a sphere's surface faces the viewer, and that half's area is on the layers.
TEST(Splat, TellsSurfaceThatFacesTheViewer) {
  Scene scene = test::make_scene(make_sphere(5, 2000), test::library_material("skin1"), 12, 40);
  const SharedScene shared(scene, {4000, {}});
  const ParallelFrame frame = parallel_frame(shared.view, points_of_object(shared.view, 0).positions);
  const FrameBox box = frame_box(frame, scene.objects[0].mesh.positions);
  const FrameGrid grid = frame_grid(frame, box, 1, 2048);
  const Layers layers = Layers::uniform(box.lo.z, box.hi.z, 9);
  const LayerSources sources =
      splat_cells(shared.cells[0], shared.irradiance[0], frame, grid, grid.width, grid.height, layers, {false, true});
  double facing = 0;
  for (const SurfaceCell& c : shared.cells[0])
    if (glm::cross(c.b - c.a, c.c - c.a).z > 0) facing += static_cast<double>(cell_area(c));
  const glm::dvec4 area = moments(sources, 2, 1, grid, layers);
  EXPECT_NEAR(area[0], facing, 2e-3 * facing);
  EXPECT_NEAR(area[3] / area[0], box.lo.z + 2.5, 0.05);  // the mean depth of a half sphere's surface is half its radius
}

}  // namespace
}  // namespace opaline
