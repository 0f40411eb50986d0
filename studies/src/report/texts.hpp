#pragma once
/// The files of this folder that pages are made with, compiled in (see cmake/embed_texts.cmake).

#include <string_view>

namespace maille::studies {

std::string_view page_html();
std::string_view figure_html();
std::string_view table_html();
std::string_view style_css();
std::string_view sort_js();

} // namespace maille::studies
