#pragma once
/// Files with one mistake, and the one fault that must come of it.

#include "maille/materials/fault.hpp"

#include "support/texts.hpp"

#include <gtest/gtest.h>

#include <ostream>
#include <string>
#include <string_view>
#include <vector>

namespace maille::test {

/// One thing changed in a good file.
struct Mistake {
  const char* name;
  const char* from;
  const char* to;
  int line;
  const char* key;
  const char* text; ///< somewhere in the message
};

inline void PrintTo(const Mistake& mistake, std::ostream* out) {
  *out << mistake.name;
}

/// The good text with the mistake in it, at the first place.
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

/// What reading finds wrong; nothing where it is good.
template<class Read>
std::vector<Fault> faults_found_by(Read&& read) {
  try {
    read();
  } catch (const InputError& error) {
    return error.faults();
  }
  return {};
}

/// The one fault that reading finds; another number of them fails the test.
template<class Read>
Fault only_fault_of(Read&& read) {
  const std::vector<Fault> faults = faults_found_by(read);
  EXPECT_EQ(faults.size(), 1u) << (faults.empty() ? "no fault" : InputError(faults).what());
  return faults.empty() ? Fault{} : faults.front();
}

} // namespace maille::test
