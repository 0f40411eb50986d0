#include "maille/plugins/open_plugin.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <dlfcn.h>
#include <filesystem>
#include <link.h>
#include <memory>
#include <stdexcept>
#include <system_error>

namespace maille {
namespace {

using Entry = const void* (*)(std::size_t layout, const void* host);

/// Handle of the program or shared object that contains this code.
void* own_handle() {
  static const int here = 0;
  Dl_info info{};
  void* map = nullptr;
  if (dladdr1(&here, &info, &map, RTLD_DL_LINKMAP) == 0)
    return nullptr;
  const char* const name = static_cast<link_map*>(map)->l_name;
  return dlopen(*name == '\0' ? nullptr : name, RTLD_LAZY | RTLD_NOLOAD);
}

[[noreturn]] void refuse(const char* file, const char* what, const std::string& why) {
  throw std::runtime_error(fmt::format("{} need {}, {}", what, file, why));
}

} // namespace

std::vector<std::string> plugin_folders() {
  void* const own = own_handle();
  Dl_serinfo size{};
  if (own == nullptr || dlinfo(own, RTLD_DI_SERINFOSIZE, &size) != 0)
    return {};
  const std::unique_ptr<std::byte[]> memory(new std::byte[size.dls_size]);
  auto* const all = reinterpret_cast<Dl_serinfo*>(memory.get());
  dlinfo(own, RTLD_DI_SERINFOSIZE, all);
  if (dlinfo(own, RTLD_DI_SERINFO, all) != 0)
    return {};
  std::vector<std::string> folders;
  const Dl_serpath* const first = &all->dls_serpath[0];
  for (unsigned i = 0; i < all->dls_cnt; ++i) {
    const std::string folder = first[i].dls_name;
    // A relative entry means the current folder, which may hold foreign files.
    if (folder.starts_with('/') && std::ranges::find(folders, folder) == folders.end())
      folders.push_back(folder);
  }
  return folders;
}

const void* open_plugin(const char* file, const char* what, std::size_t layout, const void* host) {
  // Found by ourselves: a sanitizer that stands before dlopen would have it look where its own libraries are.
  const std::vector<std::string> folders = plugin_folders();
  std::error_code none;
  const auto folder = std::ranges::find_if(
      folders, [&](const std::string& at) { return std::filesystem::exists(at + "/" + file, none); });
  if (folder == folders.end())
    refuse(file, what, fmt::format("which is in none of {}", fmt::join(folders, ", ")));
  // What its libraries define must be seen by those that they open in turn: MPI's components, OpenGL's.
  void* const opened = dlopen((*folder + "/" + file).c_str(), RTLD_LAZY | RTLD_GLOBAL);
  if (opened == nullptr)
    refuse(file, what, fmt::format("which cannot be opened: {}", dlerror()));
  const auto entry = reinterpret_cast<Entry>(dlsym(opened, "maille_plugin"));
  const void* const functions = entry == nullptr ? nullptr : entry(layout, host);
  if (functions == nullptr)
    refuse(file, what, fmt::format("and {}/{} is of another build of Maille", *folder, file));
  return functions;
}

} // namespace maille
