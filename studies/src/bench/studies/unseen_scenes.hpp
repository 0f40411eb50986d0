#pragma once
/// Scenes that no stored trade was made of.

#include <cstdint>
#include <random>
#include <string>

namespace maille::studies {

/// A scene file and what is wanted of it.
struct UnseenScene {
  std::string text; ///< TOML
  std::string shape, load, material;
  double error = 0, seconds = 0; ///< wished
};

/// Draws scenes: boxes, bellies and ellipsoids; pulled, bent and poked; isotropic to a Poisson ratio of 0.49
/// or with fibres up to 20 times as stiff along as across, turned by any angle; 8 to 32 cells along an axis.
/// The table (scripts/trade-table) holds other loads (but for bellies that are pulled), other materials and
/// other sizes. Wishes: errors of 1.5 to 40 %, times of 0.3 to 300 ms, evenly on a logarithm.
/// Repeatable: the same scenes everywhere
class UnseenScenes {
public:
  explicit UnseenScenes(std::uint32_t seed) : lot_(seed) {}
  UnseenScene draw();

private:
  double between(double low, double high) {
    return low + (high - low) * static_cast<double>(lot_()) / 4294967296.0;
  }
  int whole(int low, int high) {
    return low + static_cast<int>(lot_() % static_cast<std::uint32_t>(high - low + 1));
  }
  double on_logarithm(double low, double high);
  std::string draw_material(std::string& words);
  std::string draw_load(const std::string& shape, const int (&cells)[3], std::string& words);

  std::mt19937 lot_; // its numbers are the same everywhere, those of distributions are not
};

} // namespace maille::studies
