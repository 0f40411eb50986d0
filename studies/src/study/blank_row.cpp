#include "study/blank_row.hpp"

#include "maille/studies/version.hpp"

namespace maille::studies {

void name_case(StudyRow& row, const StudyFile& study, const StudyCase& one) {
  row.study = study.name();
  row.scene = study.scenes[one.scene].name();
  row.number = one.number;
  row.parameters.clear();
  for (std::size_t p = 0; p < study.parameters.size(); ++p)
    row.parameters.emplace_back(study.parameters[p].column(), one.values[p].shown);
}

StudyRow blank_row(const StudyFile& study, const StudyCase& one, const std::string& method,
                   const std::string& hash, const StudyOptions& options) {
  StudyRow row;
  name_case(row, study, one);
  row.method = method;
  row.reference = study.reference;
  row.repetitions = method == study.reference ? 1 : study.repetitions;
  row.threads = options.threads;
  row.maille = version;
  row.hash = hash;
  return row;
}

} // namespace maille::studies
