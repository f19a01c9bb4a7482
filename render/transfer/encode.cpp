#include "render/transfer/encode.h"

#include "model/check.h"
#include "render/input_error.h"
#include "render/transfer/harmonic_fit.h"

namespace opaline {

EncodedTransfer encode_rows(TransferTable table, RowStorage storage) {
  EncodedTransfer out;
  out.basis = table.vectors ? TransferBasis::vectors : TransferBasis::nodes;
  out.keys = table.keys;
  out.tables = table.tables;
  std::copy_n(table.table_of, 3, out.table_of);
  const std::size_t rows = table.rows();
  out.rows = CodedRows(storage, std::move(table.values), rows, table.vertices, table.tables);
  return out;
}

EncodedTransfer encode_harmonics(const TransferTable& table, const TransferNodes& nodes, int order,
                                 RowStorage storage) {
  const HarmonicFit fit(table, nodes, order);
  EncodedTransfer out;
  out.basis = TransferBasis::harmonics;
  out.order = order;
  out.keys = fit.keys();
  out.tables = table.tables;
  std::copy_n(table.table_of, 3, out.table_of);
  std::vector<float> values = fit.coefficients(table);
  const std::size_t rows = fit.keys().size() * static_cast<std::size_t>(table.tables);
  // Coefficients differ in size from row to row, so each row has a codebook of its own.
  out.rows = CodedRows(storage, std::move(values), rows, table.vertices, static_cast<int>(rows));
  return out;
}

}  // namespace opaline
