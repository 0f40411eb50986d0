#include "study/plan/study_table.hpp"

#include "export/vtk_files.hpp"
#include "export/whole_file.hpp"
#include "maille/materials/fault.hpp"
#include "study/table_files.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <map>

namespace maille::studies {

namespace {

namespace fs = std::filesystem;

std::string beside(fs::path stem, const char* ending) {
  stem += ending;
  return stem.string();
}

/// Files for ParaView: one time step per case, one part per method.
std::vector<PvdEntry> pvd_entries(const std::vector<StudyRow>& rows, const fs::path& folder) {
  std::vector<PvdEntry> entries;
  std::vector<std::string> methods;
  for (const StudyRow& row : rows) {
    if (row.vtk.empty())
      continue;
    auto part = std::find(methods.begin(), methods.end(), row.method);
    if (part == methods.end())
      part = methods.insert(methods.end(), row.method);
    entries.push_back(
        {static_cast<double>(row.number), folder / row.vtk, static_cast<int>(part - methods.begin())});
  }
  return entries;
}

int place(const std::string& method, const std::vector<std::string>& methods) {
  return static_cast<int>(std::find(methods.begin(), methods.end(), method) - methods.begin());
}

/// Adds a row unless it exists; @throws InputError if a different row exists for that case and method
void add_row(std::map<std::pair<int, std::string>, StudyRow>& rows, StudyRow row, const fs::path& file) {
  const auto [there, is_new] = rows.try_emplace({row.number, row.method}, row);
  if (!is_new && (there->second.hash != row.hash || there->second.n_cases != row.n_cases))
    throw InputError({{file.string(), 0, fmt::format("case {}, {}", row.number, row.method),
                       fmt::format("the same scene in every table of the study {}", row.study),
                       fmt::format("hashes {:.12} and {:.12}, {} and {} cases", there->second.hash, row.hash,
                                   there->second.n_cases, row.n_cases)}});
}

/// True for a file name that is visible, is no option, and has no marks that change the text direction.
bool is_plain_name(const std::string& name) {
  const auto is_control = [](unsigned char c) { return c < ' ' || c == 0x7f; };
  return !name.empty() && !name.starts_with('.') && !name.starts_with('-') && name.size() < 200 &&
         name.find_first_of("/\\") == std::string::npos && std::ranges::none_of(name, is_control) &&
         nlohmann::json(name).dump(-1, ' ', false, nlohmann::json::error_handler_t::replace) ==
             "\"" + name + "\"" &&
         std::ranges::none_of(std::array{"\xe2\x80\x8e", "\xe2\x80\x8f", "\xe2\x80\xaa", "\xe2\x80\xab",
                                         "\xe2\x80\xac", "\xe2\x80\xad", "\xe2\x80\xae", "\xe2\x81\xa6",
                                         "\xe2\x81\xa7", "\xe2\x81\xa8", "\xe2\x81\xa9"},
                              [&](const char* mark) { return name.find(mark) != std::string::npos; });
}

/// Rows of one table have the same columns of measures: those that some row lacks are added to it, empty.
std::vector<StudyRow> with_same_measures(std::vector<StudyRow> rows) {
  std::vector<StudyMeasure> columns; // without values
  for (const StudyRow& row : rows)
    for (const StudyMeasure& measure : row.measures)
      if (std::ranges::find(columns, measure.name, &StudyMeasure::name) == columns.end())
        columns.push_back({measure.name, measure.unit, std::nullopt});
  for (StudyRow& row : rows) {
    std::vector<StudyMeasure> all = columns;
    for (StudyMeasure& measure : all) {
      const auto known = std::ranges::find(row.measures, measure.name, &StudyMeasure::name);
      measure.value = known == row.measures.end() ? std::nullopt : known->value;
    }
    row.measures = std::move(all);
  }
  return rows;
}

} // namespace

bool may_end_otherwise(const StudyRow& row) {
  const bool is_without_answer = row.status == Status::failed || row.status == Status::refused;
  const auto says = [&](const char* words) { return row.message.find(words) != std::string::npos; };
  // Texts of methods about insufficient memory: required and available memory, or a failed allocation.
  return is_without_answer && (row.is_of_machine || says(" are available") || says(" of free memory") ||
                               says("out of memory") || says("std::bad_alloc"));
}

void sort_rows(std::vector<StudyRow>& rows, const std::vector<std::string>& methods) {
  std::stable_sort(rows.begin(), rows.end(), [&](const StudyRow& a, const StudyRow& b) {
    return std::pair(a.number, place(a.method, methods)) < std::pair(b.number, place(b.method, methods));
  });
}

std::vector<fs::path> write_study_table(const std::vector<StudyRow>& given, const fs::path& stem) {
  const std::vector<StudyRow> rows = with_same_measures(given);
  std::string lines;
  for (const StudyRow& row : rows)
    lines += json_line(row) + "\n";
  std::vector<fs::path> files{beside(stem, ".jsonl"), beside(stem, ".csv")};
  write_whole(files[0], lines);
  write_whole(files[1], rows.empty() ? "" : columns_of_study().csv(rows));
  if (const auto entries = pvd_entries(rows, stem.parent_path()); !entries.empty()) {
    files.emplace_back(beside(stem, ".pvd"));
    write_pvd(entries, files.back());
  }
  return files;
}

std::vector<MergedTable> merge_study_tables(const std::vector<fs::path>& files, const fs::path& folder) {
  std::map<std::string, std::map<std::pair<int, std::string>, StudyRow>> of_study;
  std::map<std::string, std::vector<std::string>> methods; // in order of appearance
  for (const fs::path& file : files) {
    StudyTable table = read_study_table(file);
    for (StudyRow& row : table.rows) {
      if (!row.vtk.empty())
        row.vtk = fs::absolute(file.parent_path() / row.vtk)
                      .lexically_normal()
                      .lexically_relative(fs::absolute(folder).lexically_normal())
                      .generic_string();
      auto& known = methods[row.study];
      auto& rows = of_study[row.study];
      if (std::find(known.begin(), known.end(), row.method) == known.end())
        known.push_back(row.method);
      add_row(rows, std::move(row), file);
    }
  }
  std::vector<MergedTable> merged;
  for (auto& [study, rows] : of_study) {
    if (!is_plain_name(study))
      throw InputError({{files.front().string(), 0, "study", "the name of a study, one plain name of a file",
                         "\"" + study + "\""}});
    MergedTable& table = merged.emplace_back();
    table.study = study;
    int last = 0, n_present = 0;
    for (auto& [key, row] : rows) { // sorted by case
      n_present += key.first != last;
      last = key.first;
      table.rows.push_back(std::move(row));
    }
    table.missing = table.rows.front().n_cases - n_present;
    sort_rows(table.rows, methods[study]);
  }
  return merged;
}

} // namespace maille::studies
