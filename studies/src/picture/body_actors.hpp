#pragma once
/// The drawn parts of a body and of a world's objects.

#include "drawing.hpp"
#include "export/world/world_files.hpp"

#include <vtkDataSet.h>

#include <vector>

namespace maille::studies {

/// Viridis (S. van der Walt, N. Smith, 2015; public domain): perceptually uniform, also in grey and for
/// colour-blind readers. @param end  of the scale, which starts at 0
vtkSmartPointer<vtkColorTransferFunction> viridis(double end);

vtkSmartPointer<vtkPolyData> surface_of(vtkDataSet& body);
/// Colours a surface by its values.
void colour_by(vtkActor& actor, vtkColorTransferFunction& colours);

inline constexpr Vec3 grey_at_rest{0.88, 0.89, 0.91};

/// How bodies are drawn.
struct BodyStyle {
  double warp = 1;
  double colour_unit = 1; ///< colour values are displacement lengths divided by this [m]
  vtkColorTransferFunction* colours = nullptr;
  double pixels_per_metre = 1;
  double line_width = 1; ///< width of the thinnest lines [pixels]
};

/// The deformed body coloured by the length of `shown`, with cell edges if they are wide enough apart, and
/// its outline at rest.
Props body_actors(const Scene& scene, const Displacement& displacement, const Displacement& shown,
                  const BodyStyle& style, const View& view);

/// Colour of an object, red green blue from 0 to 1: grey for fixed ones.
Vec3 object_colour(const WorldScene& world, std::size_t object);

/// Actors of one object at one moment.
/// @param pixels_per_metre determines whether cell edges are drawn
Props object_actors(const WorldScene& world, std::size_t object, const std::vector<Vec3>& positions,
                    const View& view, double pixels_per_metre);

} // namespace maille::studies
