#include "maille/materials/fault.hpp"

#include <fmt/format.h>

#include <utility>

namespace maille {
namespace {

std::string place(const Fault& fault) {
  if (fault.file.empty()) {
    return fault.line > 0 ? fmt::format("line {}: ", fault.line) : std::string();
  }
  return fault.line > 0 ? fmt::format("{}:{}: ", fault.file, fault.line) : fmt::format("{}: ", fault.file);
}

} // namespace

std::string to_string(const Fault& fault) {
  std::string text = place(fault);
  if (!fault.key.empty()) {
    text += fault.key + ": ";
  }
  if (!fault.expected.empty()) {
    text += "expected " + fault.expected;
  }
  if (!fault.found.empty()) {
    text += fault.expected.empty() ? "found " : ", found ";
    text += fault.found;
  }
  return text;
}

InputError::InputError(std::vector<Fault> faults) : faults_(std::move(faults)) {
  for (const Fault& fault : faults_) {
    if (!text_.empty()) {
      text_ += '\n';
    }
    text_ += to_string(fault);
  }
}

} // namespace maille
