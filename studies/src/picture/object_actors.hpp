#pragma once
/// The drawn parts of a world's objects.

#include "layout.hpp"
#include "maille/studies/export/world_files.hpp"

#include <vtkProp.h>
#include <vtkSmartPointer.h>

#include <vector>

namespace maille::studies {

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
