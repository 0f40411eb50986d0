#pragma once
/// The drawn parts of a body and of a world's objects.

#include "drawing.hpp"
#include "export/world/world_files.hpp"

#include <vtkDataSet.h>

#include <vector>

namespace maille::studies {

/// Viridis (S. van der Walt, N. Smith, 2015; public domain): even steps look even, also in grey and to the
/// colour-blind. @param end  of the scale, from 0
vtkSmartPointer<vtkColorTransferFunction> viridis(double end);

vtkSmartPointer<vtkPolyData> surface_of(vtkDataSet& body);
/// Colours a surface by its values.
void colour_by(vtkActor& actor, vtkColorTransferFunction& colours);

inline constexpr Vec3 grey_at_rest{0.88, 0.89, 0.91};

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
Props body_actors(const Scene& scene, const Displacement& displacement, const Displacement& shown,
                  const BodyStyle& style, const View& view);

/// Colour of an object, red green blue from 0 to 1: grey for fixed ones.
Vec3 object_colour(const WorldScene& world, std::size_t object);

/// What is drawn of one object at one moment.
/// @param pixels_per_metre decides whether cells can be told apart
Props object_actors(const WorldScene& world, std::size_t object, const std::vector<Vec3>& positions,
                    const View& view, double pixels_per_metre);

} // namespace maille::studies
