#pragma once
/// A material: constants, density, optional limits and failure data; and checks of materials made by
/// programs.

#include "maille/materials/elasticity.hpp"
#include "maille/materials/law.hpp"

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace maille {

/// Limits of links along the axes 1, 2, 3 of a frame that the owner defines, as ratios of the link's rest
/// length. Valid: 0 <= compress <= 1 <= stretch, shear >= 0.
struct NeighbourLimits {
  std::array<double, 3> stretch{1, 1, 1};  ///< largest distance / rest, per link axis
  std::array<double, 3> compress{1, 1, 1}; ///< smallest distance / rest, per link axis
  std::array<std::array<double, 3>, 3>
      shear{}; ///< largest shear / rest, [link axis][component]; diagonal unused

  friend bool operator==(const NeighbourLimits&, const NeighbourLimits&) = default;
};

/// Transforms limits of a material from its own axes to the axes of the object (R = `axes`, columns =
/// material axes). This is our convention, not a law: limits of a rotated material are not boxes in the
/// object's frame. Along an axis the slacks are averaged, slack_a = sum_i R_ai^2 slack_i, for stretch and for
/// compression. In shear, shear_ab = sum_{i != j} R_ai^2 R_bj^2 shear_ij / sum_{i != j} R_ai^2 R_bj^2 for a
/// != b. Exact for quarter turns, which permute the limits; equal limits stay equal under any rotation.
NeighbourLimits turned(const NeighbourLimits& limits, const Eigen::Matrix3d& axes);

/// Compliance of a link: 1 / E_a along its axis, 1 / G_ab in shear [1/Pa]. `taut` limits are proportional to
/// it: a chain of taut links is the elastic bar.
struct LinkCompliance {
  std::array<double, 3> axial{};
  std::array<std::array<double, 3>, 3> shear{}; ///< symmetric, diagonal unused
};

/// Uniaxial and shear compliances of a reduced stiffness (see reduced_stiffness) along the scene's axes;
/// entries of axes beyond the scene's dimension stay 0.
LinkCompliance link_compliance(const Eigen::MatrixXd& reduced_stiffness);

/// Deformation at failure; larger limits are those of torn matter.
struct Damage {
  std::array<double, 3> stretch{1, 1, 1}; ///< length / rest at failure along the material's axes, > 1
  /// Length / rest at failure, 0 to 1; nothing if unknown.
  std::optional<std::array<double, 3>> compress;
  /// Shear / rest at failure, [link axis][component]; nothing if unknown.
  std::optional<std::array<std::array<double, 3>, 3>> shear;
  std::string of;        ///< specimen and mode of failure; may be empty except in the library
  std::string source;    ///< as for LibraryEntry
  bool verified = false; ///< as for LibraryEntry
};

/// The limits at which matter begins to fail, along its own axes. Measured limits are used directly. The
/// others follow from the stretches, so that no direction is stretched further than matter is known to bear:
///
///   shear between axes a and b:  lambda - 1 / lambda, which stretches some direction between them by lambda,
///                                the smaller of the two stretches (simple shear by gamma has the principal
///                                stretch lambda, gamma = lambda - 1 / lambda)
///   compression along a:         1 / lambda^2, which stretches matter of constant volume by lambda across,
///                                equally in all directions; lambda is the smallest stretch of the other
///                                two axes
///
/// Both are geometry, not data, and conservative only if matter does not fail otherwise.
/// Source  own derivation
NeighbourLimits limits_before_failure(const Damage& damage);

struct Material {
  std::string name;                      ///< "muscle/soleus", or the key in the scene that defines it
  ElasticConstants elasticity;           ///< in the material frame, axis 1 = fibre
  std::optional<Law> law;                ///< at large strain; none: corotated linear elasticity. With a law,
                                         ///< elasticity is rest_constants(law)
  double density = 1000;                 ///< kg/m^3, > 0
  std::optional<NeighbourLimits> limits; ///< in the material frame
  std::optional<Damage> damage;          ///< nothing if unknown; in the material frame
  /// Factors > 0 on the modulus of `relaxed` along axis 1, 2, 3 of a component's own links; other methods
  /// ignore them. In the material frame, transformed as slack is (see turned).
  std::array<double, 3> relaxed_weights{1, 1, 1};
};

/// True if the fibre changes neither the elasticity nor the law.
bool is_isotropic(const Material& material);

/// A rule that a number violates: its key, the rule, and the actual value.
struct BrokenRule {
  std::string key; ///< e.g. `E`, `stretch`, `damage.stretch`, `law.c1`, `density`
  std::string expected, found;
};

/// All violated rules; empty if everything is valid.
///
/// Constants must be finite with positive strain energy (see violated_inequalities); keys E, nu, G. Limits
/// must be finite, with 0 <= compress <= 1 <= stretch and shear >= 0. A material must also have a finite
/// density > 0, finite weights > 0, and, if its damage is known, stretches > 1 at failure. Parameters of a
/// law must be in the ranges that the law states; keys are their names.
std::vector<BrokenRule> broken_rules(const ElasticConstants& constants);
std::vector<BrokenRule> broken_rules(const NeighbourLimits& limits);
std::vector<BrokenRule> broken_rules(Law law);
std::vector<BrokenRule> broken_rules(const Material& material);

} // namespace maille
