// What a run of white walks leaves behind: how many walks ended where after how many scatterings. All results for
// any albedo follow from these whole numbers, so adding up runs in any order gives the same bits.
//
// Lengths are in mean free paths 1/sigma_t. Memory: 8 bytes x annuli x the longest walk's number of scatterings.
#pragma once

#include "model/transport/walk_kernel.h"

#include <cstdint>
#include <vector>

namespace opaline {

/// Which annulus a squared radius lies in, by a table over the leading bits of the float.
class Annuli {
 public:
  Annuli() = default;

  /// `radii`: ascending edges >= 0 [mfp]; without any there is only the outside.
  explicit Annuli(std::vector<double> radii);

  const std::vector<double>& radii() const { return radii_; }

  /// Annuli, and one more bin for what lies outside of them all.
  std::size_t bins() const { return squared_.empty() ? 1 : squared_.size(); }

  /// Annulus i is radii[i] <= r < radii[i+1]; bins() - 1 is outside of them all.
  std::size_t bin(float r2) const;

 private:
  std::vector<double> radii_;
  std::vector<float> squared_;
  std::vector<std::uint16_t> first_;  // edges at or below the smallest r^2 with these leading bits
};

/// Ends of walks, by number of scatterings n and annulus.
struct WalkCounts {
  Annuli annuli;
  double optical_thickness = 0;  // [mfp], infinity for a half space
  double specular = 0;           // Fresnel reflectance of the beam: walks count what has entered
  double survival = 1;           // roulette at every scattering after the first free ones
  std::uint32_t free_scatterings = 0;
  std::uint64_t walks = 0, scatterings = 0;
  std::vector<std::uint64_t> reflected;    // [n * bins + bin]
  std::vector<std::uint64_t> transmitted;  // the same; empty for a half space
  std::vector<std::uint64_t> killed;       // [n]: lost to the roulette at the n-th scattering

  /// Rows there are: at least one more than the largest n.
  std::size_t rows() const { return killed.size(); }

  void add(const WalkEnds& ends);
  void add(const WalkCounts& other);  // a run with the same annuli, slab and roulette
  void trim();                        // drops empty rows at the end

 private:
  void resize_rows(std::size_t count);
};

}  // namespace opaline
