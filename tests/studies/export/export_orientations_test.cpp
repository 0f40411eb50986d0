// One body from an image, stored in every order and direction of axes: files must not tell them apart.

#include "export/body_numbering.hpp"
#include "export/vtk_files.hpp"
#include "maille/deform/solve.hpp"
#include "maille/scene/read_scene.hpp"
#include "studies/export/export_reading.hpp"
#include "studies/export/export_scenes.hpp"
#include "support/kit.hpp"
#include "support/label_scene.hpp"

#include <Eigen/Geometry>
#include <vtkCell.h>
#include <vtkCellData.h>
#include <vtkFieldData.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkStringArray.h>

namespace maille::studies {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr Index3 size{5, 4, 3};
const Vector3d spacing{1, 1.5, 2}; // mm

/// A block of two kinds of matter without one corner, as the world sees it.
int label_at(int x, int y, int z) {
  return x == 0 && y == 0 && z == 2 ? 0 : x + y + z < 5 ? 17 : 19;
}

/// The axes of the file among those of the world; then all is turned.
struct Storage {
  test::Orientation file;
  Matrix3d turn = Matrix3d::Identity();

  /// Columns are the file's axes, before the turn.
  Matrix3d axes() const {
    Matrix3d columns = Matrix3d::Zero();
    for (int a = 0; a < 3; ++a)
      columns(along(std::size_t(a)), a) = file.flipped[std::size_t(a)] ? -1 : 1;
    return columns;
  }
  /// The world's axis that one of the file runs along.
  int along(std::size_t a) const { return int(file.axis[a]); }
};

std::string image_of(const Storage& storage) {
  test::LabelArray block{size, {}, {}};
  for (const auto& [x, y, z] : test::all_below(size))
    block.values.push_back(label_at(x, y, z));
  const Vector3d origin = storage.turn * Vector3d(-20, 30, 7);
  std::array<Vec3, 3> direction{};
  for (std::size_t row = 0; row < 3; ++row)
    for (std::size_t column = 0; column < 3; ++column)
      direction[row][column] = storage.turn(Eigen::Index(row), Eigen::Index(column));
  block.affine = affine_of({1e-3 * spacing[0], 1e-3 * spacing[1], 1e-3 * spacing[2]},
                           {1e-3 * origin[0], 1e-3 * origin[1], 1e-3 * origin[2]}, direction);
  return test::nifti_of(turned(block, storage.file));
}

std::string in_words(const Vector3d& v, const char* unit) {
  return fmt::format("[\"{} {}\", \"{} {}\", \"{} {}\"]", v[0], unit, v[1], unit, v[2], unit);
}

/// The same question in the file's axes: the body's lower end along the world's z is held, its upper one
/// moved.
std::string scene_of(const Storage& storage) {
  const Matrix3d to_file = storage.axes().transpose();
  const Vector3d fibre = to_file * Vector3d(0.48, 0.6, 0.64), move = to_file * Vector3d(0.02, -0.01, 0.05);
  std::string low, high;
  for (std::size_t a = 0; a < 3; ++a)
    if (storage.file.axis[a] == 2) {
      low = fmt::format("{}{}", "xyz"[a], storage.file.flipped[a] ? '+' : '-');
      high = fmt::format("{}{}", "xyz"[a], storage.file.flipped[a] ? '-' : '+');
    }
  return fmt::format(R"(
[specimen]
shape = "image"
image = "body.nii"
fibre = [{}, {}, {}]
[specimen.labels]
17 = {{ E_fibre = "90 kPa", E_cross = "20 kPa", G_fibre = "15 kPa", nu_fibre = 0.4, nu_cross = 0.3 }}
19 = {{ E_fibre = "900 kPa", E_cross = "100 kPa", G_fibre = "60 kPa", nu_fibre = 0.35, nu_cross = 0.25 }}
[[hold]]
where = "{}"
[[move]]
where = "{}"
by = {}
[limits]
from = "given"
stretch = 20
compress = 0.01
shear = 20
[relaxation]
tolerance = 1e-11
)",
                     fibre[0], fibre[1], fibre[2], low, high, in_words(move, "mm"));
}

Matrix3d matrix(const std::array<double, 6>& t) {
  Matrix3d m;
  m << t[0], t[3], t[5], t[3], t[1], t[4], t[5], t[4], t[2];
  return m;
}

using Place = std::array<long, 3>;
struct CellValues {
  Matrix3d strain, stress;
  Vector3d fibre, principal;
  double fibre_strain = 0, fibre_stress = 0, von_mises = 0, material = 0;
};
struct Found {
  std::map<Place, CellValues> cells;
  std::map<Place, std::array<Vector3d, 2>> points; ///< displacement and reaction
};

/// Micrometres of the world before the turn.
Place place_of(const Matrix3d& turn, const Vector3d& x) {
  const Vector3d back = turn.transpose() * x * 1e6;
  return {std::lround(back[0]), std::lround(back[1]), std::lround(back[2])};
}

/// What the file holds, in the axes of the world before the turn.
Found answer_of(const Storage& storage) {
  const test::TemporaryFolder folder;
  std::ofstream(folder / "body.nii", std::ios::binary) << image_of(storage);
  const Scene scene = parse_scene(scene_of(storage), folder / "body.toml");
  const Answer answer = deform::solve(scene, "coupled", {});
  EXPECT_EQ(answer.status, Status::done) << answer.message;
  ExportFields fields;
  fields.show(answer);
  const auto data = test::read_back(write_vtk(scene, fields, folder / "answer"));
  const Matrix3d& turn = storage.turn;
  const auto vector = [&](vtkFieldData& arrays, const char* name, vtkIdType i) -> Vector3d {
    Vector3d value;
    arrays.GetArray(name)->GetTuple(i, value.data());
    return turn.transpose() * value;
  };
  const auto tensor = [&](const char* name, vtkIdType i) -> Matrix3d {
    std::array<double, 6> value{};
    data->GetCellData()->GetArray(name)->GetTuple(i, value.data());
    return turn.transpose() * matrix(value) * turn;
  };
  Found found;
  for (vtkIdType i = 0; i < data->GetNumberOfPoints(); ++i)
    found.points[place_of(turn, Vector3d::Map(data->GetPoint(i)))] = {
        vector(*data->GetPointData(), "Displacement", i), vector(*data->GetPointData(), "Reaction", i)};
  vtkFieldData& cells = *data->GetCellData();
  for (vtkIdType i = 0; i < data->GetNumberOfCells(); ++i) {
    Vector3d centre = Vector3d::Zero();
    for (int corner = 0; corner < 8; ++corner)
      centre += Vector3d::Map(data->GetCell(i)->GetPoints()->GetPoint(corner)) / 8;
    CellValues values;
    values.strain = tensor("Strain", i);
    values.stress = tensor("Stress", i);
    values.fibre = vector(cells, "FiberDirection", i);
    values.principal = turn * vector(cells, "PrincipalStrain", i); // three numbers, no vector
    values.fibre_strain = cells.GetArray("FiberStrain")->GetTuple1(i);
    values.fibre_stress = cells.GetArray("FiberStress")->GetTuple1(i);
    values.von_mises = cells.GetArray("VonMises")->GetTuple1(i);
    values.material = cells.GetArray("MaterialId")->GetTuple1(i);
    found.cells[place_of(turn, centre)] = values;
  }
  return found;
}

void expect_same(const Found& found, const Found& expected, const std::string& how) {
  ASSERT_EQ(found.points.size(), expected.points.size()) << how;
  ASSERT_EQ(found.cells.size(), expected.cells.size()) << how;
  // A file's header holds float32: the body's axes agree to 1e-7, and so do the answers.
  for (const auto& [place, values] : expected.points) {
    ASSERT_TRUE(found.points.contains(place)) << how;
    EXPECT_LT((found.points.at(place)[0] - values[0]).norm(), 1e-6 * 5e-5) << how;
    EXPECT_LT((found.points.at(place)[1] - values[1]).norm(), 1e-6 * 1e-2) << how;
  }
  for (const auto& [place, values] : expected.cells) {
    ASSERT_TRUE(found.cells.contains(place)) << how;
    const CellValues& cell = found.cells.at(place);
    EXPECT_LT((cell.strain - values.strain).norm(), 1e-6 * 1e-2) << how;
    EXPECT_LT((cell.stress - values.stress).norm(), 1e-6 * 5e3) << how;
    EXPECT_LT((cell.fibre - values.fibre).norm(), 1e-6) << how;
    EXPECT_LT((cell.principal - values.principal).norm(), 1e-6 * 1e-2) << how;
    EXPECT_NEAR(cell.fibre_strain, values.fibre_strain, 1e-6 * 1e-2) << how;
    EXPECT_NEAR(cell.fibre_stress, values.fibre_stress, 1e-6 * 5e3) << how;
    EXPECT_NEAR(cell.von_mises, values.von_mises, 1e-6 * 5e3) << how;
    EXPECT_EQ(cell.material, values.material) << how;
  }
}

// Truth: physics does not depend on the order in which a file stores voxels; the file in the world's own
// order is the measure.
TEST(OrientationAnalytic, FilesAreTheSameHoweverTheImageIsStored) {
  const Found expected = answer_of({});
  ASSERT_EQ(expected.cells.size(), 59u);
  for (const test::Orientation& file : test::all_orientations()) {
    const auto& [axis, flipped] = file;
    expect_same(answer_of({file}), expected,
                fmt::format("order {}{}{}, flipped {:d}{:d}{:d}", axis[0], axis[1], axis[2], flipped[0],
                            flipped[1], flipped[2]));
  }
  const Matrix3d oblique = Eigen::AngleAxisd(0.7, Vector3d(1, 2, -2).normalized()).toRotationMatrix();
  expect_same(answer_of({{{2, 0, 1}, {false, true, false}}, oblique}), expected, "oblique");
}

// Truth: a E a, a S a and the eigenvalues of E, from the tensors and fibres of the same file.
TEST(OrientationAnalytic, FibreAndPrincipalValuesAreThoseOfTheTensors) {
  for (const auto& [place, cell] : answer_of({{{1, 2, 0}, {true, false, false}}}).cells) {
    EXPECT_NEAR(cell.fibre_strain, cell.fibre.dot(cell.strain * cell.fibre), 1e-12);
    EXPECT_NEAR(cell.fibre_stress, cell.fibre.dot(cell.stress * cell.fibre), 1e-6);
    const Matrix3d& e = cell.strain;
    const Vector3d& p = cell.principal; // by the invariants
    EXPECT_GE(p[0], p[1]);
    EXPECT_GE(p[1], p[2]);
    EXPECT_NEAR(p.sum(), e.trace(), 1e-12);
    EXPECT_NEAR(p.squaredNorm(), e.squaredNorm(), 1e-12);
    EXPECT_NEAR(p.prod(), e.determinant(), 1e-12);
  }
}

// Truth: the labels that were stored, cell by cell.
TEST(OrientationAnalytic, LabelsAndNamesOfMaterialsReachTheFile) {
  const test::TemporaryFolder folder;
  std::ofstream(folder / "body.nii", std::ios::binary) << image_of({});
  const Scene scene = parse_scene(scene_of({}), folder / "body.toml");
  const Displacement rest(scene.specimen.grid);
  const auto data = test::read_back(write_vtk(scene, {&rest}, folder / "answer"));
  vtkDataArray* const label = data->GetCellData()->GetArray("Label");
  ASSERT_NE(label, nullptr);
  vtkIdType cell = 0;
  for (const auto& [x, y, z] : test::all_below(size))
    if (label_at(x, y, z) != 0) {
      EXPECT_EQ(label->GetTuple1(cell++), label_at(x, y, z));
    }
  vtkFieldData& field = *data->GetFieldData();
  vtkDataArray* const numbers = field.GetArray("LabelNumbers");
  ASSERT_NE(numbers, nullptr);
  ASSERT_EQ(numbers->GetNumberOfTuples(), 2);
  const auto name = [&](const char* array, vtkIdType i) {
    return vtkStringArray::SafeDownCast(field.GetAbstractArray(array))->GetValue(i);
  };
  for (vtkIdType i = 0; i < 2; ++i) {
    EXPECT_EQ(numbers->GetTuple1(i), i == 0 ? 17 : 19);
    const auto material = static_cast<vtkIdType>(scene.specimen.material(i == 0 ? 0 : 58));
    EXPECT_EQ(name("MaterialNames", material), name("LabelMaterials", i));
    EXPECT_EQ(name("MaterialNames", material), scene.materials[std::size_t(material)].name);
  }
}

// Truth: what Gibson 1995 and chain mail know: no forces. Their files must not show any.
TEST(OrientationContract, MethodsWithoutForcesShowNoStress) {
  const test::TemporaryFolder folder;
  std::ofstream(folder / "body.nii", std::ios::binary) << image_of({});
  const Scene scene = parse_scene(scene_of({}), folder / "body.toml");
  for (const std::string method : {"limits", "literal", "dijkstra", "sweep", "relaxed", "coupled"}) {
    const Answer answer = deform::solve(scene, method, {});
    ASSERT_TRUE(has_displacement(answer.status)) << method << answer.message;
    ExportFields fields;
    fields.show(answer);
    const auto data = test::read_back(write_vtk(scene, fields, folder / method));
    const bool has = method == "relaxed" || method == "coupled";
    for (const char* name : {"Stress", "VonMises", "FiberStress"})
      EXPECT_EQ(data->GetCellData()->HasArray(name) != 0, has) << method << " " << name;
    for (const char* name : {"Strain", "PrincipalStrain", "FiberStrain"})
      EXPECT_TRUE(data->GetCellData()->HasArray(name)) << method << " " << name;
    EXPECT_TRUE(data->GetPointData()->HasArray("NodalStrain")) << method;
    EXPECT_EQ(data->GetPointData()->HasArray("NodalStress") != 0, has) << method;
  }
}

double dot(const Vec3& a, const Vec3& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/// A sheet whose fibres rotate by 2 degrees from cell to cell, with random signs.
Scene fan(unsigned seed) {
  Scene scene = test::block(2, {60, 3, 1});
  std::mt19937 lot(seed);
  for (std::int64_t cell = 0; cell < scene.specimen.grid.n_cells(); ++cell) {
    const double angle = 0.035 * scene.specimen.grid.cell_at(cell)[0], sign = lot() % 2 == 0 ? 1 : -1;
    scene.specimen.fibres.push_back({float(sign * std::cos(angle)), float(sign * std::sin(angle)), 0});
  }
  return scene;
}

// Truth: the field without the lot: it turns smoothly by 118 degrees, and its sum points along +y.
TEST(FibreSignsAnalytic, NeighboursAgreeAndTheWholePointsAhead) {
  const std::vector<Vec3> one = with_one_sign(fan(1).specimen, {}), two = with_one_sign(fan(2).specimen, {});
  const Grid& grid = fan(1).specimen.grid;
  for (std::int64_t cell = 0; cell < grid.n_cells(); ++cell) {
    const auto c = std::size_t(cell);
    const double angle = 0.035 * grid.cell_at(cell)[0];
    EXPECT_NEAR(one[c][0], std::cos(angle), 1e-6);
    EXPECT_NEAR(one[c][1], std::sin(angle), 1e-6);
    EXPECT_EQ(one[c], two[c]);
  }
}

// Truth: parts that do not touch each point along the world's axis that they are most nearly parallel to.
TEST(FibreSignsAnalytic, EveryPartPointsAlongThePositiveWorld) {
  Scene scene = test::block(1, {3, 1, 1});
  scene.specimen.material_id = {0, no_material, 0};
  scene.specimen.fibres = {{-0.8f, 0.6f, 0}, {0, 0, 0}, {0.28f, 0.96f, 0}};
  EXPECT_GT(dot(with_one_sign(scene.specimen, {})[0], {0.8, -0.6, 0}), 0.99);
  // A quarter turn about z: the object's y runs along the world's -x.
  const Placement turned{{}, {{{0, -1, 0}, {1, 0, 0}, {0, 0, 1}}}};
  EXPECT_GT(dot(with_one_sign(scene.specimen, turned)[0], {0.8, -0.6, 0}), 0.99);
  EXPECT_GT(dot(with_one_sign(scene.specimen, turned)[2], {-0.28, -0.96, 0}), 0.99);
  EXPECT_EQ(with_one_sign(scene.specimen, {})[1], (Vec3{0, 0, 0}));
}

} // namespace
} // namespace maille::studies
