#include "results/figures.hpp"
#include "trade/measure.hpp"

#include <cmath>

namespace maille::studies {

namespace {

using Table = ResultTable<TradeRecord>;

constexpr auto row = &TradeRecord::row;

bool is_measured(const TradeRecord& record) {
  return record.row.repetitions > 0;
}

bool has_lattice(const TradeRecord& record) {
  return record.row.nodes > 0;
}

const Seconds* seconds_of(const TradeRecord& record) {
  return is_measured(record) ? &record.row.seconds : nullptr;
}

/// One number per dimension of the scene.
template<class List>
Value along_axes(const TradeRecord& record, const List& list) {
  return std::vector(list.begin(), list.begin() + record.dimension);
}

void add_way(Table& columns) {
  columns.add({"scene", "", "", "its name"}, &TradeRecord::scene);
  add_method(columns, row, &TradeRow::way, &Way::method);
  columns.add({"halvings", "", "", "of the scene's spacing"}, row, &TradeRow::way, &Way::halvings);
  columns.add({"", "spacing_factor", "", "of the lattice over the scene's"}, row, &TradeRow::way,
              [](const Way& way) { return std::exp2(-way.halvings); });
  columns.add({"nodes", "", "", "of matter"}, row, &TradeRow::nodes);
  columns.add({"tolerance", "tolerance", "", "of methods that have one"}, row, &TradeRow::way,
              &Way::tolerance);
  add_status(columns, row, &TradeRow::status);
}

void add_lattice(Table& columns) {
  columns
      .add({"", "cells", "", "along every axis"},
           [](const TradeRecord& of) { return along_axes(of, of.row.cells); })
      .json_where(has_lattice);
  columns
      .add({"", "spacing", "m", "along every axis"},
           [](const TradeRecord& of) { return along_axes(of, of.row.spacing); })
      .json_where(has_lattice);
  columns.add({"", "nodes", "", "of matter"}, row, &TradeRow::nodes).json_where(has_lattice);
  columns.add({"", "algorithm", "", "that the method took"}, row, &TradeRow::algorithm)
      .json_where(is_measured);
}

void add_cost(Table& columns) {
  add_seconds(columns, seconds_of);
  add_total(columns, seconds_of, &Seconds::total);
  columns
      .add({"wall_s", "wall_seconds", "s", "total_s by the clock"},
           [](const TradeRecord& of) {
             return is_measured(of) ? std::optional(of.row.wall_seconds) : std::nullopt;
           })
      .omitted();
  columns
      .add({"repetitions", "repetitions", "", "that seconds are the medians of"}, row, &TradeRow::repetitions)
      .json_where(is_measured);
  add_bytes(columns, row, &TradeRow::bytes).json_where(is_measured);
  add_iterations(columns, row, &TradeRow::iterations).json_where(is_measured);
}

void add_prediction(Table& columns) {
  const auto is_whole = [](const TradeRecord& of) {
    return of.row.predicted.error && of.row.predicted.seconds;
  };
  constexpr auto predicted = &TradeRow::predicted;
  columns
      .add({"predicted_error", "predicted.error", "", "by probes alone"}, row, predicted,
           &RawPrediction::error)
      .json_where(is_whole);
  columns
      .add({"predicted_s", "predicted.seconds", "s", "by probes alone"}, row, predicted,
           &RawPrediction::seconds)
      .json_where(is_whole)
      .digits(6);
}

void add_measures(Table& columns) {
  columns
      .add({"", "measures", "", "of [[measure]]: name, unit, value, vector or line"}, row,
           &TradeRow::measures, measures_json)
      .json_where([](const TradeRecord& of) { return !of.row.measures.empty(); });
  columns.add({"", "error.measures", "", "of each measure"}, row, &TradeRow::measures, measure_errors_json);
  columns
      .add({"", "", "", "NAME of each measure, of vectors NAME_x, _y, _z; NAME_error"}, row,
           &TradeRow::measures, [](const std::vector<MeasureRow>& rows) { return measure_cells(rows, true); })
      .open();
}

/// Adds empty columns for the fronts, which python/maille/_trade.py fills later.
void add_front(Table& columns) {
  const auto none = [](const TradeRecord&) { return false; };
  columns.add({"front", "", "", "nothing is nearer and quicker (t), nearer and smaller (m)"},
              [](const TradeRecord&) { return ""; });
  columns.add({"", "on_front.time", "", "nothing is nearer and quicker"}, none);
  columns.add({"", "on_front.memory", "", "nothing is nearer and smaller"}, none);
  columns.add({"reference", "", "", "that errors are measured against"}, &TradeRecord::reference);
  columns.add({"reference_l2", "", "", "the reference's own error"}, &TradeRecord::reference_l2).digits(3);
}

/// Lattice of the finer probe, where a prediction exists.
Value probe_halvings_of(const TradeRow& of) {
  return of.predicted.error ? Value(of.predicted.probe_halvings) : Value();
}

} // namespace

const Table& columns_of_trade() {
  static const Table table = [] {
    Table columns({.digits = 6, .digits_of_seconds = 4, .are_only_finite = true});
    add_way(columns);
    add_lattice(columns);
    add_cost(columns);
    add_norms(columns, "", "error", row, &TradeRow::error);
    add_measures(columns);
    add_prediction(columns);
    add_front(columns);
    columns.add({"probe_halvings", "", "", "of the finer probe's lattice"}, row, probe_halvings_of);
    columns.add({"message", "message", "", "why the method ended"}, row, &TradeRow::message)
        .json_behind("status")
        .json_where([](const TradeRecord& of) { return !of.row.message.empty(); });
    return columns;
  }();
  return table;
}

std::vector<TradeRecord> records_of(const Scene& scene, const Trade& trade) {
  std::vector<TradeRecord> records;
  for (const TradeRow& of : trade.rows)
    records.push_back(
        {scene.name, trade.settings.reference,
         trade.reference_error ? std::optional(trade.reference_error->relative_l2) : std::nullopt, of,
         scene.dimension()});
  return records;
}

} // namespace maille::studies
