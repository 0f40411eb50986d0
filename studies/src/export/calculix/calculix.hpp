#pragma once
/// Scenes as input of CalculiX (Dhondt and Wittig, ccx 2.20), an independent finite-element program.

#include "maille/scene/answer.hpp"

#include <istream>
#include <string>

namespace maille::studies {

/// Input deck for one linear static step, equivalent to fem_q1 element by element.
///
/// Every cell is a C3D8 brick, which ccx 2.20 integrates at 2 x 2 x 2 points like fem_q1, so answers differ
/// only by the seven printed digits of ccx. In 2D and 1D there is one layer of bricks, 1 m thick; its sides
/// are tied together and stay in the plane or on the line. Nodes are numbered as in body_nodes(), followed by
/// the copies of a layer.
///
/// Materials: *ELASTIC with the material's constants: isotropic, or engineering constants with one
/// *ORIENTATION per fibre direction. If the scene's dimension frees stresses (plane stress, 1D), the reduced
/// stiffness as TYPE=ANISO. With strain = "finite" the step is NLGEOM, and laws are CalculiX's neo-Hookean
/// and Mooney-Rivlin ones: their volumetric energy is k/2 (J - 1)^2, so answers agree if the volume hardly
/// changes; pressures follow their faces. Loads: the equivalent nodal forces of linear elements (see
/// nodal_forces), so gravity requires no density. Units: SI. Numbers take 19 characters at most, because ccx
/// cuts fields after 20.
/// @pre why_no_deck() is empty
std::string calculix_deck(const Scene& scene);

/// Reason that a deck cannot represent the scene; empty if it can.
std::string why_no_deck(const Scene& scene);

/// Reads displacements from the output of ccx for *NODE PRINT (a .dat file).
/// @throws std::runtime_error if it does not hold a displacement for every node of the body
Displacement read_calculix_displacement(const Scene& scene, std::istream& printed);

/// True if `ccx` is installed.
bool has_calculix();

/// Writes the deck to a temporary folder, runs `ccx` there and reads its output.
/// @return method `calculix`; status refused without ccx; failed, with the message of ccx, if it prints
///         *ERROR (its exit code may be 0 even then) or no displacements; interrupted, with zero
///         displacements, if a stop request ended it. `seconds.solve` is the time of the whole process;
///         `bytes` is unknown
Answer solve_by_calculix(const Scene& scene, const Control& control = {});

} // namespace maille::studies
