#pragma once
/// The question that every method is asked: what the body is, what holds it, what moves it, what pulls at
/// it.
///
/// read_scene or a SceneBuilder makes a Scene, and nothing changes it afterwards. Everything is in SI units
/// and in the object's frame: axes along the grid, origin where the specimen's coordinates are zero.
/// Conditions are resolved: regions have become lists of nodes and components, loads have become forces at
/// nodes. Names of conditions stay for tables and messages.

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

/// Where a body's fibres come from, and what had to be done to them.
///
/// Counts are of cells of matter as read, pieces that are left out later included; all zero but for tensor
/// images.
struct FibreReport {
  std::string
      source; ///< bipennate, curve, tensor_image, array; empty: one direction, or one a part of a muscle
  std::int64_t cells = 0;           ///< with a direction of their own to begin with, or given one
  std::int64_t no_tensor = 0;       ///< zero, or not a number
  std::int64_t not_positive = 0;    ///< a diffusion that is not positive along every axis: noise
  std::int64_t isotropic = 0;       ///< no direction stands out
  std::int64_t from_neighbours = 0; ///< cells without a direction that took the mean of those around them
  std::int64_t from_label = 0;      ///< that took the mean of their label: no neighbour could say
  std::int64_t from_body = 0;       ///< that took the mean of all labels: nothing in their own could say
  double smoothing_radius = 0;      ///< [m]; 0: not smoothed
  double smoothing_turn = 0;        ///< mean angle by which smoothing turned directions [rad]

  std::int64_t without_direction() const { return no_tensor + not_positive + isotropic; }
};

/// In a line: `from a tensor image: 6417 cells, 12 without a direction (...)`; empty where the source is.
std::string in_words(const FibreReport& report);

/// Nodes turned about an axis and then shifted, together with the components that are prescribed.
struct Turn {
  Vec3 axis{0, 0, 1}; ///< unit vector; the turn is right-handed about it
  double angle = 0;   ///< [rad], of any size
  Vec3 about{};       ///< a point of the axis [m]
  Vec3 by{};          ///< the shift [m]
  std::array<bool, 3> axes{true, true, true};
  std::vector<std::int64_t> nodes;

  /// Displacement of what rests at x, once that fraction of angle and shift is done [m].
  Vec3 displacement(const Vec3& x, double fraction = 1) const;
};

/// Cells that hold no matter carry this material number.
inline constexpr std::uint8_t no_material = 255;

/// Where the object's frame stands in the world of an image; the identity for generated shapes.
struct Placement {
  Vec3 origin{0, 0, 0}; ///< of the object's frame, in the world [m]
  std::array<Vec3, 3> direction{
      {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}}; ///< rows of the 3 x 3 matrix object -> world
  WorldAxes world = WorldAxes::unknown;   ///< what the world's axes point to
  bool is_identity() const { return origin == Placement{}.origin && direction == Placement{}.direction; }
  friend bool operator==(const Placement&, const Placement&) = default;
};
/// `vector` of the object's frame, in the world's.
Vec3 to_world(const Placement& placement, const Vec3& vector);
/// Where a point of the object's frame is in the world, and the other way [m].
Vec3 point_in_world(const Placement& placement, const Vec3& point);
Vec3 point_in_object(const Placement& placement, const Vec3& point);

/// The body: which cells hold what, and how its fibres run.
struct Specimen {
  std::string shape;    ///< box, ellipsoid, muscle, image
  std::string image;    ///< the file that a body of shape image was read from
  Grid grid;            ///< just large enough for the matter, pieces that are left out included
  Vec3 origin{0, 0, 0}; ///< of node 0, object's frame [m]
  Placement placement;
  std::vector<std::uint8_t> material_id;    ///< per cell; empty: every cell holds material 0
  Vec3 fibre{1, 0, 0};                      ///< unit vector; where `fibres` is empty
  std::vector<std::array<float, 3>> fibres; ///< per cell unit vectors, sign-free; empty: `fibre` everywhere
  FibreReport fibre_report;                 ///< how `fibres` came about
  /// Per cell the grey value in the label image that the body was read from, 0 where there is no matter.
  /// Empty where the body is no segmentation: a generated shape, one threshold, more than 255 grey values in
  /// the matter, or one that is no whole number.
  std::vector<std::int32_t> label;
  /// Per cell the part of it that is tissue, 0 to 1 (partial volume): what the cell's energy, weight and pull
  /// count. Empty: all of every cell of matter.
  std::vector<float> tissue;
  /// Per cell its stiffness over that of its material, > 0 (a map of stiffness). Empty: 1.
  std::vector<float> stiffness_ratio;

  double tissue_of(std::int64_t cell) const { return tissue.empty() ? 1 : double{tissue[cell]}; }
  double stiffness_ratio_of(std::int64_t cell) const {
    return stiffness_ratio.empty() ? 1 : double{stiffness_ratio[cell]};
  }
  /// What a cell's energy is over that of a whole cell of its material.
  double weight_of(std::int64_t cell) const { return tissue_of(cell) * stiffness_ratio_of(cell); }
  bool has_weights() const { return !tissue.empty() || !stiffness_ratio.empty(); }

  std::uint8_t material(std::int64_t cell) const {
    return material_id.empty() ? std::uint8_t{0} : material_id[cell];
  }
  bool is_matter(std::int64_t cell) const { return material(cell) != no_material; }
  Vec3 fibre_of(std::int64_t cell) const;
  /// Calls visit(cell number) for every cell of matter that has the node at a corner.
  template<class Visit>
  void for_each_cell_at(const Index3& node, Visit&& visit) const {
    for (int corner = 0; corner < grid.corners_per_cell(); ++corner) {
      const Index3 cell{node[0] - (corner & 1), node[1] - ((corner >> 1) & 1), node[2] - ((corner >> 2) & 1)};
      if (grid.has_cell(cell) && is_matter(grid.cell(cell)))
        visit(grid.cell(cell));
    }
  }
  /// The same for the cells that have the edge from `node` to its next along `axis`.
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
  bool held = false;           ///< by a hold, not by a move
  std::int32_t condition = -1; ///< into Scene::conditions, the first that asks for it; -1: of none
};

/// A traction on one face of one cell of matter.
struct FaceLoad {
  std::int64_t cell = 0;
  int axis = 0;                ///< of the face's normal
  bool upper = false;          ///< which of the two faces along `axis`
  Vec3 traction{};             ///< [Pa]; in 1D the cross-section is 1 m^2, in 2D the thickness 1 m
  std::int32_t condition = -1; ///< into Scene::conditions; -1: of none
  /// A pressure: at finite strain it stays normal to the face, on the area that the face has then.
  bool follows = false;
};

/// Springs from one face of one cell of matter to the ground.
struct FaceSpring {
  std::int64_t cell = 0;
  int axis = 0; ///< of the face's normal
  bool upper = false;
  double stiffness = 0;        ///< pull back over displacement, per area of the face [Pa/m]
  Vec3 direction{0, 0, 0};     ///< unit vector: they act along it alone; zero: along all axes alike
  std::int32_t condition = -1; ///< into Scene::conditions; -1: of none
};

/// Two labels that slide on each other wherever they touch: nodes of the border are there twice, tied along
/// its normal.
struct SlidingBorder {
  std::int32_t one = 0, other = 0;
  double friction = 0; ///< Coulomb's coefficient [1], at least 0
  friend bool operator==(const SlidingBorder&, const SlidingBorder&) = default;
};

/// Two nodes that move together: along directions, or all the way.
struct NodeTie {
  std::int64_t one = 0, other = 0;
  Vec3 normal{}; ///< of length 1, from `one` to `other`; zero: they move together along all axes
  /// Ties with a normal: the labels of the two sides, and the friction between them.
  std::array<std::int32_t, 2> label{};
  double friction = 0; ///< Coulomb's coefficient [1]
  double spring = 0;   ///< between the nodes across the normal, see Friction [N/m]
  Vec3 pull{};         ///< on `one`, its opposite on `other` [N]
};
/// Ties between copies of a body's nodes; see split_borders().
struct NodeTies {
  std::vector<NodeTie> ties;
  int planes = 0; ///< of nodes from a copy to the next, along z
};

/// A value over the time of a run, from 0 to 1: linear between points, constant beyond them.
struct TimeCourse {
  std::vector<std::array<double, 2>> points; ///< time, value; ascending in time; empty: the time itself
  double at(double time) const;
};

/// A place and an attitude of something rigid at a time: x -> about + rotation (x - about) + shift.
struct RigidPose {
  double time = 0;                            ///< 0 to 1
  std::array<double, 4> rotation{1, 0, 0, 0}; ///< unit quaternion w x y z, object's frame
  Vec3 shift{};                               ///< [m]
};

/// What drives a rigid label: the nodes go with it, along poses between which rotations turn evenly.
struct Drive {
  std::vector<std::int64_t> nodes;
  Vec3 about{};                 ///< [m]
  std::vector<RigidPose> poses; ///< ascending in time, the last at 1

  /// Displacement at a time of what rests at x [m]. @param time 0 to 1
  Vec3 displacement(const Vec3& x, double time) const;
  double turned() const; ///< the angles from pose to pose, added up [rad]
};

/// A contraction whose strength follows a course of its own over a run.
struct TimedContraction {
  std::vector<std::int64_t> cells;
  double stress = 0; ///< [Pa], times the course
  TimeCourse course;
};

/// A hold, a move or a load on faces as it was asked for.
struct NamedCondition {
  std::string name;  ///< `move[1]`, numbered from 1
  std::string where; ///< as the file has it: `"x+"`
};

/// Where the limits of the links come from; `none`: the question asks for none.
enum class LimitSource { none, material, taut, given, failure };

struct LimitSettings {
  LimitSource from = LimitSource::none;
  NeighbourLimits given; ///< along the object's axes; used with LimitSource::given
  /// The stress at which taut links are taut [Pa]; where unset, the one at which the scene's moves just use
  /// the slack up. A step of a series carries the scale of the whole move.
  std::optional<double> taut_scale;
  /// A prescribed value that limits cut back is an answer; otherwise it makes a run a failed one.
  bool cut_is_allowed = false;
};

/// How `sweep` and `relaxed` relax: the elastic system, or the deformable one of 1995 with a dead zone. Not
/// read by `coupled`.
enum class RelaxationMode { elastic, deformable };

/// Whether `coupled` solves coarser lattices too, to go from them towards ever finer ones where they show
/// how.
enum class Extrapolation { none, nested };
/// Which question a scene asks of elasticity: small strain, or finite strain by the laws of its materials.
enum class Strain { small, finite };

struct RelaxationSettings {
  RelaxationMode mode = RelaxationMode::elastic;
  int increments = 0;            ///< of finite strain; 0: as many as moves and loads ask for
  double tolerance = 1e-4;       ///< estimated remaining error / largest prescribed displacement
  std::int64_t sweeps = 1000000; ///< limit; then status budget_reached
  Extrapolation extrapolation = Extrapolation::none;
};

/// Matter that was left out because no held node is joined to it through faces of cells.
struct LeftOutPiece {
  std::int64_t cells = 0;
  std::string name; ///< e.g. `piece 3: 12 cells of muscle/soleus from (0.01, 0.02, 0.03) m on`
};

/// A scene's `[test]`, which sets its holds and moves: see test_result() of mechanics.hpp.
enum class TestKind { axial, shear, bend, indent, confined };
/// `axial`, `shear`, ... as a scene file has it.
std::string_view to_string(TestKind kind);

/// The whole lower face across `axis` is held, the upper one (indent: a round patch of it) is moved. Lengths
/// and areas are those of the bounding box, as apparent constants are of the body with its holes.
struct StandardTest {
  TestKind kind = TestKind::axial;
  int axis = 0;  ///< from the held face to the moved one
  int along = 1; ///< that the upper face is sheared along, or that the body is bent towards
  /// Bending: strain at the surface; otherwise displacement over length [1]. An indenter goes in where > 0.
  double strain = 0;
  double length = 0; ///< along `axis` [m]
  double area = 0;   ///< of the cross-section [m^2]; 1 in 1D; per metre of thickness in 2D [m]
  double second_moment =
      0;             ///< of the cross-section about its middle, in the plane of bending [m^4], in 2D [m^3]
  double radius = 0; ///< of the indenter [m]
  /// Pistoia 2002: bone fails where 2 % of its tissue is beyond an effective strain of 0.7 %.
  bool asks_for_failure = false;

  double displacement() const { return strain * length; } ///< [m]; of `bend` the arc's end says it
  double angle() const;                                   ///< that the upper face is turned by: bend [rad]
};

struct Scene {
  std::string name; ///< the file's name without its ending
  std::string title;
  Specimen specimen;
  std::vector<Material> materials;                 ///< at most 255; indexed by material_id
  PlaneAssumption plane = PlaneAssumption::strain; ///< 2D only
  Strain strain = Strain::small;                   ///< `coupled` and finite elements answer it
  std::vector<Prescribed> prescribed;              ///< sorted by (component, node), unique
  std::vector<Turn> turns;                         ///< the moves among them that turn, for steps of a series
  std::vector<FaceLoad> tractions;
  std::vector<FaceSpring> springs;
  std::vector<SlidingBorder> sliding;
  NodeTies tied;                          ///< of a scene that split_borders() made
  std::vector<Drive> drives;              ///< of `prescribed` what is driven, for steps of a series
  std::vector<TimedContraction> timed;    ///< of `active_stress` what has a course, for steps of a series
  std::vector<NamedCondition> conditions; ///< of prescribed, tractions and springs, in the file's order
  Vec3 gravity{0, 0, 0};                  ///< [m/s^2]
  /// Tension of contracting fibres, >= 0, per cell [Pa]: the stress is the elastic one plus active_stress a
  /// a^T, a the fibre's direction. Empty: no contraction.
  std::vector<double> active_stress;
  LimitSettings limits;
  RelaxationSettings relaxation;
  std::vector<LeftOutPiece> left_out;
  std::optional<StandardTest> test; ///< that `prescribed` is of

  int dimension() const { return specimen.grid.dimension(); }
  bool contracts() const { return !active_stress.empty(); }
  /// Source of the limits for methods that know only limits (limits, dijkstra, literal, sweep): limits.from;
  ///        without it, the materials' own if all have some, otherwise taut.
  LimitSource limit_source() const;
  /// True if `relaxed` stays within limits: the question asks for some. Finite elements know none.
  bool limits_bind_relaxed() const { return limits.from != LimitSource::none; }
  /// True if `coupled` does: taut limits are the elastic bar's, which it is without them.
  bool limits_bind_coupled() const { return limits_bind_relaxed() && limits.from != LimitSource::taut; }
  /// True if some matter has a direction: it contracts, is not isotropic, or the body has a field of them.
  bool has_fibres() const;
  bool has_loads() const { return !tractions.empty() || gravity != Vec3{0, 0, 0} || contracts(); }
  /// Largest |prescribed value| [m].
  double largest_prescribed() const;
  /// Axes of the material in a cell (columns): the fibre, and two across defined in the world
  /// (docs/scene.md).
  Eigen::Matrix3d material_axes(std::int64_t cell) const;
  /// 6 x 6 stiffness of the matter in a cell, object's frame, Voigt order 11 22 33 23 13 12 [Pa].
  Matrix6 object_stiffness(std::int64_t cell) const;
  /// The same, reduced to the scene's dimension [Pa].
  Eigen::MatrixXd cell_stiffness(std::int64_t cell) const;
  /// Stress that a cell's fibre pulls with, object's frame, in the order of object_stiffness [Pa]; zero where
  /// it does not contract.
  Eigen::Matrix<double, 6, 1> object_active_stress(std::int64_t cell) const;
  /// The same, reduced to the scene's dimension [Pa]: what is left of it at zero strain once the directions
  /// that cell_stiffness frees have given way, so that cell_stiffness strain + cell_active_stress is the
  /// stress.
  Eigen::VectorXd cell_active_stress(std::int64_t cell) const;
  /// The same of a fibre that pulls with `stress` [Pa].
  Eigen::VectorXd reduced_active_stress(std::int64_t cell, double stress) const;
};

/// A copy of `scene` whose moves and loads are multiplied by `fraction`: one step of a series. Turns go that
/// fraction of their angle; drives and contractions with a course are where they are at that time. The
/// limits that it asks for are those of the whole scene; those that `limits` and its like take where it
/// asks for none are the step's, unless `scene` is from with_limits.
Scene scaled(const Scene& scene, double fraction);

/// A copy of `scene` in which the scale of the taut limits that it asks for is known, so that no method
/// searches for it again; the same scene where it asks for none.
Scene with_taut_scale(const Scene& scene);

/// A copy of `scene` that asks for the limits that methods take which know nothing else (see limit_source),
/// their scale known.
Scene with_limits(const Scene& scene);

/// One component of the force on every node [N] (per metre in 2D): a traction's force goes to the nodes of
/// its face in equal parts, a cell's weight to its corners, and a cell's active stress pulls its corners
/// together by
/// - integral of B^T stress. That is what constant loads are worth to multilinear displacements, and of
/// active stress to any whose mean strain in a cell is theirs; its forces have neither a sum nor a moment.
/// Empty if the scene has no loads along this component.
List<double> nodal_forces(const Scene& scene, int component);

/// What springs to the ground do at a node: they pull with -stiffness u there.
struct NodalSpring {
  std::int64_t node = 0;
  Eigen::Matrix3d stiffness = Eigen::Matrix3d::Zero(); ///< symmetric, object's frame [N/m]
};
/// The scene's springs at nodes; a face's spring acts at its corners in equal parts. Sorted by node, each
/// once.
List<NodalSpring> nodal_springs(const Scene& scene);
/// Force of a spring on its node [N].
Vec3 pull_of(const NodalSpring& spring, const Displacement& u);
/// Half of u . stiffness u over all of them [J].
double energy_of_springs(const List<NodalSpring>& springs, const Displacement& u);

} // namespace maille
