// precomputed_transfer on the GPU: the tables lie in buffers, compute shaders sum their rows for all vertices, and the
// rasteriser interpolates between these. Pixels at a silhouette that the rasteriser gives to nobody, or to another
// object than the ray of the view found, are interpolated on the processor, and counted.
#include "render/gl/clip_matrix.h"
#include "render/gl/program.h"
#include "render/gl/resources.h"
#include "render/transfer/transfer_scene.h"

#include <algorithm>
#include <cstring>
#include <map>

namespace opaline {
namespace {

using gl::Buffer;

glm::uvec2 groups_of(std::size_t vertices) {
  const auto groups = static_cast<unsigned>((vertices + 63) / 64);
  return {std::min(groups, 65535u), (groups + 65534) / 65535};
}

/// Programs that are compiled when first needed.
class Programs {
 public:
  explicit Programs(const gl::Context& context) : context_(context) {}

  const gl::Program& rows(RowStorage storage) const {
    return compute(static_cast<std::size_t>(storage), "render/techniques/transfer_rows.comp",
                   "const int storage = " + std::to_string(static_cast<int>(storage)) + ";\n");
  }
  const gl::Program& blend() const { return compute(4, "render/techniques/transfer_blend.comp", ""); }

 private:
  const gl::Program& compute(std::size_t which, const char* file, const std::string& constants) const {
    std::unique_ptr<gl::Program>& program = programs_[which];
    if (!program)
      program = std::make_unique<gl::Program>(
          context_,
          std::vector<gl::Stage>{{gl::StageKind::compute, {{"constants", constants}, gl::shader_file(file)}}});
    return *program;
  }

  const gl::Context& context_;
  mutable std::unique_ptr<gl::Program> programs_[5];
};

/// A row with its weight for each colour.
struct ColourTerm {
  std::uint32_t row;
  glm::vec4 weight;
};

std::vector<ColourTerm> colour_terms(const CodedRows& rows, const RowWeights& weights) {
  std::map<std::uint32_t, glm::vec4> sums;
  for (int c = 0; c < 3; ++c)
    for (const RowWeight& w : weights[static_cast<std::size_t>(c)]) {
      glm::vec4& sum = sums.try_emplace(w.row, glm::vec4(0)).first->second;
      sum[c] += rows.term(w.row, w.weight).weight;
    }
  std::vector<ColourTerm> terms;
  for (const auto& [row, weight] : sums) terms.push_back({row, weight});
  return terms;
}

/// The rows of one table, in buffers that no driver finds too large.
class GlRows {
 public:
  GlRows(const gl::Context& context, const CodedRows& rows) : context_(context), rows_(rows) {
    constexpr std::size_t largest = std::size_t{64} << 20;
    const std::size_t row_bytes = rows.stride() * bytes_of(rows.storage());
    per_buffer_ = std::max<std::size_t>(1, largest / std::max<std::size_t>(row_bytes, 1));
    for (std::size_t first = 0; first < rows.rows(); first += per_buffer_) {
      const std::size_t count = std::min(per_buffer_, rows.rows() - first);
      buffers_.push_back(std::make_unique<Buffer>(context, count * row_bytes, rows.bytes(first)));
    }
    std::vector<float> levels;
    for (const Codebook& book : rows.codebooks()) levels.insert(levels.end(), book.begin(), book.end());
    codebooks_ = std::make_unique<Buffer>(context, levels);
  }

  /// Adds the weighted rows to the exitance of all vertices, three floats each.
  void add(const Programs& programs, const RowWeights& weights, const Buffer& exitance, Counters& counters) const {
    const std::vector<ColourTerm> terms = colour_terms(rows_, weights);
    const gl::Program& program = programs.rows(rows_.storage());
    for (std::size_t first = 0; first < terms.size();) {
      const std::size_t buffer = terms[first].row / per_buffer_;
      std::size_t last = first;
      while (last < terms.size() && terms[last].row / per_buffer_ == buffer) ++last;
      dispatch(program, std::span(terms).subspan(first, last - first), buffer, exitance);
      ++counters.done["dispatches"];
      first = last;
    }
    counters.done["vertex_rows"] += terms.size() * rows_.vertices();
  }

 private:
  void dispatch(const gl::Program& program, std::span<const ColourTerm> terms, std::size_t buffer,
                const Buffer& exitance) const {
    std::vector<glm::uvec4> places;
    std::vector<glm::vec4> weights;
    for (const ColourTerm& t : terms) {
      const std::size_t books = std::max<std::size_t>(rows_.codebooks().size(), 1);
      places.emplace_back(t.row % per_buffer_, 256 * (t.row % books), 0, 0);
      weights.push_back(t.weight);
    }
    const Buffer place_buffer(context_, places), weight_buffer(context_, weights);
    const Buffer* buffers[] = {buffers_[buffer].get(), &place_buffer, &weight_buffer, codebooks_.get(), &exitance};
    for (unsigned binding = 0; binding < 5; ++binding) buffers[binding]->bind_storage(binding);
    program.set("vertices", static_cast<int>(rows_.vertices()));
    program.set("stride", static_cast<int>(rows_.stride()));
    program.set("term_count", static_cast<int>(terms.size()));
    const glm::uvec2 groups = groups_of(rows_.vertices());
    program.dispatch(groups.x, groups.y);
  }

  const gl::Context& context_;
  const CodedRows& rows_;
  std::size_t per_buffer_ = 1;
  std::vector<std::unique_ptr<Buffer>> buffers_;
  std::unique_ptr<Buffer> codebooks_;
};

std::vector<glm::uvec4> padded(const std::vector<glm::uvec3>& triangles) {
  std::vector<glm::uvec4> result;
  for (const glm::uvec3& t : triangles) result.emplace_back(t, 0);
  return result;
}

std::vector<glm::uvec2> vertex_places(const ReferencePoints& points) {
  std::vector<glm::uvec2> places;
  for (std::size_t v = 0; v < points.triangle_of.size(); ++v) {
    std::uint32_t both;
    std::memcpy(&both, &points.weights[2 * v], sizeof(both));
    places.emplace_back(points.triangle_of[v], both);
  }
  return places;
}

/// An encoded table in buffers: exitance of its vertices.
class GlTransfer {
 public:
  GlTransfer(const gl::Context& context, const EncodedTransfer& transfer)
      : context_(context), transfer_(transfer), rows_(context, transfer.rows) {
    if (!transfer.references) return;
    full_ = std::make_unique<GlTransfer>(context, *transfer.references->full);
    triangles_ = std::make_unique<Buffer>(context, padded(transfer.references->triangles));
    places_ = std::make_unique<Buffer>(context, vertex_places(*transfer.references));
  }

  /// Three floats for each vertex.
  std::unique_ptr<Buffer> exitance(const Programs& programs, const std::vector<TransferLight>& lights,
                                   const TransferNodes& nodes, Counters& counters) const {
    auto out = std::make_unique<Buffer>(context_, std::vector<float>(3 * transfer_.vertices(), 0.0f));
    rows_.add(programs, transfer_.weights(lights, nodes), *out, counters);
    const std::unique_ptr<Buffer> full = full_ ? full_->exitance(programs, lights, nodes, counters) : nullptr;
    const gl::Program& blend = programs.blend();
    blend.set("vertices", static_cast<int>(transfer_.vertices()));
    blend.set("blended", full ? 1 : 0);
    blend.set("weight_unit", CornerBlend::weight_unit);
    blend.set("correction", full ? transfer_.references->correction : 0.0f);
    if (full) triangles_->bind_storage(0), places_->bind_storage(1), full->bind_storage(2);
    out->bind_storage(4);
    const glm::uvec2 groups = groups_of(transfer_.vertices());
    blend.dispatch(groups.x, groups.y);
    context_.check_errors();
    return out;
  }

 private:
  const gl::Context& context_;
  const EncodedTransfer& transfer_;
  GlRows rows_;
  std::unique_ptr<GlTransfer> full_;
  std::unique_ptr<Buffer> triangles_, places_;
};

std::vector<glm::uvec3> kept(const std::vector<glm::uvec3>& triangles) {
  std::vector<glm::uvec3> result;
  for (const glm::uvec3& t : triangles)
    if (t.x != TransferVertices::none) result.push_back(t);
  return result;
}

/// What is drawn of an object.
struct GlMesh {
  std::size_t triangle_count;
  Buffer positions, triangles;

  GlMesh(const gl::Context& context, const TransferVertices& vertices, const std::vector<glm::uvec3>& drawn)
      : triangle_count(drawn.size()), positions(context, vertices.positions), triangles(context, drawn) {}
};

class PreparedTransferGl : public PreparedTechnique {
 public:
  PreparedTransferGl(const SharedScene& shared, const TransferSettings& settings, const gl::Context& context)
      : shared_(shared),
        context_(context),
        transfer_(make_transfer_scene(shared, settings)),
        programs_(context),
        draw_(context, {{gl::StageKind::vertex, {gl::shader_file("render/techniques/precomputed_transfer.vert")}},
                        {gl::StageKind::fragment, {gl::shader_file("render/techniques/precomputed_transfer.frag")}}}) {
    for (const TransferObject& object : transfer_.objects) {
      tables_.push_back(std::make_unique<GlTransfer>(context, object.transfer));
      meshes_.push_back(std::make_unique<GlMesh>(context, object.vertices, kept(object.vertices.triangles)));
    }
  }

  Frame render(const GBuffer& view) const override {
    Frame frame;
    frame.exitance.assign(view.points.size(), glm::vec3(0));
    frame.counters += transfer_.counters;
    std::vector<std::unique_ptr<Buffer>> exitance;
    for (std::size_t i = 0; i < tables_.size(); ++i)
      exitance.push_back(
          tables_[i]->exitance(programs_, transfer_.lights(shared_, i), transfer_.objects[i].nodes, frame.counters));
    const std::vector<float> film = draw(view, exitance);
    for (std::size_t i = 0; i < tables_.size(); ++i) read_object(i, view, film, *exitance[i], frame);
    return frame;
  }

 private:
  std::vector<float> draw(const GBuffer& view, const std::vector<std::unique_ptr<Buffer>>& exitance) const {
    const gl::Texture2D colour(context_, view.width, view.height, gl::Format::rgba32f),
        depth(context_, view.width, view.height, gl::Format::depth32f);
    const gl::Texture2D* targets[] = {&colour};
    const gl::Framebuffer target(context_, targets, &depth);
    target.clear();
    draw_.set("to_clip", gl::clip_matrix(shared_.scene, projection_of(view.camera, view.width, view.height), view.width,
                                         view.height));
    for (std::size_t i = 0; i < meshes_.size(); ++i) {
      const Buffer* attributes[] = {&meshes_[i]->positions, exitance[i].get()};
      const gl::VertexArray mesh(context_, attributes, &meshes_[i]->triangles);
      draw_.set("object", static_cast<float>(i + 1));
      draw_.use();
      mesh.draw_indexed(meshes_[i]->triangle_count);
    }
    context_.check_errors();
    return colour.read();
  }

  void read_object(std::size_t i, const GBuffer& view, const std::vector<float>& film, const Buffer& exitance,
                   Frame& frame) const {
    const PointPlaces points = places_of_object(shared_, transfer_, view, i);
    std::vector<float> at_vertices;
    for (std::size_t k = 0; k < points.indices.size(); ++k) {
      const VisiblePoint& p = view.points[points.indices[k]];
      const int x = static_cast<int>(p.pixel) % view.width, y = static_cast<int>(p.pixel) / view.width;
      const float* texel = &film[4 * static_cast<std::size_t>((view.height - 1 - y) * view.width + x)];
      if (texel[3] == static_cast<float>(i + 1)) {
        frame.exitance[points.indices[k]] = {texel[0], texel[1], texel[2]};
        continue;
      }
      if (at_vertices.empty()) at_vertices = exitance.read<float>();
      frame.exitance[points.indices[k]] = interpolated(points.places[k], [&](std::uint32_t v) {
        return glm::vec3(at_vertices[3 * v], at_vertices[3 * v + 1], at_vertices[3 * v + 2]);
      });
      ++frame.counters.done["pixels_off_raster"];
    }
  }

  const SharedScene& shared_;
  const gl::Context& context_;
  TransferScene transfer_;
  Programs programs_;
  gl::Program draw_;
  std::vector<std::unique_ptr<GlTransfer>> tables_;
  std::vector<std::unique_ptr<GlMesh>> meshes_;
};

}  // namespace

std::unique_ptr<PreparedTechnique> prepare_transfer_gl(const SharedScene& shared, const Settings& settings,
                                                       const gl::Context& context) {
  return std::make_unique<PreparedTransferGl>(shared, read_transfer_settings(settings), context);
}

}  // namespace opaline
