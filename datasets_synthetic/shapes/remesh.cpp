#include "datasets_synthetic/shapes/zero_set.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <queue>
#include <tuple>

namespace opaline {
namespace {

constexpr unsigned none = std::numeric_limits<unsigned>::max();

/// A triangle mesh that can be changed: each vertex knows its triangles.
class Remesher {
 public:
  Remesher(const Field& field, RawMesh& mesh)
      : field_(field),
        p_(mesh.positions),
        t_(mesh.triangles),
        around_(p_.size()),
        version_(p_.size(), 0),
        alive_(static_cast<int>(t_.size())) {
    for (unsigned t = 0; t < t_.size(); ++t)
      for (int s = 0; s < 3; ++s) around_[t_[t][s]].push_back(t);
    normals_.reserve(p_.size());
    for (unsigned v = 0; v < p_.size(); ++v) normals_.push_back(glm::normalize(sample_field(field_, p_[v]).gradient));
  }

  int triangle_count() const { return alive_; }

  void collapse_to(int triangles) {
    queue_ = {};
    for (unsigned t = 0; t < t_.size(); ++t)
      for (int s = 0; s < 3 && t_[t].x != none; ++s)
        if (t_[t][s] < t_[t][(s + 1) % 3]) queue_.push(candidate(t_[t][s], t_[t][(s + 1) % 3]));
    while (alive_ > triangles && !queue_.empty()) {
      const Candidate c = queue_.top();
      queue_.pop();
      if (c.stamp_u == version_[c.u] && c.stamp_v == version_[c.v] && !around_[c.u].empty() && !around_[c.v].empty())
        collapse(c.u, c.v);
    }
  }

  /// Halves the costliest edges until there are `triangles`; new vertices lie on the zero set.
  void split_to(int triangles) {
    std::priority_queue<Candidate, std::vector<Candidate>, Cheaper> edges;
    const auto push = [&](unsigned u, unsigned v) { edges.push(candidate(std::min(u, v), std::max(u, v))); };
    for (const glm::uvec3& t : t_)
      for (int s = 0; s < 3 && t.x != none; ++s)
        if (t[s] < t[(s + 1) % 3]) push(t[s], t[(s + 1) % 3]);
    while (alive_ < triangles && !edges.empty()) {
      const Candidate c = edges.top();
      edges.pop();
      if (!split(c.u, c.v)) continue;
      neighbours(static_cast<unsigned>(p_.size()) - 1, ring_u_);
      for (const unsigned w : ring_u_) push(w, static_cast<unsigned>(p_.size()) - 1);
    }
  }

  /// One pass of edge flips towards Delaunay: an edge turns if the angles facing it exceed 180 degrees.
  void flip_edges() {
    for (unsigned t = 0; t < t_.size(); ++t)
      for (int s = 0; s < 3 && t_[t].x != none; ++s)
        if (t_[t][s] < t_[t][(s + 1) % 3]) try_flip(t, t_[t][s], t_[t][(s + 1) % 3], t_[t][(s + 2) % 3]);
  }

  /// Moves each vertex along the zero set towards the middle of its triangles, more towards bent ones.
  void relax() {
    for (unsigned v = 0; v < p_.size(); ++v) {
      if (around_[v].empty()) continue;
      glm::dvec3 sum(0);
      double weight = 0;
      for (const unsigned t : around_[v]) {
        const glm::dvec3 a = p_[t_[t].x], b = p_[t_[t].y], c = p_[t_[t].z];
        const double area = glm::length(glm::cross(b - a, c - a));
        const double pull = area * (1 + 6 * bend(normals_[t_[t].x], normals_[t_[t].y], normals_[t_[t].z]));
        sum += pull / 3 * (a + b + c);
        weight += pull;
      }
      const glm::dvec3 n = normals_[v], move = sum / weight - p_[v];
      place(v, p_[v] + 0.6 * (move - glm::dot(move, n) * n));
    }
  }

  /// One more Newton step for every vertex.
  void settle() {
    for (unsigned v = 0; v < p_.size(); ++v)
      if (!around_[v].empty()) place(v, p_[v]);
  }

  void compact(RawMesh& mesh) {
    std::vector<unsigned> renamed(p_.size(), none);
    std::vector<glm::dvec3> kept;
    for (unsigned v = 0; v < p_.size(); ++v)
      if (!around_[v].empty()) {
        renamed[v] = static_cast<unsigned>(kept.size());
        kept.push_back(p_[v]);
      }
    std::erase_if(t_, [](const glm::uvec3& t) { return t.x == none; });
    for (glm::uvec3& t : t_) t = {renamed[t.x], renamed[t.y], renamed[t.z]};
    mesh.positions = std::move(kept);
  }

 private:
  struct Candidate {
    double cost;
    unsigned u, v, stamp_u, stamp_v;
  };
  /// Orders for the two queues; the vertices decide ties, so that the result is always the same.
  struct Cheaper {
    bool operator()(const Candidate& a, const Candidate& b) const {
      return std::tie(a.cost, a.u, a.v) < std::tie(b.cost, b.u, b.v);
    }
  };
  struct Dearer {
    bool operator()(const Candidate& a, const Candidate& b) const { return Cheaper{}(b, a); }
  };

  /// 0 where three normals agree, up to 1.
  static double bend(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c) {
    return 1 - glm::length(a + b + c) / 3;
  }

  Candidate candidate(unsigned u, unsigned v) const {
    const glm::dvec3 e = p_[u] - p_[v];
    return {glm::dot(e, e) * (1 + 30 * bend(normals_[u], normals_[v], normals_[v])), u, v, version_[u], version_[v]};
  }

  void neighbours(unsigned v, std::vector<unsigned>& out) const {
    out.clear();
    for (const unsigned t : around_[v])
      for (int s = 0; s < 3; ++s)
        if (t_[t][s] == v) out.push_back(t_[t][(s + 1) % 3]);
    std::sort(out.begin(), out.end());
  }

  /// Would triangle t keep facing `normal`, and not become a sliver, with vertex v moved to q?
  bool stays_upright(unsigned t, unsigned v, const glm::dvec3& q) const {
    std::array<glm::dvec3, 3> a;
    glm::dvec3 normal(0);
    for (int s = 0; s < 3; ++s) {
      a[s] = t_[t][s] == v ? q : p_[t_[t][s]];
      normal += normals_[t_[t][s]];
    }
    return faces(a, normal);
  }

  static bool faces(const std::array<glm::dvec3, 3>& a, const glm::dvec3& normal) {
    const glm::dvec3 e0 = a[1] - a[0], e1 = a[2] - a[1], e2 = a[0] - a[2], n = glm::cross(e0, e1);
    const double longest = std::max({glm::dot(e0, e0), glm::dot(e1, e1), glm::dot(e2, e2)});
    const double doubled_area = glm::length(n);
    return doubled_area > 0.1 * longest && glm::dot(n, normal) > 0.3 * doubled_area * glm::length(normal);
  }

  bool may_collapse(unsigned u, unsigned v, const glm::dvec3& q) {
    neighbours(u, ring_u_);
    neighbours(v, ring_v_);
    common_.clear();
    std::set_intersection(ring_u_.begin(), ring_u_.end(), ring_v_.begin(), ring_v_.end(), std::back_inserter(common_));
    if (common_.size() != 2 || ring_u_.size() + ring_v_.size() > 13) return false;
    for (const unsigned w : common_)
      if (around_[w].size() <= 4) return false;
    const auto upright = [&](unsigned from, unsigned other) {
      return std::all_of(around_[from].begin(), around_[from].end(),
                         [&](unsigned t) { return has(t, other) || stays_upright(t, from, q); });
    };
    return upright(u, v) && upright(v, u);
  }

  bool has(unsigned t, unsigned v) const { return t_[t].x == v || t_[t].y == v || t_[t].z == v; }

  void collapse(unsigned u, unsigned v) {
    const glm::dvec3 middle = 0.5 * (p_[u] + p_[v]);
    const FieldSample s = sample_field(field_, middle);
    const glm::dvec3 q = onto(middle, s);
    if (!same_side(s.gradient, u) || !same_side(s.gradient, v) || !may_collapse(u, v, q)) return;
    for (const unsigned t : std::vector<unsigned>(around_[v])) {
      if (has(t, u)) {
        remove(t);
        continue;
      }
      for (int k = 0; k < 3; ++k)
        if (t_[t][k] == v) t_[t][k] = u;
      around_[u].push_back(t);
    }
    around_[v].clear();
    p_[u] = q;
    normals_[u] = glm::normalize(s.gradient);
    ++version_[u];
    ++version_[v];
    neighbours(u, ring_u_);
    for (const unsigned w : ring_u_) queue_.push(candidate(std::min(u, w), std::max(u, w)));
  }

  void remove(unsigned t) {
    for (int s = 0; s < 3; ++s) std::erase(around_[t_[t][s]], t);
    t_[t].x = none;
    --alive_;
  }

  /// Halves the edge uv with its two triangles (u, v, a) and (v, u, b).
  bool split(unsigned u, unsigned v) {
    const auto with_edge = [&](unsigned from, unsigned to) {
      return *std::find_if(around_[from].begin(), around_[from].end(), [&](unsigned t) {
        for (int s = 0; s < 3; ++s)
          if (t_[t][s] == from && t_[t][(s + 1) % 3] == to) return true;
        return false;
      });
    };
    const unsigned t = with_edge(u, v), o = with_edge(v, u);
    const unsigned a = third(t, u, v), b = third(o, u, v);
    const FieldSample s = sample_field(field_, 0.5 * (p_[u] + p_[v]));
    const glm::dvec3 q = onto(0.5 * (p_[u] + p_[v]), s), normal = glm::normalize(s.gradient);
    if (!same_side(normal, u) || !same_side(normal, v)) return false;
    if (!faces({p_[u], q, p_[a]}, normal) || !faces({q, p_[v], p_[a]}, normal) || !faces({p_[v], q, p_[b]}, normal) ||
        !faces({q, p_[u], p_[b]}, normal))
      return false;
    const auto m = static_cast<unsigned>(p_.size()), t2 = static_cast<unsigned>(t_.size()), o2 = t2 + 1;
    p_.push_back(q);
    normals_.push_back(normal);
    version_.push_back(0);
    around_.push_back({t, o, t2, o2});
    t_[t] = {u, m, a};
    t_[o] = {m, u, b};
    t_.emplace_back(m, v, a);
    t_.emplace_back(v, m, b);
    std::erase(around_[v], t);
    std::erase(around_[v], o);
    for (const auto& [vertex, triangle] : {std::pair(v, t2), {a, t2}, {v, o2}, {b, o2}})
      around_[vertex].push_back(triangle);
    alive_ += 2;
    return true;
  }

  /// Does a gradient agree with the normal at v? In a thin sheet it may belong to the other face.
  bool same_side(const glm::dvec3& gradient, unsigned v) const {
    return glm::dot(gradient, normals_[v]) > 0.2 * glm::length(gradient);
  }

  unsigned third(unsigned t, unsigned u, unsigned v) const { return t_[t].x ^ t_[t].y ^ t_[t].z ^ u ^ v; }

  /// One Newton step from p, where the field was sampled, to the zero set.
  static glm::dvec3 onto(const glm::dvec3& p, const FieldSample& s) {
    return p - s.value / std::max(glm::dot(s.gradient, s.gradient), 0.05) * s.gradient;
  }

  /// Triangle t = (u, v, a); its neighbour across uv is (v, u, b).
  void try_flip(unsigned t, unsigned u, unsigned v, unsigned a) {
    const auto other =
        std::find_if(around_[u].begin(), around_[u].end(), [&](unsigned o) { return o != t && has(o, v); });
    const unsigned o = *other;
    const unsigned b = third(o, u, v);
    if (around_[u].size() <= 4 || around_[v].size() <= 4 || !angles_exceed_half_turn(u, v, a, b)) return;
    neighbours(a, ring_u_);
    if (std::binary_search(ring_u_.begin(), ring_u_.end(), b)) return;
    const glm::dvec3 normal = normals_[u] + normals_[v] + normals_[a] + normals_[b];
    if (!faces({p_[u], p_[b], p_[a]}, normal) || !faces({p_[v], p_[a], p_[b]}, normal)) return;
    t_[t] = {u, b, a};
    t_[o] = {v, a, b};
    std::erase(around_[u], o);
    std::erase(around_[v], t);
    around_[a].push_back(o);
    around_[b].push_back(t);
  }

  bool angles_exceed_half_turn(unsigned u, unsigned v, unsigned a, unsigned b) const {
    const auto angle = [&](unsigned at) {
      const glm::dvec3 x = p_[u] - p_[at], y = p_[v] - p_[at];
      return std::atan2(glm::length(glm::cross(x, y)), glm::dot(x, y));
    };
    return angle(a) + angle(b) > 3.1416;
  }

  /// Puts v on the zero set near q, unless that spoils a triangle.
  void place(unsigned v, const glm::dvec3& q) {
    const FieldSample s = sample_field(field_, q);
    const glm::dvec3 on = onto(q, s);
    if (!same_side(s.gradient, v)) return;
    for (const unsigned t : around_[v])
      if (!stays_upright(t, v, on) && stays_upright(t, v, p_[v])) return;
    p_[v] = on;
    normals_[v] = glm::normalize(s.gradient);
  }

  const Field& field_;
  std::vector<glm::dvec3>& p_;
  std::vector<glm::uvec3>& t_;
  std::vector<std::vector<unsigned>> around_;
  std::vector<unsigned> version_;
  std::vector<glm::dvec3> normals_;
  std::priority_queue<Candidate, std::vector<Candidate>, Dearer> queue_;
  int alive_;
  std::vector<unsigned> ring_u_, ring_v_, common_;
};

}  // namespace

void remesh(const Field& field, RawMesh& mesh, int triangles) {
  Remesher remesher(field, mesh);
  // A collapse refused once may be possible after flips and slides: that matters for low counts.
  for (int pass = 0; pass < 8 && remesher.triangle_count() > triangles * 3 / 4; ++pass) {
    if (pass > 0) {
      remesher.flip_edges();
      remesher.relax();
    }
    remesher.collapse_to(triangles * 3 / 4);
  }
  remesher.split_to(triangles);
  for (int pass = 0; pass < 4; ++pass) {
    remesher.flip_edges();
    remesher.relax();
  }
  remesher.flip_edges();
  remesher.settle();
  remesher.compact(mesh);
}

}  // namespace opaline
