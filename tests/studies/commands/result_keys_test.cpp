/// Keys of JSON and columns of CSV that scripts read, in their order: they are added to, never renamed.

#include "studies/commands/command_scenes.hpp"
#include "studies/commands/run_command.hpp"
#include "support/kit.hpp"

#include <nlohmann/json.hpp>

namespace maille {
namespace {

using nlohmann::ordered_json;
using test::maille_command;
using test::Outcome;

const std::string strip =
    test::pulled_box_text("[16, 8, 8]", "[\"0.5 mm\", 0, 0]") + "[limits]\nfrom = \"taut\"\n";

const std::string world = test::floor_pad_and_finger(R"(["12 mm", "9 mm", "12 mm"])");

constexpr const char* down = R"(frame_time = "100 ms"
[[drive]]
object = "finger"
by = [0, 0, "-2 mm"]
frames = 3
)";

/// Of objects in lists those of all of them: `methods[].way`.
void add_keys(const ordered_json& value, const std::string& path, std::vector<std::string>& keys) {
  if (value.is_object())
    for (const auto& [key, member] : value.items())
      add_keys(member, path.empty() ? key : path + "." + key, keys);
  else if (value.is_array() && !value.empty() && value[0].is_object())
    for (const ordered_json& member : value)
      add_keys(member, path + "[]", keys);
  else if (std::ranges::find(keys, path) == keys.end())
    keys.push_back(path);
}

class ResultKeysGolden : public testing::Test {
protected:
  /// A line of them, with one blank between two.
  std::string keys_of(const std::string& arguments, int code = 0) {
    const Outcome run = maille_command(arguments);
    EXPECT_EQ(run.code, code) << arguments << run.err;
    std::vector<std::string> keys;
    add_keys(ordered_json::parse(run.out), "", keys);
    return fmt::format("{}", fmt::join(keys, " "));
  }

  const test::TemporaryFolder folder;
  const std::string strip_file = folder.write("strip.toml", strip).string(),
                    world_file = folder.write("world.toml", world).string(),
                    down_file = folder.write("down.toml", down).string();
};

const std::string plausibility =
    "size_m largest_move_m move_over_length mean_strain strain_of_loads warnings";

TEST_F(ResultKeysGolden, OfCheck) {
  EXPECT_EQ(keys_of("check " + strip_file + " --json"),
            "scene faults " + plausibility +
                " parts[].label parts[].voxels parts[].volume_m3 parts[].material conditions[].name "
                "conditions[].nodes conditions[].area_m2 conditions[].share conditions[].where "
                "materials[].name materials[].least_modulus materials[].largest_modulus materials[].density "
                "materials[].fibre maille");
  EXPECT_EQ(keys_of("check " + world_file + " --json"), "scene faults warnings maille");
  EXPECT_EQ(keys_of("check " + world_file + " " + down_file + " --json"), "scene kind faults maille");
  EXPECT_EQ(keys_of("check " + folder.write("bad.toml", "[specimen]\nshape = 1\n").string() + " --json", 2),
            "scene faults[].file faults[].line faults[].key faults[].expected faults[].found maille");
}

TEST_F(ResultKeysGolden, OfExplain) {
  const auto arrays = [](const std::string& holder) {
    const std::string of = " memory." + holder;
    return of + ".bytes" + of + ".arrays[].name" + of + ".arrays[].bytes" + of + ".arrays[].bytes_per_node" +
           of + ".arrays[].why";
  };
  EXPECT_EQ(keys_of("check --why " + strip_file + " --json"),
            "scene dimension shape grid cells nodes links taut_scale_pa " + plausibility +
                " parts[].name parts[].on parts[].why methods[].method methods[].way "
                "methods[].bytes_at_most methods[].seconds limits_route" +
                arrays("scene") + arrays("limits") + arrays("drag") + " maille");
  EXPECT_EQ(keys_of("check --why " + world_file + " --json"),
            "scene dimension cells method parts[].name parts[].on parts[].why objects[].name objects[].kind "
            "objects[].shape objects[].cells objects[].nodes memory.map memory.objects maille");
}

TEST_F(ResultKeysGolden, OfMaterials) {
  EXPECT_EQ(
      keys_of("check muscle/vastus_lateralis --json"),
      "name title state species source uncertainty note verified density_kg_m3 youngs_modulus_pa "
      "poisson_ratio shear_modulus_pa bulk_modulus_pa anisotropy "
      "nearly_incompressible[].bulk_modulus_pa nearly_incompressible[].poisson_ratio stiffness_pa "
      "stiffness_eigenvalues_pa limits.stretch limits.compress limits.shear damage.stretch "
      "damage.compress damage.shear "
      "damage.compress_is_derived damage.shear_is_derived damage.of damage.source damage.verified maille");
}

TEST_F(ResultKeysGolden, OfPlay) {
  EXPECT_EQ(keys_of("play " + world_file + " " + down_file + " --json"),
            "scene trajectory maille dimension cells method frames_asked frame_seconds penetrations "
            "limit_violation bytes objects[].name objects[].kind objects[].cells objects[].position "
            "objects[].rotation frames[].frame frames[].status frames[].seconds frames[].rounds "
            "frames[].handed_on frames[].moved_on frames[].drives[].object frames[].drives[].fraction "
            "frames[].drives[].force frames[].contacts[].object frames[].contacts[].other "
            "frames[].contacts[].voxels frames[].contacts[].force files warnings");
}

TEST_F(ResultKeysGolden, OfProbe) {
  const auto latency = [](const std::string& of) {
    return fmt::format(" {0}.mean_us {0}.p50_us {0}.p99_us {0}.p999_us {0}.largest_us {0}.bins[].from_us "
                       "{0}.bins[].to_us {0}.bins[].count",
                       of);
  };
  const std::string arguments = fmt::format(
      "play {} {} --no-clock", world_file,
      folder.write("motion.csv", "time,x,y,z\n0,0.013,0.01,0.014\n0.1,0.013,0.01,0.01\n").string());
  EXPECT_EQ(keys_of(arguments + " --json"),
            "ticks period_s in_real_time had_priority missed_deadlines tool_voxels deformable_bodies "
            "force.largest_n force.mean_touching_n force.largest_torque_nm force.touching_ticks "
            "bodies.deepest_m bodies.sites bodies.answers bodies.slowest_answer_s passivity.stiffness "
            "passivity.largest_passive_stiffness passivity.least_energy_j passivity.taken_back_j interrupted "
            "penetrations looks" +
                latency("latency") + latency("work") +
                " title maille commit host date command scene_file scene_text explanation");
  const Outcome csv = maille_command(arguments + " --csv -");
  EXPECT_TRUE(csv.out.starts_with("time,hand_x,hand_y,hand_z,proxy_x,proxy_y,proxy_z,force_x,force_y,force_z,"
                                  "body_stiffness,latency_us\n0,0.013,0.01,0.014,0.013,0.01,0.014,0,0,0,"))
      << csv.out.substr(0, 300);
}

TEST_F(ResultKeysGolden, OfChoose) {
  const auto candidate = [](const std::string& of) {
    return fmt::format(" {0}.method {0}.spacing_factor {0}.tolerance {0}.cells {0}.spacing {0}.nodes "
                       "{0}.error.expected {0}.error.low {0}.error.high {0}.seconds.expected "
                       "{0}.seconds.low {0}.seconds.high {0}.bytes",
                       of);
  };
  const std::string asked =
      "scene maille wish.error wish.seconds wish.bytes wish.level wish.of scenes_in_table rests_on "
      "probes.seconds probes.spacing_factor probes.nodes probes.difference";
  std::string probed;
  for (const char* method : {"coupled", "limits", "relaxed"})
    probed += fmt::format(" probes.methods.{0}.model_error probes.methods.{0}.seconds", method);
  EXPECT_EQ(keys_of("study choose " + strip_file + " --error 60% --time 60s --json"),
            asked + probed + candidate("chosen") + " most_exact_in_time quickest_to_error" +
                candidate("candidates[]") + " left_out");
}

} // namespace
} // namespace maille
