#pragma once
/// The input of every method: the body, its holds, moves and loads.
///
/// read_scene or a SceneBuilder makes a Scene; it is constant afterwards. Everything is in SI units and in
/// the object's frame: axes along the grid, origin where the specimen's coordinates are zero. Conditions are
/// resolved: regions are lists of nodes and components, loads are forces at nodes. Names of conditions are
/// kept for tables and messages.

#include "maille/base/arena.hpp"
#include "maille/base/grid.hpp"
#include "maille/materials/material.hpp"

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace maille {

class Displacement;

/// Source of a body's fibres, and the corrections that were made to them.
///
/// Counts are of cells of matter as read, including pieces that are left out later; zero except for tensor
/// images.
struct FibreReport {
  std::string
      source; ///< bipennate, curve, tensor_image, array; empty: one direction, or one per part of a muscle
  std::int64_t cells = 0;           ///< with a direction, read or assigned
  std::int64_t no_tensor = 0;       ///< tensor zero or NaN
  std::int64_t not_positive = 0;    ///< an eigenvalue of the diffusion is not positive: noise
  std::int64_t isotropic = 0;       ///< no dominant direction
  std::int64_t from_neighbours = 0; ///< cells without a direction that took the mean of their neighbours
  std::int64_t from_label = 0;      ///< that took the mean of their label: no neighbour has a direction
  std::int64_t from_body = 0;  ///< that took the mean of all labels: no cell of their label has a direction
  double smoothing_radius = 0; ///< [m]; 0: not smoothed
  double smoothing_turn = 0;   ///< mean rotation of directions by smoothing [rad]

  std::int64_t without_direction() const { return no_tensor + not_positive + isotropic; }
};

/// One line: `from a tensor image: 6417 cells, 12 without a direction (...)`; empty if the source is empty.
std::string in_words(const FibreReport& report);

/// Nodes that are rotated about an axis and then shifted, and the components that are prescribed.
struct Turn {
  Vec3 axis{0, 0, 1}; ///< unit vector; the turn is right-handed about it
  double angle = 0;   ///< [rad], of any size
  Vec3 about{};       ///< a point of the axis [m]
  Vec3 by{};          ///< the shift [m]
  std::array<bool, 3> axes{true, true, true};
  std::vector<std::int64_t> nodes;

  /// Displacement of a point that rests at x, after that fraction of angle and shift [m].
  Vec3 displacement(const Vec3& x, double fraction = 1) const;
};

/// Material number of cells without matter.
inline constexpr std::uint8_t no_material = 255;

/// Position and orientation of the object's frame in an image's world; the identity for generated shapes.
struct Placement {
  Vec3 origin{0, 0, 0}; ///< of the object's frame, in the world [m]
  std::array<Vec3, 3> direction{
      {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}}; ///< rows of the 3 x 3 matrix object -> world
  WorldAxes world = WorldAxes::unknown;   ///< directions of the world's axes
  bool is_identity() const { return origin == Placement{}.origin && direction == Placement{}.direction; }
  friend bool operator==(const Placement&, const Placement&) = default;
};
/// Transforms `vector` from the object's frame to the world's.
Vec3 to_world(const Placement& placement, const Vec3& vector);
/// Transforms a point from the object's frame to the world, and back [m].
Vec3 point_in_world(const Placement& placement, const Vec3& point);
Vec3 point_in_object(const Placement& placement, const Vec3& point);

/// The body: the material and fibre direction of each cell.
struct Specimen {
  std::string shape;    ///< box, ellipsoid, muscle, image
  std::string image;    ///< the image file of a body with shape image
  Grid grid;            ///< bounding box of the matter, including pieces that are left out
  Vec3 origin{0, 0, 0}; ///< of node 0, object's frame [m]
  Placement placement;
  std::vector<std::uint8_t> material_id;    ///< per cell; empty: every cell holds material 0
  Vec3 fibre{1, 0, 0};                      ///< unit vector; used if `fibres` is empty
  std::vector<std::array<float, 3>> fibres; ///< per cell unit vectors, sign-free; empty: `fibre` everywhere
  FibreReport fibre_report;                 ///< source and corrections of `fibres`
  /// Grey value per cell in the label image that the body was read from; 0 without matter. Empty if the body
  /// is no segmentation: a generated shape, one threshold, more than 255 grey values in the matter, or a grey
  /// value that is not a whole number.
  std::vector<std::int32_t> label;
  /// Tissue fraction per cell, 0 to 1 (partial volume); it scales the energy, weight and active stress of the
  /// cell. Empty: 1 for every cell of matter.
  std::vector<float> tissue;
  /// Stiffness per cell relative to its material, > 0 (a map of stiffness). Empty: 1.
  std::vector<float> stiffness_ratio;

  double tissue_of(std::int64_t cell) const { return tissue.empty() ? 1 : double{tissue[cell]}; }
  double stiffness_ratio_of(std::int64_t cell) const {
    return stiffness_ratio.empty() ? 1 : double{stiffness_ratio[cell]};
  }
  /// Energy of a cell relative to that of a whole cell of its material.
  double weight_of(std::int64_t cell) const { return tissue_of(cell) * stiffness_ratio_of(cell); }
  bool has_weights() const { return !tissue.empty() || !stiffness_ratio.empty(); }

  std::uint8_t material(std::int64_t cell) const {
    return material_id.empty() ? std::uint8_t{0} : material_id[cell];
  }
  bool is_matter(std::int64_t cell) const { return material(cell) != no_material; }
  Vec3 fibre_of(std::int64_t cell) const;
  /// Calls visit(cell number) for every cell of matter with the node at a corner.
  template<class Visit>
  void for_each_cell_at(const Index3& node, Visit&& visit) const {
    for (int corner = 0; corner < grid.corners_per_cell(); ++corner) {
      const Index3 cell{node[0] - (corner & 1), node[1] - ((corner >> 1) & 1), node[2] - ((corner >> 2) & 1)};
      if (grid.has_cell(cell) && is_matter(grid.cell(cell)))
        visit(grid.cell(cell));
    }
  }
  /// The same for the cells with the edge from `node` to its next node along `axis`.
  template<class Visit>
  void for_each_cell_at_link(const Index3& node, int axis, Visit&& visit) const {
    for (int corner = 0; corner < grid.corners_per_cell(); ++corner) {
      if (corner & (1 << axis))
        continue;
      const Index3 cell{node[0] - (corner & 1), node[1] - ((corner >> 1) & 1), node[2] - ((corner >> 2) & 1)};
      if (grid.has_cell(cell) && is_matter(grid.cell(cell)))
        visit(grid.cell(cell));
    }
  }
  /// True if the node borders at least one cell of matter.
  bool is_node(const Index3& node) const;
  std::int64_t n_matter_cells() const;
  std::int64_t n_matter_nodes() const;
  /// Edges of the grid that border at least one cell of matter.
  std::int64_t n_matter_links() const;
  /// Position of a node at rest, object's frame [m].
  Vec3 position(const Index3& node) const;
};

/// One displacement component of one node that the scene prescribes.
struct Prescribed {
  std::int64_t node = 0;
  int component = 0;
  double value = 0;            ///< [m]; 0 for holds
  bool held = false;           ///< true: by a hold; false: by a move
  std::int32_t condition = -1; ///< index into Scene::conditions, the first that prescribes it; -1: none
};

/// A traction on one face of one cell of matter.
struct FaceLoad {
  std::int64_t cell = 0;
  int axis = 0;                ///< of the face's normal
  bool upper = false;          ///< which of the two faces along `axis`
  Vec3 traction{};             ///< [Pa]; in 1D the cross-section is 1 m^2, in 2D the thickness 1 m
  std::int32_t condition = -1; ///< index into Scene::conditions; -1: none
  /// True for a pressure: at finite strain it stays normal to the face and acts on the deformed area.
  bool follows = false;
};

/// Springs from one face of one cell of matter to the ground.
struct FaceSpring {
  std::int64_t cell = 0;
  int axis = 0; ///< of the face's normal
  bool upper = false;
  double stiffness = 0;        ///< force over displacement, per area of the face [Pa/m]
  Vec3 direction{0, 0, 0};     ///< unit vector: they act along it only; zero: equally along all axes
  std::int32_t condition = -1; ///< index into Scene::conditions; -1: none
};

/// Two labels that slide on each other where they touch: nodes of the border are duplicated and tied along
/// its normal.
struct SlidingBorder {
  std::int32_t one = 0, other = 0;
  double friction = 0; ///< Coulomb's coefficient [1], at least 0
  friend bool operator==(const SlidingBorder&, const SlidingBorder&) = default;
};

/// Two nodes that move together along one direction or along all axes.
struct NodeTie {
  std::int64_t one = 0, other = 0;
  Vec3 normal{}; ///< unit vector from `one` to `other`; zero: tied along all axes
  /// Ties with a normal: the labels of the two sides, and the friction between them.
  std::array<std::int32_t, 2> label{};
  double friction = 0; ///< Coulomb's coefficient [1]
  double spring = 0;   ///< between the nodes, perpendicular to the normal, see Friction [N/m]
  Vec3 pull{};         ///< on `one`, its opposite on `other` [N]
};
/// Ties between copies of a body's nodes; see split_borders().
struct NodeTies {
  std::vector<NodeTie> ties;
  int planes = 0; ///< planes of nodes from one copy to the next, along z
};

/// A value over the time of a run, from 0 to 1: linear between points, constant beyond them.
struct TimeCourse {
  std::vector<std::array<double, 2>> points; ///< time, value; ascending in time; empty: the time itself
  double at(double time) const;
};

/// Position and orientation of a rigid label at a time: x -> about + rotation (x - about) + shift.
struct RigidPose {
  double time = 0;                            ///< 0 to 1
  std::array<double, 4> rotation{1, 0, 0, 0}; ///< unit quaternion w x y z, object's frame
  Vec3 shift{};                               ///< [m]
};

/// Motion of a rigid label: its nodes follow the poses; between poses the rotation angle is linear in time.
struct Drive {
  std::vector<std::int64_t> nodes;
  Vec3 about{};                 ///< [m]
  std::vector<RigidPose> poses; ///< ascending in time, the last at 1

  /// Displacement at a time of a point that rests at x [m]. @param time 0 to 1
  Vec3 displacement(const Vec3& x, double time) const;
  double turned() const; ///< sum of the angles between poses [rad]
};

/// A contraction whose strength follows its own time course.
struct TimedContraction {
  std::vector<std::int64_t> cells;
  double stress = 0; ///< [Pa], times the course
  TimeCourse course;
};

/// A hold, a move or a load on faces as the file states it.
struct NamedCondition {
  std::string name;  ///< `move[1]`, numbered from 1
  std::string where; ///< as in the file: `"x+"`
};

/// Source of the limits of links; `none`: the scene has no limits.
enum class LimitSource { none, material, taut, given, failure };

struct LimitSettings {
  LimitSource from = LimitSource::none;
  NeighbourLimits given; ///< along the object's axes; used with LimitSource::given
  /// Stress at which taut links are taut [Pa]; unset: the stress at which the scene's moves use up the slack
  /// exactly. A step of a series has the scale of the whole move.
  std::optional<double> taut_scale;
  /// True: a run with clipped prescribed values counts as answered; false: as failed.
  bool cut_is_allowed = false;
};

/// Model of `sweep` and `relaxed`: the elastic system, or the deformable one of 1995 with a dead zone.
/// `coupled` does not read it.
enum class RelaxationMode { elastic, deformable };

/// Nested: `coupled` also solves coarser lattices and extrapolates to zero spacing at nodes whose error falls
/// by a steady ratio.
enum class Extrapolation { none, nested };
/// Small strain, or finite strain by the laws of the materials.
enum class Strain { small, finite };

struct RelaxationSettings {
  RelaxationMode mode = RelaxationMode::elastic;
  int increments = 0;            ///< at finite strain; 0: chosen from moves and loads
  double tolerance = 1e-4;       ///< estimated remaining error / largest prescribed displacement
  std::int64_t sweeps = 1000000; ///< limit; then status budget_reached
  Extrapolation extrapolation = Extrapolation::none;
};

/// Matter that is left out because no path through faces of cells joins it to a held node.
struct LeftOutPiece {
  std::int64_t cells = 0;
  std::string name; ///< e.g. `piece 3: 12 cells of muscle/soleus from (0.01, 0.02, 0.03) m on`
};

/// Kind of a scene's `[test]`, which sets its holds and moves: see test_result() of mechanics.hpp.
enum class TestKind { axial, shear, bend, indent, confined };
/// `axial`, `shear`, ... as a scene file has it.
std::string_view to_string(TestKind kind);

/// The whole lower face across `axis` is held; the upper one (indent: a round patch of it) is moved. Lengths
/// and areas are those of the bounding box, because apparent constants refer to the body including its holes.
struct StandardTest {
  TestKind kind = TestKind::axial;
  int axis = 0;  ///< from the held face to the moved one
  int along = 1; ///< direction of shear of the upper face, or of bending
  /// Bending: strain at the surface; otherwise displacement over length [1]. Indentation: > 0 is inward.
  double strain = 0;
  double length = 0; ///< along `axis` [m]
  double area = 0;   ///< of the cross-section [m^2]; 1 in 1D; per metre of thickness in 2D [m]
  double second_moment =
      0;             ///< of the cross-section about its centre, in the plane of bending [m^4], in 2D [m^3]
  double radius = 0; ///< of the indenter [m]
  /// Requests the failure load (Pistoia 2002): bone fails when 2 % of its tissue exceeds an effective strain
  /// of 0.7 %.
  bool asks_for_failure = false;

  double displacement() const { return strain * length; } ///< [m]; for `bend` see end_of_arc()
  double angle() const;                                   ///< rotation of the upper face: bend [rad]
};

struct Scene {
  std::string name; ///< the file's name without its ending
  std::string title;
  Specimen specimen;
  std::vector<Material> materials;                 ///< at most 255; indexed by material_id
  PlaneAssumption plane = PlaneAssumption::strain; ///< 2D only
  Strain strain = Strain::small;                   ///< only `coupled` and finite elements solve finite strain
  std::vector<Prescribed> prescribed;              ///< sorted by (component, node), unique
  std::vector<Turn> turns;                         ///< those that are rotations, for steps of a series
  std::vector<FaceLoad> tractions;
  std::vector<FaceSpring> springs;
  std::vector<SlidingBorder> sliding;
  NodeTies tied;                       ///< only in scenes from split_borders()
  std::vector<Drive> drives;           ///< the driven part of `prescribed`, for steps of a series
  std::vector<TimedContraction> timed; ///< the part of `active_stress` with a course, for steps of a series
  std::vector<NamedCondition> conditions; ///< of prescribed, tractions and springs, in the file's order
  Vec3 gravity{0, 0, 0};                  ///< [m/s^2]
  /// Tension of contracting fibres, >= 0, per cell [Pa]. Stress = elastic stress + active_stress a a^T, with
  /// a the fibre direction. Empty: no contraction.
  std::vector<double> active_stress;
  LimitSettings limits;
  RelaxationSettings relaxation;
  std::vector<LeftOutPiece> left_out;
  std::optional<StandardTest> test; ///< the source of `prescribed`

  int dimension() const { return specimen.grid.dimension(); }
  bool contracts() const { return !active_stress.empty(); }
  /// Source of the limits for the methods that need limits (limits, dijkstra, literal, sweep): limits.from if
  /// set; else the materials' own if all materials have them, else taut.
  LimitSource limit_source() const;
  /// True if `relaxed` obeys limits: the scene states some. Finite elements ignore them.
  bool limits_bind_relaxed() const { return limits.from != LimitSource::none; }
  /// True if `coupled` obeys limits: not taut ones, which reproduce the elastic bar that it solves anyway.
  bool limits_bind_coupled() const { return limits_bind_relaxed() && limits.from != LimitSource::taut; }
  /// True if fibre directions matter: contraction, anisotropic materials, or directions of cells.
  bool has_fibres() const;
  bool has_loads() const { return !tractions.empty() || gravity != Vec3{0, 0, 0} || contracts(); }
  /// Largest |prescribed value| [m].
  double largest_prescribed() const;
  /// Axes of the material in a cell (columns): the fibre, and two transverse axes that are defined in the
  /// world (docs/scene.md).
  Eigen::Matrix3d material_axes(std::int64_t cell) const;
  /// 6 x 6 stiffness of the matter in a cell, object's frame, Voigt order 11 22 33 23 13 12 [Pa].
  Matrix6 object_stiffness(std::int64_t cell) const;
  /// The same, reduced to the scene's dimension [Pa].
  Eigen::MatrixXd cell_stiffness(std::int64_t cell) const;
  /// Active stress of a cell, object's frame, as object_stiffness [Pa]; zero without contraction.
  Eigen::Matrix<double, 6, 1> object_active_stress(std::int64_t cell) const;
  /// The same, reduced to the scene's dimension [Pa]: the stress at zero strain after the free directions of
  /// cell_stiffness have relaxed, so that stress = cell_stiffness strain + cell_active_stress.
  Eigen::VectorXd cell_active_stress(std::int64_t cell) const;
  /// The same for a fibre with the active stress `stress` [Pa].
  Eigen::VectorXd reduced_active_stress(std::int64_t cell, double stress) const;
};

/// A copy of `scene` whose moves and loads are multiplied by `fraction`: one step of a series. Turns take
/// that fraction of their angle; drives and contractions with a course are evaluated at that time. Limits
/// that the scene states are those of the whole scene; default limits of `limits` and similar methods are
/// those of the step, unless `scene` is from with_limits.
Scene scaled(const Scene& scene, double fraction);

/// A copy of `scene` with the scale of its taut limits set, so that no method searches for it again;
/// unchanged if it states no taut limits.
Scene with_taut_scale(const Scene& scene);

/// A copy of `scene` with the limits of limit_source(), their scale set.
Scene with_limits(const Scene& scene);

/// One component of the force on every node [N] (per metre in 2D): a traction is shared equally by the nodes
/// of its face, a cell's weight by its corners. Active stress contributes - integral of B^T stress: the
/// consistent load of a constant stress for multilinear displacements, and for any displacements with the
/// same mean strain per cell; its forces have zero sum and zero moment. Empty if the scene has no loads along
/// this component.
List<double> nodal_forces(const Scene& scene, int component);

/// Springs to the ground at a node: their force is -stiffness u.
struct NodalSpring {
  std::int64_t node = 0;
  Eigen::Matrix3d stiffness = Eigen::Matrix3d::Zero(); ///< symmetric, object's frame [N/m]
};
/// The scene's springs at nodes; a face's spring is shared equally by its corners. Sorted by node, unique.
List<NodalSpring> nodal_springs(const Scene& scene);
/// Force of a spring on its node [N].
Vec3 pull_of(const NodalSpring& spring, const Displacement& u);
/// Sum of u . stiffness u / 2 over all springs [J].
double energy_of_springs(const List<NodalSpring>& springs, const Displacement& u);

} // namespace maille
