#pragma once
/// Guessing what was meant by a word that nobody knows.

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace maille {

/// Letters to insert, drop, change or swap with their neighbour to turn `a` into `b`, case aside: the
/// "optimal string alignment" distance. Cost: O(a.size() b.size()).
std::size_t spelling_distance(std::string_view a, std::string_view b);

/// True if `distance` edits to a word of `length` letters look like a slip and not like another word.
bool is_slip(std::size_t distance, std::size_t length);

/// The candidate nearest to `word`, or nothing where none is near enough to be a slip.
std::string_view nearest_spelling(std::string_view word, const std::vector<std::string_view>& candidates);

} // namespace maille
