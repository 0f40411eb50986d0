# deal.II as an imported target of our own. Its deal_ii_setup_target uses the keyword-less link form, which
# clashes with PRIVATE/PUBLIC, and pushes -std=c++17 and its own warning flags on users.
find_package(deal.II 9.4 REQUIRED)
include(${DEAL_II_TARGET_CONFIG})
add_library(maille_deal_ii INTERFACE)
target_link_libraries(maille_deal_ii INTERFACE
  $<IF:$<CONFIG:Debug>,${DEAL_II_TARGET_DEBUG},${DEAL_II_TARGET_RELEASE}>)
target_include_directories(maille_deal_ii SYSTEM INTERFACE ${DEAL_II_INCLUDE_DIRS})
target_compile_definitions(maille_deal_ii INTERFACE BOOST_NO_AUTO_PTR $<$<CONFIG:Debug>:DEBUG>)
