// From a picture file's values to linear light.
#pragma once

#include <string>
#include <utility>
#include <vector>

namespace opaline {

/// "linear", "srgb" (IEC 61966-2-1), "rec709" (ITU-R BT.709 camera curve), "gamma:G" (value^G), or a .csv file with
/// lines ENCODED,LINEAR, both rising, interpolated between: a measured camera response.
class TransferCurve {
 public:
  TransferCurve() = default;
  /// Throws InputError naming the valid words.
  static TransferCurve parse(const std::string& text);

  /// Of a stored value; integers are stored as fractions of their largest. Values outside a table's ends are held.
  double to_linear(double encoded) const;
  const std::string& name() const { return name_; }

 private:
  std::string name_ = "linear";
  double gamma_ = 1;
  std::vector<std::pair<double, double>> table_;
};

/// Formats that store linear light by convention: .exr, .hdr, .pfm. All others must say what they hold.
bool linear_by_convention(const std::string& path);

}  // namespace opaline
