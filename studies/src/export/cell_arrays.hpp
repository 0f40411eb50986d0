#pragma once
/// What cells are made of and how they are strained, as arrays in the world's frame.

#include "body_grid.hpp"

#include <vtkCellData.h>
#include <vtkFieldData.h>

namespace maille::studies {

/// MaterialId, FiberDirection and, of a segmentation, Label.
void add_matter(vtkCellData& arrays, const Scene& scene, const Placement& placement,
                const BodyNumbering& numbering);
/// MaterialNames, by MaterialId; of a segmentation LabelNumbers, ascending, and LabelMaterials, their
/// materials' names.
void add_names(vtkFieldData& arrays, const Scene& scene);

/// Strain, PrincipalStrain and FiberStrain; with stress also Stress, VonMises and FiberStress. Those of
/// fibres where has_fibres().
void add_strain_and_stress(vtkCellData& arrays, const Scene& scene, const Displacement& displacement,
                           const Placement& placement, const BodyNumbering& numbering, bool with_stress);

/// True if a direction of fibres means anything in the scene: some matter differs along it, contracts along
/// it, or has it from data.
bool has_fibres(const Scene& scene);

} // namespace maille::studies
