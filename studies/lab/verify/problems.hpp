#pragma once
/// The families of problems behind verify().

#include "maille/scene/answer.hpp"
#include "verify/verification.hpp"

namespace maille::lab {

/// Collects rows; problems ask it for answers.
class Verification {
public:
  explicit Verification(const VerificationOptions& options);

  bool is_quick() const { return options_.quick; }
  /// Methods that answer scenes with displacements.
  const std::vector<std::string>& methods() const { return methods_; }
  /// What a scene's text says. @throws InputError: a problem is wrong
  static Scene scene(const std::string& text);
  /// A settled answer; on failure adds a row without a number.
  std::optional<Answer> answer(const Scene& scene, const std::string& method, const VerificationRow& row);
  void add(VerificationRow row) { rows_.push_back(std::move(row)); }
  void report(std::string_view what, double fraction) const;
  std::vector<VerificationRow> take() { return std::move(rows_); }

private:
  const VerificationOptions& options_;
  std::vector<std::string> methods_;
  std::vector<VerificationRow> rows_;
};

/// Bars: end load, own weight, two materials in series.
void verify_bars(Verification& verification);
/// Patches: linear displacements of every symmetry of material.
void verify_patches(Verification& verification);
/// Manufactured solutions: orders of convergence in L2.
void verify_orders(Verification& verification);
/// A slender cantilever, a square bar in torsion, a strip pulled off its fibres' axis.
void verify_beams(Verification& verification);
/// Specimens that are not boxes: Cook's membrane, the thick elliptic plate of NAFEMS.
void verify_curved(Verification& verification);
/// A half space under pressure on a square.
void verify_indentation(Verification& verification);

} // namespace maille::lab
