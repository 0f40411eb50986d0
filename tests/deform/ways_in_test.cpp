// The ways to ask: a file or a builder, a name or an enumeration. Truth: the other way, to the bit.

#include "maille/deform/solve.hpp"

#include "support/label_scene.hpp"

#include <gtest/gtest.h>

namespace maille::deform {
namespace {

void expect_same_answers(const Scene& a, const Scene& b) {
  for (const Method method : every_method) {
    const Answer one = solve(a, method), other = solve(b, to_string(method));
    EXPECT_EQ(one.status, other.status) << to_string(method);
    EXPECT_EQ(one.displacement, other.displacement) << to_string(method);
    EXPECT_EQ(one.reaction, other.reaction) << to_string(method);
    EXPECT_EQ(one.method, to_string(method));
  }
}

TEST(WaysInOracle, ABuiltBoxIsAnsweredAsItsText) {
  const Scene by_text = parse_scene(R"(units = "m"
[specimen]
shape = "box"
cells = [6, 4, 3]
spacing = 0.001
material = "muscle/soleus"
fibre = [1, 1, 0]
[[hold]]
where = "x-"
[[move]]
where = "x+"
by = [0.0003, 0.0001, 0]
)");
  const Scene built = SceneBuilder()
                          .box(3, {6, 4, 3}, {1e-3, 1e-3, 1e-3})
                          .material("muscle/soleus")
                          .fibre({1, 1, 0})
                          .hold("x-")
                          .move("x+", {3e-4, 1e-4, 0})
                          .build();
  EXPECT_EQ(solve(built, Method::coupled).status, Status::done);
  expect_same_answers(built, by_text);
}

TEST(WaysInOracle, ABuiltLabelArrayIsAnsweredAsItsImage) {
  const image_tests::TemporaryFolder folder;
  const auto array = turned(test::bent_body(), {{2, 0, 1}, {true, false, true}});
  const auto memory = test::stored<std::int32_t>(array, {{1, 2, 0}, {false, true, true}});
  const Scene built = test::label_scene().labels(memory.elements, memory.layout, array.affine).build();
  EXPECT_EQ(solve(built, Method::coupled).status, Status::done);
  expect_same_answers(built, test::label_scene_by_file(folder, array));
}

TEST(WaysInContract, MethodsOfOtherModulesAreRefusedByName) {
  const Scene scene =
      SceneBuilder().box(1, {4, 1, 1}, {1, 1, 1}).material("muscle/soleus").hold("x-").build();
  std::vector<std::string_view> here;
  for (const Method method : every_method)
    if (bytes_needed(scene, method) > 0)
      here.push_back(to_string(method));
  EXPECT_EQ(here, methods());
  for (const Method method : {Method::fem_q1, Method::fem_q2, Method::calculix}) {
    const Answer answer = solve(scene, method);
    EXPECT_EQ(answer.status, Status::refused);
    EXPECT_NE(answer.message.find(to_string(method)), std::string::npos) << answer.message;
  }
}

} // namespace
} // namespace maille::deform
