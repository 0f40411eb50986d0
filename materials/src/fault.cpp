#include "maille/materials/fault.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <utility>

namespace maille {

namespace {

std::string place(const Fault& fault) {
  if (fault.file.empty())
    return fault.line > 0 ? fmt::format("line {}: ", fault.line) : std::string();
  return fault.line > 0 ? fmt::format("{}:{}: ", fault.file, fault.line) : fmt::format("{}: ", fault.file);
}

bool same_letter(char a, char b) {
  return std::tolower(static_cast<unsigned char>(a)) == std::tolower(static_cast<unsigned char>(b));
}

} // namespace

std::string to_string(const Fault& fault) {
  std::string text = place(fault);
  if (!fault.key.empty())
    text += fault.key + ": ";
  if (!fault.expected.empty())
    text += "expected " + fault.expected;
  if (!fault.found.empty()) {
    text += fault.expected.empty() ? "found " : ", found ";
    text += fault.found;
  }
  return text;
}

InputError::InputError(std::vector<Fault> faults) : faults_(std::move(faults)) {
  for (const Fault& fault : faults_) {
    if (!text_.empty())
      text_ += '\n';
    text_ += to_string(fault);
  }
}

std::size_t spelling_distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> before_last(b.size() + 1), last(b.size() + 1), row(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j)
    last[j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t change = last[j - 1] + (same_letter(a[i - 1], b[j - 1]) ? 0 : 1);
      row[j] = std::min({change, last[j] + 1, row[j - 1] + 1});
      if (i > 1 && j > 1 && same_letter(a[i - 1], b[j - 2]) && same_letter(a[i - 2], b[j - 1]))
        row[j] = std::min(row[j], before_last[j - 2] + 1);
    }
    std::swap(before_last, last);
    std::swap(last, row);
  }
  return last[b.size()];
}

bool is_slip(std::size_t distance, std::size_t length) {
  return distance <= std::max<std::size_t>(1, length / 3);
}

std::string_view nearest_spelling(std::string_view word, const std::vector<std::string_view>& candidates) {
  std::string_view nearest;
  std::size_t least = word.size() + 1;
  for (const std::string_view candidate : candidates) {
    const std::size_t distance = spelling_distance(word, candidate);
    if (distance < least && is_slip(distance, std::max(word.size(), candidate.size()))) {
      least = distance;
      nearest = candidate;
    }
  }
  return nearest;
}

} // namespace maille
