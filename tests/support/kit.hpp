#pragma once
/// Common tools of tests: GoogleTest, parts of the standard library, folders, text of scene files in pieces
/// (boxes of 1 mm cells, their conditions, worlds of boxes), checks of messages, and files with one mistake.

#include "maille/materials/fault.hpp"
#include "support/sanitized.hpp"
#include "support/temporary_folder.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fmt/format.h>
#include <fstream>
#include <functional>
#include <gtest/gtest.h>
#include <iostream>
#include <iterator>
#include <limits>
#include <map>
#include <numbers>
#include <numeric>
#include <optional>
#include <ostream>
#include <random>
#include <set>
#include <span>
#include <sstream>
#include <stdexcept>
#include <string>
#include <string_view>
#include <tuple>
#include <utility>
#include <vector>

namespace maille::test {

inline const std::string soft = R"({ youngs_modulus = "10 kPa", poisson_ratio = 0.3 })";

/// @param cells, material  in the syntax of a scene
inline std::string box_text(const std::string& cells, const std::string& material = soft) {
  return "[specimen]\nshape = \"box\"\ncells = " + cells + "\nspacing = \"1 mm\"\nmaterial = " + material +
         "\n";
}
inline std::string hold_text(const std::string& face = "x-") {
  return "[[hold]]\nwhere = \"" + face + "\"\n";
}
inline std::string move_text(const std::string& by, const std::string& face = "x+") {
  return "[[move]]\nwhere = \"" + face + "\"\nby = " + by + "\n";
}
/// Held at x-, moved at x+.
inline std::string pulled_box_text(const std::string& cells, const std::string& by) {
  return box_text(cells) + hold_text() + move_text(by);
}

inline std::string world_text(const std::string& cells) {
  return "[world]\ncells = " + cells + "\nspacing = \"1 mm\"\n";
}
/// @param more  further lines
inline std::string object_text(const std::string& name, const std::string& kind, const std::string& cells,
                               const std::string& more = "", const std::string& shape = "box") {
  return "[[object]]\nname = \"" + name + "\"\nkind = \"" + kind + "\"\nshape = \"" + shape +
         "\"\ncells = " + cells + "\n" + more;
}

/// @param keys  lines of the measure's table
inline std::string measure_text(const std::string& name, const std::string& keys) {
  return "[[measure]]\nname = \"" + name + "\"\n" + keys + "\n";
}

/// Bytes of a number in the byte order of this machine.
template<class Number>
std::string raw_bytes(Number number) {
  std::string bytes(sizeof number, '\0');
  std::memcpy(bytes.data(), &number, sizeof number);
  return bytes;
}

/// A MetaImage. @param values  raw bytes  @param more  lines of the header
inline std::string meta_image(const std::array<int, 3>& size, const std::string& values,
                              const std::string& more = "ElementSpacing = 1 1 1\n",
                              const std::string& type = "MET_UCHAR") {
  return fmt::format("ObjectType = Image\nNDims = 3\nBinaryData = True\nBinaryDataByteOrderMSB = False\n"
                     "{}DimSize = {} {} {}\nElementType = {}\nElementDataFile = LOCAL\n{}",
                     more, size[0], size[1], size[2], type, values);
}

/// All index triples of a grid of n[0] x n[1] x n[2], the first index fastest.
inline std::vector<std::array<int, 3>> all_below(const std::array<int, 3>& n) {
  std::vector<std::array<int, 3>> places;
  for (int k = 0; k < n[2]; ++k)
    for (int j = 0; j < n[1]; ++j)
      for (int i = 0; i < n[0]; ++i)
        places.push_back({i, j, k});
  return places;
}

/// A MetaImage of float32, n x n x n voxels of 1 mm from `corner` [mm] on.
inline std::string
float_image(int n, double corner, int components,
            const std::function<float(const std::array<int, 3>& at, int component)>& value) {
  std::string values;
  for (const std::array<int, 3>& at : all_below({n, n, n}))
    for (int c = 0; c < components; ++c)
      values += raw_bytes(value(at, c));
  return meta_image(
      {n, n, n}, values,
      fmt::format("Offset = {0} {0} {0}\nElementSpacing = 1 1 1\nElementNumberOfChannels = {1}\n",
                  corner + 0.5, components),
      "MET_FLOAT");
}

/// True if a text contains a part; a failure shows the whole text.
inline testing::AssertionResult has(std::string_view text, std::string_view part) {
  const bool is_there = text.find(part) != std::string_view::npos;
  return (is_there ? testing::AssertionSuccess() : testing::AssertionFailure())
         << '"' << part << "\" in: " << text;
}

/// One change in a valid file.
struct Mistake {
  const char* name;
  const char* from;
  const char* to;
  int line;
  const char* key;
  const char* text; ///< expected part of the message
};

inline void PrintTo(const Mistake& mistake, std::ostream* out) {
  *out << mistake.name;
}

/// The valid text with the mistake, at the first match.
inline std::string with_mistake(std::string good, const Mistake& mistake) {
  const auto place = good.find(mistake.from);
  EXPECT_NE(place, std::string::npos) << mistake.from;
  return place == std::string::npos ? good
                                    : good.replace(place, std::string_view(mistake.from).size(), mistake.to);
}

inline void expect_only(const Mistake& mistake, const std::vector<Fault>& faults) {
  ASSERT_EQ(faults.size(), 1u) << (faults.empty() ? "" : InputError(faults).what());
  EXPECT_EQ(faults[0].line, mistake.line) << to_string(faults[0]);
  EXPECT_EQ(faults[0].key, mistake.key) << to_string(faults[0]);
  EXPECT_NE(to_string(faults[0]).find(mistake.text), std::string::npos) << to_string(faults[0]);
}

/// Expected contents of an error: its line and key, and parts of the expected and found texts, if given.
struct Facts {
  int line = -1;
  std::string_view key = {}, expected = {}, found = {};
};

/// True if an error has these contents; a failure shows the error.
inline testing::AssertionResult says(const Fault& fault, const Facts& facts) {
  const bool it_does = (facts.line < 0 || fault.line == facts.line) &&
                       (facts.key.empty() || fault.key == facts.key) &&
                       fault.expected.find(facts.expected) != std::string::npos &&
                       fault.found.find(facts.found) != std::string::npos;
  return (it_does ? testing::AssertionSuccess() : testing::AssertionFailure()) << to_string(fault);
}

/// True if this is the only error.
inline testing::AssertionResult says_only(const std::vector<Fault>& faults, const Facts& facts) {
  if (faults.size() == 1)
    return says(faults[0], facts);
  return testing::AssertionFailure() << faults.size()
                                     << " faults: " << (faults.empty() ? "" : InputError(faults).what());
}

/// The keys of faults, in their order.
inline std::vector<std::string> keys_of(const std::vector<Fault>& faults) {
  std::vector<std::string> keys;
  for (const Fault& fault : faults)
    keys.push_back(fault.key);
  return keys;
}

/// Errors found by reading; empty for valid input.
template<class Read>
std::vector<Fault> faults_found_by(Read&& read) {
  try {
    read();
  } catch (const InputError& error) {
    return error.faults();
  }
  return {};
}

/// The only error found by reading; another number of errors fails the test.
template<class Read>
Fault only_fault_of(Read&& read) {
  const std::vector<Fault> faults = faults_found_by(read);
  EXPECT_EQ(faults.size(), 1u) << (faults.empty() ? "no fault" : InputError(faults).what());
  return faults.empty() ? Fault{} : faults.front();
}

} // namespace maille::test
