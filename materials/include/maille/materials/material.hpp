#pragma once
/// What a kind of matter is: constants, density, limits if it has its own, where it fails if that is known;
/// and what is wrong with one that a program has put together.

#include "maille/materials/elasticity.hpp"
#include "maille/materials/law.hpp"

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace maille {

/// Limits of links along the axes 1, 2, 3 of whatever frame the holder states, as ratios of the link's
/// rest length. Valid: 0 <= compress <= 1 <= stretch, shear >= 0.
struct NeighbourLimits {
  std::array<double, 3> stretch{1, 1, 1};  ///< largest distance / rest, per link axis
  std::array<double, 3> compress{1, 1, 1}; ///< smallest distance / rest, per link axis
  std::array<std::array<double, 3>, 3>
      shear{}; ///< largest shear / rest, [link axis][component]; diagonal unused

  friend bool operator==(const NeighbourLimits&, const NeighbourLimits&) = default;
};

/// Limits of a material along its own axes, seen along the axes of the object (R = `axes`, columns = material
/// axes). This is our convention, not a law: limits of a turned material are not boxes in the object's frame.
/// Along an axis the slacks are averaged, slack_a = sum_i R_ai^2 slack_i, for stretch and for compression. In
/// shear, shear_ab = sum_{i != j} R_ai^2 R_bj^2 shear_ij / sum_{i != j} R_ai^2 R_bj^2 for a != b. Exact for
/// quarter turns, which permute the limits; equal limits stay equal under any turn.
NeighbourLimits turned(const NeighbourLimits& limits, const Eigen::Matrix3d& axes);

/// How much a link gives way per pascal: 1 / E_a along its axis, 1 / G_ab in shear [1/Pa]. `taut` limits are
/// in proportion to it: a chain whose links are all taut is the elastic bar.
struct LinkCompliance {
  std::array<double, 3> axial{};
  std::array<std::array<double, 3>, 3> shear{}; ///< symmetric, diagonal unused
};

/// Uniaxial and shear compliances of a reduced stiffness (see reduced_stiffness) along the scene's axes;
/// entries of axes that the scene has not stay 0.
LinkCompliance link_compliance(const Eigen::MatrixXd& reduced_stiffness);

/// Limits beyond are limits of torn matter.
struct Damage {
  std::array<double, 3> stretch{1, 1, 1}; ///< length / rest at failure along the material's axes, > 1
  /// Length / rest at failure, from 0 to 1; nothing where no source has it.
  std::optional<std::array<double, 3>> compress;
  /// Shear / rest at failure, [link axis][component]; nothing where no source has it.
  std::optional<std::array<std::array<double, 3>, 3>> shear;
  std::string of;        ///< what was pulled, and what failed; may be empty but in the library
  std::string source;    ///< as for LibraryEntry
  bool verified = false; ///< as for LibraryEntry
};

/// The limits at which matter begins to fail, along its own axes. What was measured is taken as it is. What
/// was not follows from the stretches, if no direction may be drawn out further than matter is known to bear:
///
///   shear between axes a and b:  lambda - 1 / lambda, which draws out some direction between them by lambda,
///   the smaller of the
///                                two stretches (simple shear by gamma has the principal stretch lambda,
///                                gamma = lambda - 1 / lambda)
///   compression along a:         1 / lambda^2, which draws out matter that keeps its volume by lambda
///   across, alike to all sides;
///                                lambda is the smallest stretch of the other two axes
///
/// Both are geometry, not data, and on the safe side only as far as matter does not fail otherwise.
/// Source  own derivation
NeighbourLimits limits_before_failure(const Damage& damage);

struct Material {
  std::string name;                      ///< "muscle/soleus", or the key where a scene defines it
  ElasticConstants elasticity;           ///< in the material frame, axis 1 = fibre
  std::optional<Law> law;                ///< of large strain; none: corotated linear elasticity. With one,
                                         ///< elasticity is rest_constants(law)
  double density = 1000;                 ///< kg/m^3, > 0
  std::optional<NeighbourLimits> limits; ///< in the material frame
  std::optional<Damage> damage;          ///< nothing where no figure is known; in the material frame
  /// Factors > 0 on what `relaxed` takes for the modulus along axis 1, 2, 3 of a component's own links; no
  /// other method sees them. In the material frame, turned as slack is (see turned).
  std::array<double, 3> relaxed_weights{1, 1, 1};
};

/// True if the fibre changes neither the elasticity nor the law.
bool is_isotropic(const Material& material);

/// A rule that a number breaks: which number, the rule, and what stands there instead.
struct BrokenRule {
  std::string key; ///< e.g. `E`, `stretch`, `damage.stretch`, `law.c1`, `density`
  std::string expected, found;
};

/// Rules that are broken, of each number all; empty where everything is valid.
///
/// Constants must be finite and of positive strain energy (see violated_inequalities); keys E, nu, G. Limits
/// must be finite, with 0 <= compress <= 1 <= stretch and shear >= 0. A material must also have a finite
/// density > 0, finite weights > 0, and, if its damage is known, stretches > 1 at failure. Parameters of a
/// law must be in the ranges that the law states; keys are their names.
std::vector<BrokenRule> broken_rules(const ElasticConstants& constants);
std::vector<BrokenRule> broken_rules(const NeighbourLimits& limits);
std::vector<BrokenRule> broken_rules(Law law);
std::vector<BrokenRule> broken_rules(const Material& material);

} // namespace maille
