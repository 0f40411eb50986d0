#include "maille/scene/csv.hpp"

#include <gtest/gtest.h>

namespace maille {
namespace {

using Cells = std::vector<std::string>;

std::vector<Cells> records_of(std::string_view text, CsvComments comments = CsvComments::none) {
  std::vector<Cells> records;
  for (CsvRecords reader(text, comments); reader.next();)
    records.push_back(reader.cells());
  return records;
}

// RFC 4180, section 2: rules 1, 2, 5, 6 and 7.
TEST(CsvRecordsContract, CellsBetweenQuotesHoldCommasQuotesAndEndsOfLines) {
  EXPECT_EQ(records_of("a,b\r\n\"c, d\",\"say \"\"e\"\"\"\n\"f\r\ng\",\n"),
            (std::vector<Cells>{{"a", "b"}, {"c, d", "say \"e\""}, {"f\r\ng", ""}}));
  EXPECT_EQ(records_of("a\n\nb"), (std::vector<Cells>{{"a"}, {""}, {"b"}}))
      << "the last line may lack its end";
  EXPECT_TRUE(records_of("").empty());
  EXPECT_EQ(records_of("\xEF\xBB\xBF"
                       "a,b\n"),
            (std::vector<Cells>{{"a", "b"}}));
}

TEST(CsvRecordsContract, ARecordHasTheLineInWhichItBegins) {
  CsvRecords records("a\n\"b\n\n\"\nc");
  std::vector<int> lines;
  while (records.next())
    lines.push_back(records.line());
  EXPECT_EQ(lines, (std::vector<int>{1, 2, 5}));
}

TEST(CsvRecordsContract, WhatIsTornIsKnown) {
  CsvRecords whole("a\n"), torn("a\nb"), open("a,\"b\n");
  ASSERT_TRUE(whole.next() && torn.next() && torn.next() && open.next());
  EXPECT_TRUE(whole.has_line_end());
  EXPECT_FALSE(torn.has_line_end());
  EXPECT_FALSE(torn.is_open());
  EXPECT_FALSE(open.has_line_end());
  EXPECT_TRUE(open.is_open());
}

TEST(CsvRecordsContract, CommentsAreLeftOutWhereTheFormHasThem) {
  const std::string_view text = "# 5\" long\n  #\na # b,\"#c\"\n";
  EXPECT_EQ(records_of(text, CsvComments::lines), (std::vector<Cells>{{""}, {"  "}, {"a # b", "#c"}}));
  EXPECT_EQ(records_of(text, CsvComments::anywhere), (std::vector<Cells>{{""}, {"  "}, {"a "}}));
  EXPECT_EQ(records_of("# a,b\n").front(), (Cells{"# a", "b"}));
}

} // namespace
} // namespace maille
