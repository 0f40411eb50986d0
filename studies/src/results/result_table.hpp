#pragma once
/// Result table: the columns of one row type define its text, JSON, CSV and readers.
/// is read.
///
///   columns.add({"bytes", "bytes", "B", "held"}, {"memory", 10, in_words}, &Row::answer, &Answer::bytes);
///
/// A column has a name, a unit, a meaning, and a path of members from the row to a value. An empty optional
/// or null pointer on the path gives an empty cell. Paths of members only can also be read (CSV to rows).

#include "maille/materials/fault.hpp"
#include "results/columns.hpp"

namespace maille::studies {

/// Value at the end of a path of members and functions; null if a step is empty.
template<class Part, class Step, class... Rest>
Value value_at(const Part& part, const Step& step, const Rest&... rest) {
  if constexpr (is_optional<Part> || std::is_pointer_v<Part>)
    return part ? value_at(*part, step, rest...) : Value();
  else if constexpr (sizeof...(rest) == 0)
    return value_of(std::remove_cvref_t<std::invoke_result_t<Step, const Part&>>(std::invoke(step, part)));
  else
    return value_at(std::invoke(step, part), rest...);
}

template<class Step>
struct MemberType {
  using type = void*; // for functions
};
template<class Class, class Type>
requires(!std::is_function_v<Type>) struct MemberType<Type Class::*> {
  using type = Type;
};

/// True if a path is writable: it has only members, and no pointers.
template<class... Steps>
inline constexpr bool is_writable = (!std::is_pointer_v<typename MemberType<Steps>::type> && ...);
template<class... Steps>
inline constexpr bool passes_optional = (is_optional<typename MemberType<Steps>::type> || ...);

/// Reference to the end of such a path; creates missing optionals.
template<class Part, class Step, class... Rest>
auto& made_at(Part& part, Step step, Rest... rest) {
  if constexpr (is_optional<Part>)
    return made_at(part ? *part : part.emplace(), step, rest...);
  else if constexpr (sizeof...(rest) == 0)
    return part.*step;
  else
    return made_at(part.*step, rest...);
}

template<class Row>
class ResultTable : public Columns {
public:
  using Columns::Columns;
  /// @param fill adds the columns
  explicit ResultTable(void (*fill)(ResultTable&), CsvNumbers numbers = {}) : Columns(numbers) {
    fill(*this);
  }
  using Condition = std::function<bool(const Row&)>;
  using Reader = std::function<bool(Row&, const Value&)>;

  /// Adds a column with its path: members, functions, lambdas. Readable if the path is writable.
  template<class... Steps>
  ResultTable& add(FigureName name, Shown shown, Steps... steps) {
    append(std::move(name), std::move(shown));
    figures_.push_back({[steps...](const Row& row) { return value_at(row, steps...); }, {}, {}});
    if constexpr (is_writable<Steps...>)
      if constexpr (is_readable<std::remove_reference_t<decltype(made_at(std::declval<Row&>(), steps...))>>)
        add_reader(steps...);
    return *this;
  }
  template<class... Steps>
  ResultTable& add(FigureName name, Steps... steps) {
    return add(std::move(name), Shown{}, steps...);
  }

  /// Adds a column with rows of another table, which must outlive this one. @param steps to the list
  template<class Of, class... Steps>
  ResultTable& add_rows(FigureName name, const ResultTable<Of>& of, Steps... steps) {
    add(std::move(name), steps..., [&of](const auto& rows) { return of.json_rows(rows); });
    last().is_list = true;
    return last().within = &of, *this;
  }
  /// Adds a column with one row of another table; no value if the path to the row is empty.
  template<class Of, class... Steps>
  ResultTable& add_row(FigureName name, const ResultTable<Of>& of, Steps... steps) {
    add(std::move(name), steps..., [&of](const Of& row) { return of.json(row); });
    return last().within = &of, *this;
  }

  /// Properties of the last added column.
  ResultTable& omitted(bool is = true) { return last().is_omitted = is, *this; }
  ResultTable& open() { return last().is_open = true, *this; }
  ResultTable& digits(int n) { return last().digits = n, *this; }
  ResultTable& json_behind(const std::string& key) { return move_in_json(key), *this; }
  ResultTable& text_behind(const std::string& heading) { return move_in_text(heading), *this; }
  /// JSON contains it only for rows with this property.
  ResultTable& json_where(Condition has) { return figures_.back().is_in_json = std::move(has), *this; }
  /// Reader of a column whose path does not define one.
  ResultTable& read_by(std::string expected, Reader read) {
    last().is_read = true;
    last().expected = std::move(expected);
    return figures_.back().read = std::move(read), *this;
  }

  Values values(const Row& row) const {
    Values all;
    for (const Figure& figure : figures_)
      all.push_back(figure.value(row));
    return all;
  }
  template<class Rows>
  std::vector<Values> all_values(const Rows& rows) const {
    std::vector<Values> all;
    for (const Row& row : rows)
      all.push_back(values(row));
    return all;
  }

  nlohmann::ordered_json json(const Row& row) const {
    Values all = values(row);
    for (std::size_t i = 0; i < all.size(); ++i)
      if (figures_[i].is_in_json && !figures_[i].is_in_json(row))
        all[i] = Value(Value::value_t::discarded);
    return json_of(all);
  }
  template<class Rows>
  nlohmann::ordered_json json_rows(const Rows& rows) const {
    auto list = nlohmann::ordered_json::array();
    for (const Row& row : rows)
      list.push_back(json(row));
    return list;
  }

  std::string csv_header(const Row& row) const { return csv_header_of(values(row)); }
  std::string csv_line(const Row& row) const { return csv_line_of(values(row)); }
  /// Header, with the columns from an open column that the first row has, and one line per row.
  template<class Rows>
  std::string csv(const Rows& rows) const {
    std::string text = csv_header_of(std::empty(rows) ? Values(list().size()) : values(*std::begin(rows)));
    for (const Row& row : rows)
      text += csv_line(row);
    return text;
  }
  template<class Rows>
  std::string text(const Rows& rows) const {
    return text_of(all_values(rows));
  }

  /// @param faults receives the errors of that row, under its JSON keys
  Row read_json(const nlohmann::ordered_json& json, const std::string& file, int line,
                std::vector<Fault>& faults) const {
    if (!json.is_object()) {
      faults.push_back({file, line, "", "an object of JSON", "something else"});
      return {};
    }
    return row_of(values_of(json), [&](const Column& column, const Value& value) {
      faults.push_back({file, line, column.json, column.expected, found_in_words(value)});
    });
  }

private:
  struct Figure {
    std::function<Value(const Row&)> value;
    Reader read;          ///< empty: write only
    Condition is_in_json; ///< empty: in every row
  };

  template<class... Steps>
  void add_reader(Steps... steps) {
    using Type = std::remove_reference_t<decltype(made_at(std::declval<Row&>(), steps...))>;
    Column& column = last();
    column.is_read = true;
    column.is_real = std::is_floating_point_v<Type> || std::is_same_v<Type, std::optional<double>>;
    column.is_optional = passes_optional<Steps...>;
    column.expected = expected_of<Type>();
    figures_.back().read = [steps...](Row& row, const Value& value) {
      return (passes_optional<Steps...> && value.is_null()) || read_value(value, made_at(row, steps...));
    };
  }

  template<class Refuse>
  Row row_of(const Values& values, const Refuse& refuse) const {
    Row row;
    for (std::size_t i = 0; i < values.size(); ++i)
      if (figures_[i].read && !values[i].is_discarded() && !figures_[i].read(row, values[i]))
        refuse(list()[i], values[i]);
    return row;
  }

  std::vector<Figure> figures_;
};

} // namespace maille::studies
