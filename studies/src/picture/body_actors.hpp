#pragma once
/// The drawn parts of a body.

#include "layout.hpp"

#include <vtkColorTransferFunction.h>
#include <vtkProp.h>
#include <vtkSmartPointer.h>

#include <vector>

namespace maille::studies {

/// Viridis (S. van der Walt, N. Smith, 2015; public domain): even steps look even, also in grey and to the
/// colour-blind. @param end  of the scale, from 0
vtkSmartPointer<vtkColorTransferFunction> viridis(double end);

/// How bodies are drawn.
struct BodyStyle {
  double warp = 1;
  double colour_unit = 1; ///< the colours' numbers are lengths of displacements over this [m]
  vtkColorTransferFunction* colours = nullptr;
  double pixels_per_metre = 1;
  double line_width = 1; ///< [pixels] of the thinnest lines
};

/// The deformed body in the colours of the length of `shown`, its cell edges where they can be told apart,
/// and its outline at rest.
std::vector<vtkSmartPointer<vtkProp>> body_actors(const Scene& scene, const Displacement& displacement,
                                                  const Displacement& shown, const BodyStyle& style,
                                                  const View& view);

} // namespace maille::studies
