#pragma once
/// Scenes as input of CalculiX (Dhondt and Wittig, ccx 2.20), a finite-element program that shares nothing
/// with ours.

#include "maille/scene/answer.hpp"

#include <istream>
#include <string>

namespace maille::studies {

/// An input deck for one linear static step: the question that fem_q1 answers, element by element.
///
/// Every cell of matter is a C3D8 brick, which ccx 2.20 integrates at 2 x 2 x 2 points as fem_q1 does, so the
/// answers differ by what ccx prints (seven digits). In 2D and 1D the bricks are one layer 1 m thick whose
/// sides are tied together and do not leave the plane or line. Nodes are numbered from 1 as in matter_only(),
/// copies of a layer after all of them.
///
/// Materials: *ELASTIC with the material's own constants, isotropic or as engineering constants turned by an
/// *ORIENTATION a fibre direction. Where the scene's dimension frees stresses (plane stress, 1D) the reduced
/// stiffness instead, as TYPE=ANISO. With strain = "finite" the step is NLGEOM, and laws are CalculiX's own
/// neo-Hookean and Mooney-Rivlin ones: their energy of volume is k/2 (J - 1)^2, so that answers agree where
/// matter keeps its volume; pressures follow their faces. Loads: the forces on nodes that they are worth to
/// linear elements (see nodal_forces), so gravity asks for no density. Units: SI. Numbers take 19 characters
/// at most: ccx cuts fields after 20.
/// @pre why_no_deck() is empty
std::string calculix_deck(const Scene& scene);

/// Why a deck cannot say what a scene asks; empty if it can.
std::string why_no_deck(const Scene& scene);

/// Displacements from what ccx prints for *NODE PRINT (a .dat file).
/// @throws std::runtime_error if it does not hold a displacement for every node of the body
Displacement read_calculix_displacement(const Scene& scene, std::istream& printed);

/// True if there is a `ccx` to run.
bool has_calculix();

/// Writes the deck into a temporary folder, runs `ccx` there and reads what it prints.
/// @return method `calculix`; status refused where there is no ccx, failed with its message where it says
///         *ERROR (it may end with 0 all the same) or leaves no displacements; interrupted, with nothing
///         moved, where control asked to stop and it was ended. `seconds.solve` is the whole process; `bytes`
///         are not known
Answer solve_by_calculix(const Scene& scene, const Control& control = {});

} // namespace maille::studies
