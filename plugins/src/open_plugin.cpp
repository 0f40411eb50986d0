#include "maille/plugins/open_plugin.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <dlfcn.h>
#include <filesystem>
#include <fstream>
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

[[noreturn]] void refuse(const char* file, const std::string& needs, const std::string& why) {
  throw std::runtime_error(fmt::format("{} {}, {}", needs, file, why));
}

/// True if all sections and segments end within the file.
bool is_whole(const std::string& file) {
  std::ifstream stream(file, std::ios::binary);
  ElfW(Ehdr) head{};
  stream.read(reinterpret_cast<char*>(&head), sizeof head);
  if (head.e_ident[0] == '#') // a script
    return true;
  std::vector<ElfW(Phdr)> segments(head.e_phnum);
  stream.seekg(static_cast<std::streamoff>(head.e_phoff));
  stream.read(reinterpret_cast<char*>(segments.data()),
              static_cast<std::streamsize>(segments.size() * sizeof segments[0]));
  std::error_code none;
  const std::uint64_t size = std::filesystem::file_size(file, none);
  return stream && head.e_shoff + std::uint64_t{head.e_shentsize} * head.e_shnum <= size &&
         std::ranges::all_of(segments,
                             [&](const ElfW(Phdr) & one) { return one.p_offset + one.p_filesz <= size; });
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
    // Skips relative entries: the current folder may contain foreign files.
    if (folder.starts_with('/') && std::ranges::find(folders, folder) == folders.end())
      folders.push_back(folder);
  }
  return folders;
}

bool has_plugin(const char* file) {
  std::error_code none;
  return std::ranges::any_of(plugin_folders(), [&](const std::string& folder) {
    return std::filesystem::exists(folder + "/" + file, none);
  });
}

std::string find_plugin(const char* file, const std::string& needs, const char* advice) {
  const std::vector<std::string> folders = plugin_folders();
  std::error_code none;
  const auto folder = std::ranges::find_if(
      folders, [&](const std::string& at) { return std::filesystem::exists(at + "/" + file, none); });
  if (folder == folders.end())
    refuse(file, needs, fmt::format("which is in none of {}{}", fmt::join(folders, ", "), advice));
  std::string path = *folder + "/" + file;
  if (!is_whole(path))
    refuse(file, needs, fmt::format("and {} is cut short: install it again", path));
  return path;
}

const void* open_plugin(const char* file, const char* what, std::size_t layout, const void* host) {
  // Searches without dlopen: a sanitizer that intercepts it would search the sanitizer's library path.
  const std::string needs = std::string(what) + " need", path = find_plugin(file, needs);
  // RTLD_GLOBAL: its libraries load components that need their symbols (MPI, OpenGL).
  void* const opened = dlopen(path.c_str(), RTLD_LAZY | RTLD_GLOBAL);
  if (opened == nullptr)
    refuse(file, needs, fmt::format("which cannot be opened: {}", dlerror()));
  const auto entry = reinterpret_cast<Entry>(dlsym(opened, "maille_plugin"));
  const void* const functions = entry == nullptr ? nullptr : entry(layout, host);
  if (functions == nullptr)
    refuse(file, needs, fmt::format("and {} is of another build of Maille", path));
  return functions;
}

} // namespace maille
