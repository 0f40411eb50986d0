#include "maille/studies/fit.hpp"

#include <fmt/format.h>

namespace maille::studies {

namespace {

/// Every digit that it takes to read the same number again.
std::string three(const std::array<double, 3>& values) {
  return fmt::format("[{:.17g}, {:.17g}, {:.17g}]", values[0], values[1], values[2]);
}

std::string in_quotes(const std::string& text) {
  std::string quoted = "\"";
  for (const char c : text)
    quoted += c == '"' || c == '\\' ? std::string{'\\', c} : std::string(1, c);
  return quoted + "\"";
}

} // namespace

std::string material_file(const Fit& fit, const std::vector<std::string>& notes) {
  std::string text;
  for (const std::string& note : notes)
    text += "# " + note + "\n";
  const Material& material = fit.material;
  const ElasticConstants& c = material.elasticity;
  text += fmt::format("name            = {}\ndensity         = {:.17g}\n", in_quotes(material.name),
                      material.density);
  text += fmt::format("E               = {}\nnu              = {}\nG               = {}\n",
                      three(c.youngs_modulus), three({c.nu12, c.nu13, c.nu23}), three({c.G12, c.G13, c.G23}));
  if (const auto& limits = material.limits)
    text += fmt::format(
        "stretch         = {}\ncompress        = {}\nshear           = [{},\n{:19}{},\n{:19}{}]\n",
        three(limits->stretch), three(limits->compress), three(limits->shear[0]), "", three(limits->shear[1]),
        "", three(limits->shear[2]));
  if (material.relaxed_weights != std::array<double, 3>{1, 1, 1})
    text += fmt::format("relaxed_weights = {}\n", three(material.relaxed_weights));
  return text;
}

} // namespace maille::studies
