#pragma once
/// The drawn parts of a body and of a world's objects.

#include "export/world/world_files.hpp"
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

/// Colour of an object, red green blue from 0 to 1: grey for fixed ones.
Vec3 object_colour(const WorldScene& world, std::size_t object);

/// What is drawn of one object at one moment.
/// @param pixels_per_metre decides whether cells can be told apart
std::vector<vtkSmartPointer<vtkProp>> object_actors(const WorldScene& world, std::size_t object,
                                                    const std::vector<Vec3>& positions, const View& view,
                                                    double pixels_per_metre);

/// Dots at points. @param radius [m]
vtkSmartPointer<vtkProp> dots(const std::vector<Vec3>& points, double radius, const View& view);

} // namespace maille::studies
