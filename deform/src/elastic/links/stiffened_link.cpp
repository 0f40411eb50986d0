#include "elastic/links/stiffened_link.hpp"

#include <algorithm>
#include <tuple>

namespace maille::deform {

std::vector<StiffenedLink> merged(std::vector<StiffenedLink> links) {
  const auto place = [](const StiffenedLink& link) {
    return std::tuple(link.component, link.axis, link.node);
  };
  std::ranges::stable_sort(links, {}, place);
  std::size_t n = 0;
  for (std::size_t i = 0; i < links.size(); ++i)
    if (n > 0 && place(links[n - 1]) == place(links[i]))
      links[n - 1].stiffness += links[i].stiffness;
    else
      links[n++] = links[i];
  links.resize(n);
  return links;
}

} // namespace maille::deform
