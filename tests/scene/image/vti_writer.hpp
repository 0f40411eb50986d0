#pragma once
/// A small writer of .vti files in all encodings, for the tests of the reader.

#include "scene/image/image_writers.hpp"

namespace maille::image_tests {

struct VtiArray {
  std::string type{};
  std::string name = "Labels";
  int components = 1;
  std::string text{};  ///< the values as numbers, for ascii
  std::string bytes{}; ///< the values as bytes, for the others
};

struct VtiFile {
  std::string grid{};           ///< attributes of ImageData
  std::string encoding = "raw"; ///< ascii, binary, raw (appended), base64 (appended)
  bool is_compressed = false;
  bool has_wide_header = false;
  bool is_big_endian = false;
  std::size_t block_bytes = 32768;
  bool has_cell_data = true;
  std::string attributes{}; ///< of CellData or PointData
  std::vector<VtiArray> field_arrays{};
  std::vector<VtiArray> arrays{};

  std::string bytes_of_file() const {
    std::string appended;
    std::string text = R"(<?xml version="1.0"?><VTKFile type="ImageData" version="1.0" byte_order=")" +
                       std::string(is_big_endian ? "BigEndian" : "LittleEndian") + R"(" header_type=")" +
                       (has_wide_header ? "UInt64" : "UInt32") + '"' +
                       (is_compressed ? R"( compressor="vtkZLibDataCompressor")" : "") + "><ImageData " +
                       grid + "><FieldData>";
    for (const VtiArray& array : field_arrays)
      text += element(array, appended);
    const std::string extent = grid.substr(std::string("Whole").size(), grid.find('"', 13) + 1 - 5);
    const std::string section = has_cell_data ? "CellData" : "PointData";
    text += "</FieldData><Piece " + extent + "><" + section + ' ' + attributes + '>';
    for (const VtiArray& array : arrays)
      text += element(array, appended);
    text += "</" + section + "></Piece></ImageData>";
    if (!appended.empty())
      text += "<AppendedData encoding=\"" + encoding + "\">\n   _" + appended + "\n</AppendedData>";
    return text + "</VTKFile>\n";
  }

private:
  std::string count(std::size_t value) const {
    return has_wide_header ? image_tests::bytes_of(static_cast<std::uint64_t>(value), is_big_endian)
                           : image_tests::bytes_of(static_cast<std::uint32_t>(value), is_big_endian);
  }

  /// The header and the data; VTK encodes them in base64 apart from each other if they are compressed.
  std::string encoded(const std::string& bytes, bool is_base64) const {
    if (!is_compressed)
      return is_base64 ? base64(count(bytes.size()) + bytes) : count(bytes.size()) + bytes;
    const std::size_t n_blocks = (bytes.size() + block_bytes - 1) / block_bytes;
    std::string header = count(n_blocks) + count(block_bytes) + count(bytes.size() % block_bytes);
    std::string blocks;
    for (std::size_t block = 0; block < n_blocks; ++block) {
      const std::string part = deflated(bytes.substr(block * block_bytes, block_bytes), false);
      header += count(part.size());
      blocks += part;
    }
    return is_base64 ? base64(header) + base64(blocks) : header + blocks;
  }

  std::string element(const VtiArray& array, std::string& appended) const {
    const bool is_text = array.type == "String";
    const std::string tag = is_text ? "Array" : "DataArray";
    std::string text =
        "<" + tag + " type=\"" + array.type + "\" Name=\"" + array.name + "\" " +
        (is_text ? "NumberOfTuples=\"1\"" : "NumberOfComponents=\"" + std::to_string(array.components) + '"');
    if (encoding == "ascii")
      return text + " format=\"ascii\">\n" + array.text + "\n</" + tag + '>';
    if (encoding == "binary")
      return text + " format=\"binary\">\n  " + encoded(array.bytes, true) + "\n</" + tag + '>';
    text += " format=\"appended\" offset=\"" + std::to_string(appended.size()) + "\"/>";
    appended += encoded(array.bytes, encoding == "base64");
    return text;
  }
};

} // namespace maille::image_tests
