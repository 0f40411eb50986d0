#include "fit/fit.hpp"

#include <fmt/format.h>

#include <cctype>

namespace maille::studies {

namespace {

/// Every digit that it takes to read the same number again.
std::string three(const std::array<double, 3>& values) {
  return fmt::format("[{:.17g}, {:.17g}, {:.17g}]", values[0], values[1], values[2]);
}

std::string in_quotes(const std::string& text) {
  std::string quoted = "\"";
  for (const char c : text)
    if (c == '"' || c == '\\')
      quoted += {'\\', c};
    else if (std::iscntrl(static_cast<unsigned char>(c)))
      quoted += fmt::format("\\u{:04x}", static_cast<unsigned char>(c));
    else
      quoted += c;
  return quoted + "\"";
}

std::string rows(const std::array<std::array<double, 3>, 3>& values, int indent) {
  return fmt::format("[{},\n{:{}}{},\n{:{}}{}]", three(values[0]), "", indent, three(values[1]), "", indent,
                     three(values[2]));
}

/// As a table of its own, which has to come last.
std::string damage_table(const Damage& damage, const std::string& header) {
  std::string text = fmt::format("\n[{}]\nstretch         = {}\n", header, three(damage.stretch));
  if (damage.compress)
    text += fmt::format("compress        = {}\n", three(*damage.compress));
  if (damage.shear)
    text += fmt::format("shear           = {}\n", rows(*damage.shear, 19));
  return text + fmt::format("of              = {}\nsource          = {}\nverified        = {}\n",
                            in_quotes(damage.of), in_quotes(damage.source), damage.verified);
}

std::string keys_of(const Material& material) {
  const ElasticConstants& c = material.elasticity;
  std::string text = fmt::format("name            = {}\ndensity         = {:.17g}\n",
                                 in_quotes(material.name), material.density);
  text += fmt::format("E               = {}\nnu              = {}\nG               = {}\n",
                      three(c.youngs_modulus), three({c.nu12, c.nu13, c.nu23}), three({c.G12, c.G13, c.G23}));
  if (const auto& limits = material.limits)
    text += fmt::format("stretch         = {}\ncompress        = {}\nshear           = {}\n",
                        three(limits->stretch), three(limits->compress), rows(limits->shear, 19));
  if (material.relaxed_weights != std::array<double, 3>{1, 1, 1})
    text += fmt::format("relaxed_weights = {}\n", three(material.relaxed_weights));
  return text;
}

} // namespace

std::string material_file(const Fit& fit, const std::vector<std::string>& notes) {
  std::string text;
  for (const std::string& note : notes)
    text += "# " + note + "\n";
  const bool is_one = fit.materials.size() == 1;
  for (const Material& material : fit.materials) {
    const std::string header = in_quotes(material.name);
    text += (is_one ? "" : "\n[" + header + "]\n") + keys_of(material);
    if (material.damage)
      text += damage_table(*material.damage, is_one ? "damage" : header + ".damage");
  }
  return text;
}

} // namespace maille::studies
