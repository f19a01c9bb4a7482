// The harmonics of a table's rows, level by level.
#pragma once

#include "render/transfer/harmonics.h"
#include "render/transfer/transfer_table.h"

namespace opaline {

class HarmonicFit {
 public:
  /// The table has all directions of every level it has. Throws InputError("--set directions") where they are too few.
  HarmonicFit(const TransferTable& table, const TransferNodes& nodes, int order);

  /// level * order^2 + coefficient, ascending.
  const std::vector<std::uint32_t>& keys() const { return keys_; }
  /// A row for each key and distinct profile, as the rows of a table: key index * tables + table.
  std::vector<float> coefficients(const TransferTable& table) const;
  /// Takes from a table what the coefficients of its rows say of them; the rest is what they cannot hold.
  void subtract(const std::vector<float>& coefficients, TransferTable& table) const;

 private:
  std::size_t per_level_, coefficients_;
  std::vector<std::uint32_t> keys_;
  std::vector<double> projection_;  ///< coefficient * directions + direction
  std::vector<double> basis_;       ///< direction * coefficients + coefficient
};

}  // namespace opaline
