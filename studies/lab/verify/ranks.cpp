#include "maille/fem_ref/ranks.hpp"
#include "maille/fem_ref/solve.hpp"
#include "maille/scene/answer.hpp"
#include "program.hpp"
#include "verify/problems.hpp"

#include <algorithm>
#include <cstdio>
#include <limits>

namespace maille::lab {

double worst_difference_between_ranks() {
  const std::string
      box = "[specimen]\nshape = \"box\"\nspacing = [\"1 mm\", \"0.8 mm\", \"1.1 mm\"]\ncells = [12, 8, 10]\n"
            "material = { E = [\"50 kPa\", \"20 kPa\", \"10 kPa\"], nu = [0.3, 0.25, 0.35], "
            "G = [\"12 kPa\", \"9 kPa\", \"5 kPa\"] }\nfibre = [0.8, 0.5, 0.3]\n[[hold]]\nwhere = \"x-\"\n"
            "[[load]]\nwhere = \"x+\"\ntraction = [\"1 kPa\", \"0.3 kPa\", 0]\n",
      muscle = "[specimen]\nshape = \"muscle\"\ncells = [16, 6, 6]\nspacing = \"4 mm\"\nmaterial = "
               "\"muscle/soleus\"\n"
               "tendon = { material = \"tendon/tibialis_anterior\", fraction = 0.15 }\n[[hold]]\nwhere = "
               "\"x-\"\n[[move]]\nwhere = \"x+\"\nby = [\"2 "
               "mm\", 0, 0]\n";
  double worst = 0;
  for (const std::string& text : {box, muscle})
    for (const int degree : {1, 2}) {
      const Scene scene = Verification::scene(text);
      fem_ref::Options together, alone;
      together.degree = alone.degree = degree;
      together.tolerance = alone.tolerance =
          1e-12; // between muscle and tendon errors are some thousand residuals
      alone.shape = [](const Vec3& x) { return x; }; // what has a shape every rank solves whole
      const Answer ours = fem_ref::solve(scene, together).answer, whole = fem_ref::solve(scene, alone).answer;
      if (!is_converged(ours.status) || !is_converged(whole.status))
        return std::numeric_limits<double>::infinity();
      worst = std::max(worst, compare(scene, ours.displacement, whole.displacement).relative_max);
    }
  return worst;
}

std::optional<double> difference_of_two_ranks(const std::filesystem::path& program) {
  if (!has_program("mpirun"))
    return std::nullopt;
  // Open MPI asks root to say twice that it is meant.
  const std::string line =
      "OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1 mpirun --oversubscribe -n 2 " +
      shell_word(program.string()) + " verify --ranks 2> /dev/null";
  FILE* const printed = popen(line.c_str(), "r");
  double found = 0;
  const bool is_found = printed && std::fscanf(printed, "%lf", &found) == 1;
  return printed && pclose(printed) == 0 && is_found ? std::optional(found) : std::nullopt;
}

} // namespace maille::lab
