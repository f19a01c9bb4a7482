#include "fit/transfer_curve.h"

#include "render/input_error.h"
#include "render/srgb.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <sstream>

namespace opaline {
namespace {

std::string extension(const std::string& path) {
  std::string e = std::filesystem::path(path).extension().string();
  std::transform(e.begin(), e.end(), e.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return e;
}

std::vector<std::pair<double, double>> read_table(const std::string& path) {
  std::ifstream in(path);
  if (!in) throw InputError(path, "", "the transfer curve cannot be read");
  std::vector<std::pair<double, double>> table;
  std::string line;
  for (int number = 1; std::getline(in, line); ++number) {
    std::replace(line.begin(), line.end(), ',', ' ');
    std::istringstream words(line);
    double encoded = 0, linear = 0;
    if (!(words >> encoded)) continue;  // a heading or an empty line
    const bool good = static_cast<bool>(words >> linear) && std::isfinite(encoded) && std::isfinite(linear);
    if (!good || (!table.empty() && (encoded <= table.back().first || linear <= table.back().second)))
      throw InputError(path, fmt::format("line {}", number), "needs ENCODED,LINEAR, both rising from line to line");
    table.emplace_back(encoded, linear);
  }
  if (table.size() < 2) throw InputError(path, "", "a transfer curve needs at least two lines ENCODED,LINEAR");
  return table;
}

double rec709(double encoded) {
  return encoded < 0.081 ? encoded / 4.5 : std::pow((encoded + 0.099) / 1.099, 1 / 0.45);
}

}  // namespace

TransferCurve TransferCurve::parse(const std::string& text) {
  TransferCurve curve;
  curve.name_ = text;
  if (text == "linear" || text == "srgb" || text == "rec709") return curve;
  if (extension(text) == ".csv") {
    curve.table_ = read_table(text);
    return curve;
  }
  std::istringstream number(text.rfind("gamma:", 0) == 0 ? text.substr(6) : "");
  if (!(number >> curve.gamma_) || !number.eof() || !(curve.gamma_ > 0))
    throw InputError("--transfer", "", "'" + text + "' is not one of linear, srgb, rec709, gamma:G, FILE.csv");
  return curve;
}

double TransferCurve::to_linear(double encoded) const {
  if (!std::isfinite(encoded)) return encoded;
  if (!table_.empty()) {
    if (encoded <= table_.front().first) return table_.front().second;
    if (encoded >= table_.back().first) return table_.back().second;
    const auto above = std::upper_bound(table_.begin(), table_.end(), encoded,
                                        [](double value, const auto& row) { return value < row.first; });
    const auto& [x_1, y_1] = *above;
    const auto& [x_0, y_0] = *(above - 1);
    return y_0 + (y_1 - y_0) * (encoded - x_0) / (x_1 - x_0);
  }
  if (name_ == "linear") return encoded;
  const double size = std::abs(encoded);  // a float file may hold noise below 0
  const double linear = name_ == "srgb"     ? linear_from_srgb(size)
                        : name_ == "rec709" ? rec709(size)
                                            : std::pow(size, gamma_);
  return std::copysign(linear, encoded);
}

bool linear_by_convention(const std::string& path) {
  const std::string e = extension(path);
  return e == ".exr" || e == ".hdr" || e == ".pfm";
}

}  // namespace opaline
