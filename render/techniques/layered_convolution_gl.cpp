// layered_convolution on the GPU: transforms, products and lookup in compute shaders. The splatted layers go up, only
// what the visible points see comes back.
#include "render/gl/program.h"
#include "render/gl/resources.h"
#include "render/input_error.h"
#include "render/layered/layered_convolution.h"

#include <fmt/format.h>
#include <glad/gl.h>

#include <cmath>

namespace opaline {
namespace {

using gl::Buffer;

constexpr int radices[] = {4, 2, 3, 5};
constexpr unsigned group = 64, most_groups = 65535;

unsigned groups(int count) { return (static_cast<unsigned>(count) + group - 1) / group; }

struct GlPrograms {
  gl::Program radix4, radix2, radix3, radix5, sum, lookup;
  const gl::Program* fft[4] = {&radix4, &radix2, &radix3, &radix5};

  explicit GlPrograms(const gl::Context& context)
      : radix4(compute(context, "fft", "const int radix = 4;\n")),
        radix2(compute(context, "fft", "const int radix = 2;\n")),
        radix3(compute(context, "fft", "const int radix = 3;\n")),
        radix5(compute(context, "fft", "const int radix = 5;\n")),
        sum(compute(context, "sum", "")),
        lookup(compute(context, "lookup", "")) {}

 private:
  static gl::Program compute(const gl::Context& context, const std::string& part, const std::string& constants) {
    const gl::ShaderText text = gl::shader_file("render/techniques/layered_" + part + ".comp");
    return gl::Program(context, {{gl::StageKind::compute, {{"constants", constants}, text}}});
  }
};

/// Transforms of many images of one size at once.
class GlFft {
 public:
  GlFft(const gl::Context& context, const GlPrograms& programs, int width, int height)
      : context_(context),
        programs_(programs),
        width_(width),
        height_(height),
        along_x_(context, twiddles(width)),
        along_y_(context, twiddles(height)) {}

  /// Room for images. Throws MachineError if they are more than the device takes in one buffer.
  std::unique_ptr<Buffer> images(int count, const void* data = nullptr) const {
    const std::size_t bytes = sizeof(glm::vec2) * static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_) *
                              static_cast<std::size_t>(count);
    GLint64 most = 0;
    context_.use().GetInteger64v(GL_MAX_SHADER_STORAGE_BLOCK_SIZE, &most);
    if (bytes > static_cast<std::size_t>(most))
      throw MachineError(fmt::format(
          "layered_convolution: {} layers of {} x {} nodes need {} MiB in one buffer, this GL takes {}; set fewer "
          "layers or a lower resolution",
          count, width_, height_, bytes >> 20, most >> 20));
    return std::make_unique<Buffer>(context_, bytes, data);
  }

  void run(std::unique_ptr<Buffer>& images_of, std::unique_ptr<Buffer>& spare, int count, bool forward) const {
    axis(images_of, spare, count, along_x_, width_, height_, 1, width_, forward);
    axis(images_of, spare, count, along_y_, height_, width_, width_, 1, forward);
  }

 private:
  static std::vector<glm::vec2> twiddles(int length) {
    std::vector<glm::vec2> table;
    for (int t = 0; t < length; ++t) table.emplace_back(std::cos(2 * pi * t / length), -std::sin(2 * pi * t / length));
    return table;
  }

  void axis(std::unique_ptr<Buffer>& from, std::unique_ptr<Buffer>& to, int count, const Buffer& table, int length,
            int lines, int element_step, int line_step, bool forward) const {
    int rest = length, done = 1;
    for (std::size_t r = 0; r < std::size(radices); ++r)
      while (rest % radices[r] == 0) {
        const gl::Program& program = *programs_.fft[r];
        program.set("line_length", length), program.set("done", done), program.set("element_step", element_step);
        program.set("line_step", line_step), program.set("image_step", width_ * height_);
        program.set("direction", forward ? 1.0f : -1.0f);
        from->bind_storage(0), to->bind_storage(1), table.bind_storage(2);
        program.dispatch(groups(length / radices[r]), static_cast<unsigned>(lines), static_cast<unsigned>(count));
        std::swap(from, to);
        rest /= radices[r], done *= radices[r];
      }
  }

  const gl::Context& context_;
  const GlPrograms& programs_;
  int width_, height_;
  Buffer along_x_, along_y_;
};

std::vector<glm::vec2> axis_data(const GridAxis& axis) {
  std::vector<glm::vec2> data;
  for (std::size_t i = 0; i < axis.k.size(); ++i) data.emplace_back(axis.k[i], axis.factor[i]);
  return data;
}

std::vector<glm::vec4> point_data(const std::vector<LayerPoint>& points) {
  std::vector<glm::vec4> data;
  data.reserve(points.size());
  for (const LayerPoint& p : points) data.emplace_back(p.x, p.y, static_cast<float>(p.z.lower), p.z.share);
  return data;
}

/// One pass of one object.
class GlRun {
 public:
  GlRun(const gl::Context& context, const GlPrograms& programs, const LayeredPass& pass)
      : context_(context),
        programs_(programs),
        pass_(pass),
        fft_(context, programs, pass.width, pass.height),
        points_(context, point_data(pass.points)),
        work_(fft_.images(pass.layers.count())),
        spare_(fft_.images(pass.layers.count())) {
    for (const LayerStack& stack : pass.sources.stacks) sources_.push_back(transformed(stack));
  }

  std::vector<float> values(const LayerLane& lane) {
    const std::size_t outputs = lane.outputs.size();
    const Buffer sums(context_, std::vector<float>(outputs * pass_.points.size()));
    for (std::size_t o = 0; o < outputs; ++o) {
      if (lane.outputs[o].empty()) continue;
      bool first = true;
      for (std::size_t s = 0; s < sources_.size(); ++s)
        if (add_products(lane, lane.outputs[o], s, first)) first = false;
      fft_.run(work_, spare_, static_cast<int>(lane.outputs[o].size()), false);
      look_up(lane.outputs[o], sums, static_cast<int>(outputs), static_cast<int>(o));
    }
    const std::vector<float> at = sums.read<float>();
    std::vector<float> value(pass_.points.size());
    for (std::size_t i = 0; i < value.size(); ++i) value[i] = lane_value(lane, &at[i * outputs]);
    return value;
  }

 private:
  std::unique_ptr<Buffer> transformed(const LayerStack& stack) {
    std::vector<glm::vec2> numbers;
    numbers.reserve(static_cast<std::size_t>(stack.layers() * pass_.width) * static_cast<std::size_t>(pass_.height));
    for (int layer = 0; layer < stack.layers(); ++layer)
      for (int y = 0; y < pass_.height; ++y)
        for (int x = 0; x < pass_.width; ++x) numbers.emplace_back(stack.row(layer, y)[x], 0);
    std::unique_ptr<Buffer> images = fft_.images(stack.layers(), numbers.data());
    fft_.run(images, spare_, stack.layers(), true);
    return images;
  }

  /// The products with one stack of sources; false if there are none.
  bool add_products(const LayerLane& lane, const std::vector<OutputLayer>& outputs, std::size_t source,
                    bool overwrite) const {
    std::vector<int> starts = {0};
    std::vector<glm::ivec4> products;
    const int entries = lane.table.entries();
    for (const OutputLayer& output : outputs) {
      for (const LayerProduct& p : output.products)
        if (p.source == static_cast<int>(source))
          products.emplace_back(p.in, p.add * entries, p.subtract < 0 ? -1 : p.subtract * entries, 0);
      starts.push_back(static_cast<int>(products.size()));
    }
    if (products.empty()) return false;
    const Buffer table(context_, lane.table.all()), x(context_, axis_data(lane.x_axis)),
        y(context_, axis_data(lane.y_axis)), start(context_, starts), product(context_, products);
    const Buffer* buffers[] = {sources_[source].get(), work_.get(), &table, &x, &y, &start, &product};
    for (unsigned binding = 0; binding < std::size(buffers); ++binding) buffers[binding]->bind_storage(binding);
    const gl::Program& sum = programs_.sum;
    sum.set("size", glm::ivec2(pass_.width, pass_.height));
    sum.set("first_entry", lane.table.first()), sum.set("shift", KernelTable::shift);
    sum.set("offset", lane.table.offset()), sum.set("scale", pass_.scale), sum.set("overwrite", overwrite ? 1 : 0);
    sum.dispatch(groups(pass_.width), static_cast<unsigned>(pass_.height), static_cast<unsigned>(outputs.size()));
    return true;
  }

  void look_up(const std::vector<OutputLayer>& outputs, const Buffer& sums, int stride, int to) const {
    std::vector<int> images(static_cast<std::size_t>(pass_.layers.count()), -1);
    for (std::size_t i = 0; i < outputs.size(); ++i)
      images[static_cast<std::size_t>(outputs[i].layer)] = static_cast<int>(i);
    const Buffer image_of(context_, images);
    const Buffer* buffers[] = {work_.get(), &points_, &sums, &image_of};
    for (unsigned binding = 0; binding < std::size(buffers); ++binding) buffers[binding]->bind_storage(binding);
    const gl::Program& lookup = programs_.lookup;
    lookup.set("width", pass_.width), lookup.set("height", pass_.height);
    lookup.set("outputs", stride), lookup.set("to", to);
    constexpr int most = static_cast<int>(group * most_groups);
    const int count = static_cast<int>(pass_.points.size());
    for (int first = 0; first < count; first += most) {
      const int last = std::min(count, first + most);
      lookup.set("first_point", first), lookup.set("last_point", last);
      lookup.dispatch(groups(last - first));
    }
    context_.check_errors();
  }

  const gl::Context& context_;
  const GlPrograms& programs_;
  const LayeredPass& pass_;
  GlFft fft_;
  Buffer points_;
  std::unique_ptr<Buffer> work_, spare_;
  std::vector<std::unique_ptr<Buffer>> sources_;
};

class LayeredGl : public LayeredBackend {
 public:
  LayeredGl(const gl::Context& context, const GlPrograms& programs) : context_(context), programs_(programs) {}

  std::vector<std::vector<float>> run(LayeredPass& pass) override {
    GlRun run(context_, programs_, pass);
    std::vector<std::vector<float>> values;
    for (const LayerLane& lane : pass.lanes) values.push_back(run.values(lane));
    return values;
  }

 private:
  const gl::Context& context_;
  const GlPrograms& programs_;
};

class PreparedLayersGl : public PreparedTechnique {
 public:
  PreparedLayersGl(const SharedScene& shared, const LayeredSettings& settings, const gl::Context& context)
      : shared_(shared),
        settings_(settings),
        objects_(layered_objects(shared.scene, settings)),
        context_(context),
        programs_(context) {}

  Frame render(const GBuffer& view) const override {
    LayeredGl backend(context_, programs_);
    return render_layered(shared_, objects_, settings_, view, backend);
  }

 private:
  const SharedScene& shared_;
  LayeredSettings settings_;
  std::vector<LayeredObject> objects_;
  const gl::Context& context_;
  GlPrograms programs_;
};

}  // namespace

std::unique_ptr<PreparedTechnique> prepare_layered_convolution_gl(const SharedScene& shared, const Settings& settings,
                                                                  const gl::Context& context) {
  return std::make_unique<PreparedLayersGl>(shared, read_layered_settings(settings), context);
}

}  // namespace opaline
