/// Tables of results: what is written reads back, and what cannot be read is a fault with its place.

#include "results/result_table.hpp"
#include "support/kit.hpp"

namespace maille::studies {
namespace {

struct Cost {
  double seconds = 0;
  std::int64_t bytes = 0;
};

struct Row {
  std::string name;
  Status status = Status::done;
  int steps = 0;
  std::optional<Cost> cost{};
  std::optional<double> error{};
  std::vector<std::pair<std::string, double>> settings{};
  bool is_old = false;
};

std::string in_milliseconds(double seconds) {
  return std::to_string(std::lround(1e3 * seconds)) + " ms";
}

Value settings_of(const Row& row) {
  Value settings = Value::object();
  for (const auto& [name, value] : row.settings)
    settings[name] = value;
  return settings;
}

bool read_settings(Row& row, const Value& settings) {
  for (const auto& [name, value] : settings.items())
    row.settings.emplace_back(name, value.get<double>());
  return true;
}

const ResultTable<Row>& table() {
  static const ResultTable<Row> all = [] {
    ResultTable<Row> columns;
    columns.add({"name", "name", "", ""}, {"name", -6}, &Row::name);
    columns.add({"", "settings", "", ""}, settings_of).open().read_by("numbers", read_settings);
    columns.add({"status", "status", "", ""}, {"status", -7}, &Row::status);
    columns.add({"time_s", "cost.time", "s", "of all"}, {"time", 7, in_milliseconds}, &Row::cost,
                &Cost::seconds);
    columns.add({"bytes", "cost.bytes", "B", "at the peak"}, &Row::cost, &Cost::bytes);
    columns.add({"steps", "steps", "", ""}, {"steps", 5}, &Row::steps)
        .json_behind("name")
        .text_behind("name");
    columns.add({"error", "error", "", ""}, {"error", 6, nullptr, true}, &Row::error);
    columns.add({"", "old", "", ""}, &Row::is_old).json_where([](const Row& row) { return row.is_old; });
    return columns;
  }();
  return all;
}

const std::vector<Row> rows{
    {"=1+1", Status::clamped, 3, Cost{1.0 / 3, 9'007'199'254'740'991}, 0.25, {{"@E, far", 0.1}}, true},
    {"two\nlines, \"quoted\"", Status::done, -2, {}, {}, {{"@E, far", 1e-300}}, false},
};

// Truth: golden; RFC 4180, 17 digits, and an apostrophe before cells like formulas of spreadsheets.
TEST(ResultTableContract, CsvHasEveryDigit) {
  EXPECT_EQ(table().csv(rows), "name,\"'@E, far\",status,time_s,bytes,steps,error\n"
                               "'=1+1,0.1,clamped,0.3333333333333333,9007199254740991,3,0.25\n"
                               "\"two\nlines, \"\"quoted\"\"\",1e-300,done,,,-2,\n");
}

TEST(ResultTableContract, JsonHasGroupsItsOwnOrderAndNothingOfAnEmptyGroup) {
  EXPECT_EQ(table().json_rows(rows).dump(),
            "[{\"name\":\"=1+1\",\"steps\":3,\"settings\":{\"@E, far\":0.1},\"status\":\"clamped\","
            "\"cost\":{\"time\":0.3333333333333333,\"bytes\":9007199254740991},\"error\":0.25,\"old\":true},"
            "{\"name\":\"two\\nlines, \\\"quoted\\\"\",\"steps\":-2,\"settings\":{\"@E, far\":1e-300},"
            "\"status\":\"done\",\"error\":null}]");
  std::vector<Fault> faults;
  Value json = table().json(rows[0]);
  EXPECT_EQ(table().json(table().read_json(json, "t.jsonl", 1, faults)), json);
  EXPECT_TRUE(faults.empty());
}

TEST(ResultTableContract, TheTableForPeopleAlignsRoundsAndLeavesOutWhatNoRowHas) {
  EXPECT_EQ(table().text(std::vector{rows[0]}), "name   steps status     time  error\n"
                                                "=1+1       3 clamped  333 ms   0.25\n");
  EXPECT_EQ(table().text(std::vector{Row{.name = "a"}}), "name   steps status     time\n"
                                                         "a          0 done          -\n");
}

TEST(ResultTableContract, NumbersThatAreNotFiniteAreNullInJsonAndWordsInCsv) {
  Row infinite{.name = "a", .cost = Cost{std::numeric_limits<double>::infinity(), 1}};
  Value json = table().json(infinite);
  EXPECT_EQ(json["cost"].dump(), "{\"time\":null,\"bytes\":1}");
  std::vector<Fault> faults;
  EXPECT_TRUE(std::isinf(table().read_json(json, "", 1, faults).cost->seconds));
  EXPECT_EQ(table().csv_line(infinite), "a,done,inf,1,0,\n");
  ResultTable<Row> finite({.digits = 3, .digits_of_seconds = 2, .are_only_finite = true});
  finite.add({"time_s", "", "s", ""}, &Row::cost, &Cost::seconds).add({"error", "", "", ""}, &Row::error);
  EXPECT_EQ(finite.csv_line(infinite), ",\n");
  EXPECT_EQ(finite.csv_line(rows[0]), "0.33,0.25\n");
}

TEST(ResultTableContract, WhatJsonLacksOrHasOtherwiseIsAFaultUnderItsKey) {
  std::vector<Fault> faults;
  const Value json = Value::parse(R"({"name": 1, "settings": {}, "status": "done", "cost": {"bytes": "1"}})");
  table().read_json(json, "t.jsonl", 4, faults);
  std::string found;
  for (const Fault& fault : faults)
    found += std::to_string(fault.line) + " " + fault.key + " " + fault.found + "; ";
  EXPECT_EQ(found, "4 name 1; 4 cost.bytes \"1\"; 4 steps nothing; 4 old nothing; ");
  faults.clear();
  table().read_json(Value::parse("[]"), "t.jsonl", 5, faults);
  ASSERT_EQ(faults.size(), 1u);
  EXPECT_EQ(faults[0].expected, "an object of JSON");
}

struct Family {
  std::string name;
  std::optional<Cost> cost{};
  std::vector<Row> rows{};
};

const ResultTable<Family>& families() {
  static const ResultTable<Cost> costs([](ResultTable<Cost>& columns) {
    columns.add({"", "seconds", "s", ""}, &Cost::seconds).add({"", "bytes", "B", ""}, &Cost::bytes);
  });
  static const ResultTable<Family> all([](ResultTable<Family>& columns) {
    columns.add({"", "name", "", ""}, {"name"}, &Family::name);
    columns.add({"", "of.the.cost.bytes", "B", ""}, {"bytes"}, &Family::cost, &Cost::bytes).omitted(false);
    columns.add_row({"", "cost", "", ""}, costs, &Family::cost);
    columns.add_rows({"", "rows", "", ""}, table(), &Family::rows);
    columns.add({}, {"rows"}, [](const Family& of) { return std::to_string(of.rows.size()); });
  });
  return all;
}

TEST(ResultTableContract, AFigureMayBeARowOrRowsOfAnotherTable) {
  EXPECT_EQ(families().json({"a"}).dump(),
            "{\"name\":\"a\",\"of\":{\"the\":{\"cost\":{\"bytes\":null}}},\"cost\":null,\"rows\":[]}");
  const Value json = families().json({"b", Cost{0.5, 7}, rows});
  EXPECT_EQ(json["of"]["the"]["cost"]["bytes"], 7);
  EXPECT_EQ(json["cost"].dump(), "{\"seconds\":0.5,\"bytes\":7}");
  EXPECT_EQ(json["rows"], table().json_rows(rows));
  const auto& list = families().list();
  EXPECT_EQ(list[3].within, &table());
  EXPECT_TRUE(list[3].is_list && !list[2].is_list);
}

TEST(ResultTableContract, ColumnsWithoutAWidthAreAsWideAsTheirWidestCell) {
  EXPECT_EQ(families().text(std::vector<Family>{{"a", Cost{0, 123456}, {}}, {"a long one", {}, rows}}),
            "name        bytes rows\n"
            "a          123456 0\n"
            "a long one      - 2\n");
}

} // namespace
} // namespace maille::studies
