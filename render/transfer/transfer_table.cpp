#include "render/transfer/transfer_table.h"

#include "model/check.h"
#include "render/irradiance/certified_criterion.h"
#include "render/transfer/transfer_sum.h"

#include <cmath>

namespace opaline {
namespace {

struct TransferSink {
  using Patches = PatchList;
  const ProfileSum& profile;
  const TransferTree& tree;
  std::span<const OwnDisc> discs;
  float* out;  ///< [vertex][table][column]
  std::span<const std::uint32_t> queries{};
  std::span<const glm::vec3> positions{};
  std::vector<OwnDisc> own{};
  std::vector<float> sums{};

  std::size_t width() const { return static_cast<std::size_t>(profile.table_count) * transfer_columns; }
  void begin_group(std::span<const std::uint32_t> group, std::span<const glm::vec3> at) {
    queries = group, positions = at;
    sums.assign(group.size() * width(), 0.0f);
    own.clear();
    if (discs.empty()) return;
    for (const std::uint32_t q : group) own.push_back(discs[q]);
  }
  void add(const PatchList& patches, std::size_t first, std::size_t count, const std::array<float, 3>&) {
    const std::span<const OwnDisc> discs_of = own.empty() ? own : std::span(own).subspan(first, count);
    add_transfer_sums(profile, tree, patches, positions.subspan(first, count), discs_of, &sums[first * width()]);
  }
  float end_group() {
    for (std::size_t i = 0; i < queries.size(); ++i)
      std::copy_n(&sums[i * width()], width(), out + queries[i] * width());
    return 0;
  }
};

/// Mean of each profile over a disc of an element's area, by its cumulative distribution.
std::vector<OwnDisc> own_discs(const TransferWork& work, const TransferTree& tree) {
  std::vector<OwnDisc> discs;
  if (!work.elements.discs) return discs;
  std::vector<std::uint32_t> leaf_of(work.elements.cells.size());
  for (std::uint32_t n = 0; n < tree.tree().nodes.size(); ++n)
    if (tree.tree().nodes[n].leaf()) leaf_of[tree.tree().nodes[n].cell] = n;
  for (const std::uint32_t element : work.own) {
    OwnDisc disc{leaf_of[element], {}};
    const double area = static_cast<double>(cell_area(work.elements.cells[element]));
    for (int c = 0; c < 3; ++c)
      disc.mean[static_cast<std::size_t>(work.profiles.sum().table_of[c])] =
          static_cast<float>(work.profiles.profile(c).cumulative(std::sqrt(area / pi)) / area);
    discs.push_back(disc);
  }
  return discs;
}

void count(const GatherCounts& c, std::size_t queries, Counters& counters) {
  counters.done["queries"] += queries;
  counters.done["groups"] += c.groups;
  counters.done["nodes_visited"] += c.nodes_visited;
  counters.done["clusters"] += c.clusters;
  counters.done["cells"] += c.cells;
  counters.done["cell_parts"] += c.cell_parts;
  counters.skipped["cell_splits_at_depth_limit"] += c.depth_limit_reached;
}

class TableMaker {
 public:
  TableMaker(const TransferWork& work, Counters& counters)
      : work_(work), counters_(counters), tree_(work.elements.cells), discs_(own_discs(work, tree_)) {}

  void make(std::size_t part, TransferTable& table) {
    const std::size_t first = part * keys_a_part(table), last = std::min(first + keys_a_part(table), table.keys.size());
    light_elements(work_.elements, work_.columns, std::span(table.keys).subspan(first, last - first), work_.eta,
                   work_.rays, work_.unshadowed, irradiance_, counters_);
    tree_.fill(irradiance_);
    sums_.resize(table.vertices * static_cast<std::size_t>(table.tables) * transfer_columns);
    count(gather_part(), table.vertices, counters_);
    turn(first, last, table);
  }

 private:
  GatherCounts gather_part() {
    const ProfileSum& profile = work_.profiles.sum();
    const auto error = static_cast<float>(work_.max_relative_error);
    constexpr float dark = 1e-3f;
    const auto sink = [&] { return TransferSink{profile, tree_, discs_, sums_.data()}; };
    const CertifiedCriterion criterion(tree_.tree(), work_.profiles.bounds(1), profile, error, {dark, dark, dark, 0},
                                       pessimism_of_bounds(work_.max_relative_error));
    return gather(
        tree_.tree(), tree_.cells(), work_.positions, [&] { return criterion; }, sink);
  }

  /// From [vertex][table][column] to rows.
  void turn(std::size_t first, std::size_t last, TransferTable& table) const {
    constexpr std::size_t block = 256;
    const auto tables = static_cast<std::size_t>(table.tables);
    tbb::parallel_for(std::size_t{0}, (table.vertices + block - 1) / block, [&](std::size_t b) {
      const std::size_t end = std::min((b + 1) * block, table.vertices);
      for (std::size_t k = first; k < last; ++k)
        for (std::size_t t = 0; t < tables; ++t) {
          float* row = table.row(k * tables + t);
          for (std::size_t v = b * block; v < end; ++v)
            row[v] = sums_[(v * tables + t) * transfer_columns + (k - first)];
        }
    });
  }

  const TransferWork& work_;
  Counters& counters_;
  TransferTree tree_;
  std::vector<OwnDisc> discs_;
  std::vector<float> irradiance_, sums_;
};

}  // namespace

std::size_t part_count(const TransferTable& table) {
  return (table.keys.size() + keys_a_part(table) - 1) / keys_a_part(table);
}

std::pair<std::size_t, std::size_t> rows_of_part(const TransferTable& table, std::size_t part) {
  const auto tables = static_cast<std::size_t>(table.tables);
  const std::size_t size = keys_a_part(table);
  return {part * size * tables, std::min((part + 1) * size, table.keys.size()) * tables};
}

TransferTable make_transfer_table(const TransferWork& work, std::vector<std::uint32_t> keys, const TransferStore& store,
                                  double from, double to, Counters& counters) {
  const ProfileSum& profile = work.profiles.sum();
  TransferTable table{
      work.columns.vectors,  profile.table_count, {profile.table_of[0], profile.table_of[1], profile.table_of[2]},
      work.positions.size(), std::move(keys),     {}};
  table.values.assign(table.rows() * table.stride(), 0.0f);
  const std::size_t parts = part_count(table);
  std::unique_ptr<TableMaker> maker;
  for (std::size_t part = 0; part < parts; ++part) {
    const double step = (to - from) / static_cast<double>(parts);
    const ProgressSpan span(from + step * static_cast<double>(part), from + step * static_cast<double>(part + 1));
    if (store.restore && store.restore(part, table)) {
      ++counters.skipped["parts_loaded"];
      continue;
    }
    if (!maker) maker = std::make_unique<TableMaker>(work, counters);
    maker->make(part, table);
    ++counters.done["parts"];
    if (store.keep) store.keep(part, table);
  }
  counters.done["transfer_rows"] += table.rows();
  return table;
}

}  // namespace opaline
