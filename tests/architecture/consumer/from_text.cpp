#include <maille/deform/solve.hpp>
#include <maille/scene/read_scene.hpp>

#include <cstdio>

int main() {
  const maille::Scene scene = maille::parse_scene(R"([specimen]
shape    = "box"
cells    = [32, 8, 8]
spacing  = "1 mm"
material = { youngs_modulus = "10 kPa", poisson_ratio = 0.3 }
[[hold]]
where = "x-"
[[move]]
where = "x+"
by    = ["2 mm", 0, 0])");
  const maille::Answer answer = maille::deform::solve(scene, maille::Method::coupled);
  const auto middle = scene.specimen.grid.node({16, 4, 4});
  std::printf("%s: %s, %.3f mm\n", answer.method.c_str(), maille::to_string(answer.status).data(),
              1e3 * answer.displacement(0, middle));
  return maille::is_converged(answer.status) ? 0 : 1;
}
