#include "maille/base/csv.hpp"

#include <algorithm>
#include <cstdlib>

namespace maille {

namespace {

/// True if a spreadsheet would read a cell as a formula, ignoring apostrophes. A signed number is no formula.
bool is_formula(const std::string& text) {
  const std::string bare = text.substr(std::min(text.find_first_not_of('\''), text.size()));
  char* end = nullptr;
  std::strtod(bare.c_str(), &end);
  return bare.find_first_of("=@+-\t\r") == 0 && bare != "-" && (bare[0] != '-' || *end != '\0');
}

} // namespace

std::string csv_text(const std::string& text) {
  const std::string guarded = (is_formula(text) ? "'" : "") + text;
  if (guarded.find_first_of(",\"\n\r") == std::string::npos)
    return guarded;
  std::string quoted = "\"";
  for (const char c : guarded)
    quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
  return quoted + "\"";
}

std::string without_guard(std::string cell) {
  return cell.starts_with('\'') && is_formula(cell) ? cell.substr(1) : cell;
}

CsvRecords::CsvRecords(std::string_view text, CsvComments comments) : text_(text), comments_(comments) {
  constexpr std::string_view byte_order_mark = "\xEF\xBB\xBF";
  if (text_.starts_with(byte_order_mark))
    text_.remove_prefix(byte_order_mark.size());
}

bool CsvRecords::begins_comment() const {
  return comments_ == CsvComments::anywhere || (comments_ == CsvComments::lines && cells_.size() == 1 &&
                                                cells_.front().find_first_not_of(" \t") == std::string::npos);
}

/// Processes a character outside quotes.
void CsvRecords::take(char c) {
  if (c == '"')
    is_open_ = true;
  else if (c == ',')
    cells_.emplace_back();
  else if (c == '#' && begins_comment())
    at_ = std::min(text_.find('\n', at_), text_.size()) - 1;
  else if (c != '\r')
    cells_.back() += c;
}

bool CsvRecords::next() {
  if (at_ >= text_.size())
    return false;
  cells_.assign(1, {});
  line_ = next_line_;
  is_open_ = false;
  for (bool has_ended = false; at_ < text_.size() && !has_ended; ++at_) {
    const char c = text_[at_];
    next_line_ += c == '\n';
    if (!is_open_ && c == '\n')
      has_ended = true;
    else if (!is_open_)
      take(c);
    else if (c != '"')
      cells_.back() += c;
    else if (at_ + 1 < text_.size() && text_[at_ + 1] == '"')
      cells_.back() += text_[++at_];
    else
      is_open_ = false;
  }
  return true;
}

} // namespace maille
