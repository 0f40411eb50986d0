#pragma once
/// The arrays of a .vti file as bytes, however they are encoded. Private to scene.

#include "image/image_formats.hpp"

#include <pugixml.hpp>

namespace maille::image_formats {

/// A .vti file cut in two: its XML, parsed, and where its appended data lies.
struct VtiFile {
  std::filesystem::path file;
  std::string text; ///< the document points into it
  pugi::xml_document document;
  std::int64_t appended_from = 0; ///< byte after the underscore; 0: none
  bool is_appended_raw = false;   ///< else base64
  bool swap_bytes = false;
  bool has_wide_header = false; ///< UInt64 counts, else UInt32
  bool is_compressed = false;
  bool is_lz4 = false; ///< else zlib, where compressed
};

std::optional<ScalarType> vti_scalar_type(std::string_view name);

/// A name for messages.
std::string vti_array_name(pugi::xml_node array);

/// Adds a fault if the array's format or offset is not one that we can read.
void check_vti_array(const VtiFile& vti, pugi::xml_node array, Faults& faults);

/// The decoded bytes of one array.
/// @param bytes that the array has to hold; nothing: whatever it says
/// @throws InputError: another size, a damaged encoding
ByteSourcePtr open_vti_array(const std::shared_ptr<VtiFile>& vti, pugi::xml_node array, ScalarType type,
                             std::optional<std::int64_t> bytes, Faults& faults);

} // namespace maille::image_formats
