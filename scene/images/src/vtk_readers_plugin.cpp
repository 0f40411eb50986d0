// The shared object maille-vtk-readers.so: reads VTK's XML files by VTK's readers, in a separate process.

#include "apart.hpp"
#include "plugin_readers.hpp"

#include <vtkCallbackCommand.h>
#include <vtkCellData.h>
#include <vtkDataArray.h>
#include <vtkDataArraySelection.h>
#include <vtkFieldData.h>
#include <vtkImageData.h>
#include <vtkInformation.h>
#include <vtkNew.h>
#include <vtkObjectFactory.h>
#include <vtkPointData.h>
#include <vtkStreamingDemandDrivenPipeline.h>
#include <vtkStringArray.h>
#include <vtkUnstructuredGrid.h>
#include <vtkXMLDataElement.h>
#include <vtkXMLDataParser.h>
#include <vtkXMLImageDataReader.h>
#include <vtkXMLUnstructuredGridReader.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fstream>
#include <sstream>
#include <string_view>

namespace {

using namespace maille::image_formats;
using maille::VtkArrays;

constexpr std::uint64_t memory = std::uint64_t{64} << 20;

/// VTK's reader with access to the original header, because VTK replaces unreadable numbers by defaults.
/// Detects data that end early or continue after the last value, which VTK ignores.
class ImageReader : public vtkXMLImageDataReader {
public:
  static ImageReader* New();
  std::string header;
  /// The array to read: its section, and its expected number of values; 0 until known.
  const char* section = "";
  std::string name;
  std::int64_t n_values = 0;

protected:
  int ReadPrimaryElement(vtkXMLDataElement* grid) override {
    for (int p = 0; p < grid->GetNumberOfNestedElements(); ++p)
      for (const char* of : {"CellData", "PointData"})
        if (vtkXMLDataElement* const data = grid->GetNestedElement(p)->FindNestedElementWithName(of))
          for (int a = 0; a < data->GetNumberOfNestedElements(); ++a)
            if (data->GetNestedElement(a)->GetAttribute("Name") == nullptr) // VTK would skip it
              data->GetNestedElement(a)->SetAttribute("Name", "unnamed");
    std::ostringstream text;
    grid->PrintXML(text, vtkIndent());
    header = text.str();
    piece_ = grid->FindNestedElementWithName("Piece");
    return vtkXMLImageDataReader::ReadPrimaryElement(grid);
  }
  void ReadXMLData() override {
    vtkXMLImageDataReader::ReadXMLData();
    if (n_values == 0 || DataError != 0)
      return;
    vtkXMLDataElement* const array =
        piece_->FindNestedElementWithName(section)->FindNestedElementWithNameAndAttribute("DataArray", "Name",
                                                                                          name.c_str());
    if (const std::string last = value(array, n_values - 1, '\0');
        last.empty() || last != value(array, n_values - 1, '\x55'))
      vtkErrorMacro("data that end before the last of " << n_values << " values");
    if (!value(array, n_values, '\0').empty())
      vtkErrorMacro("data that go on behind the last of " << n_values << " values");
  }

private:
  /// A value as bytes; `filler` if the file has none; empty if VTK detects the end.
  std::string value(vtkXMLDataElement* array, std::int64_t at, char filler) {
    vtkTypeInt64 offset = 0;
    int type = VTK_VOID;
    array->GetWordTypeAttribute("type", type);
    std::string bytes;
    bytes.resize(vtkAbstractArray::GetDataTypeSize(type), filler);
    const char* const format = array->GetAttribute("format");
    const bool is_appended = array->GetScalarAttribute("offset", offset) != 0;
    const int is_text = format == nullptr || std::string_view(format) != "binary" ? 1 : 0;
    const std::size_t n = is_appended ? XMLParser->ReadAppendedData(offset, bytes.data(), at, 1, type)
                                      : XMLParser->ReadInlineData(array, is_text, bytes.data(), at, 1, type);
    return n == 1 ? bytes : std::string();
  }
  vtkXMLDataElement* piece_ = nullptr;
};
vtkStandardNewMacro(ImageReader);

/// A reader and its first error message.
template<class Reader>
class Watched {
public:
  explicit Watched(const std::string& file) {
    observer_->SetClientData(&fault);
    observer_->SetCallback([](vtkObject* /*who*/, unsigned long /*event*/, void* first, void* said) {
      std::string text(static_cast<const char*>(said));
      const std::size_t begin = text.find("): "); // after the location in VTK's sources
      text.erase(0, begin == std::string::npos ? 0 : begin + 3);
      text.erase(text.find_last_not_of(" \n") + 1);
      std::replace(text.begin(), text.end(), '\n', ' ');
      if (static_cast<std::string*>(first)->empty())
        *static_cast<std::string*>(first) = text.empty() ? "a file that VTK refuses" : text;
    });
    reader->AddObserver(vtkCommand::ErrorEvent, observer_);
    reader->SetReaderErrorObserver(observer_);
    reader->SetParserErrorObserver(observer_);
    reader->SetFileName(file.c_str());
    reader->UpdateInformation();
    reader->GetCellDataArraySelection()->DisableAllArrays();
    reader->GetPointDataArraySelection()->DisableAllArrays();
  }
  vtkNew<Reader> reader;
  std::string fault;

private:
  vtkNew<vtkCallbackCommand> observer_;
};

std::string units_of(vtkDataObject* grid) {
  auto* const units = vtkStringArray::SafeDownCast(grid->GetFieldData()->GetAbstractArray("Units"));
  return units != nullptr && units->GetNumberOfValues() > 0 ? units->GetValue(0) : std::string();
}

std::string header(const std::string& file, std::string& xml, std::string& units) {
  const Apart child([&](const Pipe& pipe) {
    bound_memory_and_time(file, memory);
    Watched<ImageReader> of(file);
    if (of.fault.empty() && of.reader->header.find("<FieldData") != std::string::npos)
      of.reader->Update();
    pipe.put_text(of.fault);
    pipe.put_text(of.reader->header);
    pipe.put_text(of.fault.empty() ? units_of(of.reader->GetOutput()) : "");
  });
  std::string fault;
  return child.pipe.take_text(fault) && child.pipe.take_text(xml) && child.pipe.take_text(units) ? fault
                                                                                                 : too_much;
}

/// The first word in a text array that its type cannot represent: VTK accepts 256 and 6.5 for UInt8. Empty if
/// all are valid, or if the array is not text.
std::string wrong_word(const std::string& file, const std::string& section, const std::string& name,
                       vtkDataArray& array) {
  const int type = array.GetDataType();
  if (type == VTK_FLOAT || type == VTK_DOUBLE)
    return {};
  std::ifstream stream(file, std::ios::binary);
  const std::string text((std::istreambuf_iterator<char>(stream)), {});
  const std::string wanted = "Name=\"" + name + "\"";
  for (std::size_t at = text.find("<DataArray", text.find("<" + section)); at != std::string::npos;
       at = text.find("<DataArray", at + 1)) {
    const std::size_t end = std::min(text.find('>', at), text.size() - 1);
    const std::string_view element = std::string_view(text).substr(at, end - at);
    if (element.find(wanted) == std::string_view::npos || element.find("\"ascii\"") == std::string_view::npos)
      continue;
    std::istringstream words(text.substr(end + 1, text.find('<', end) - end - 1));
    for (std::string word; words >> word;) {
      double number = 0;
      const auto [last, error] = std::from_chars(word.data(), word.data() + word.size(), number);
      if (error != std::errc() || last != word.data() + word.size() || number != std::floor(number) ||
          number < array.GetDataTypeMin() || number > array.GetDataTypeMax())
        return word;
    }
    return {};
  }
  return {};
}

/// Values that a separate process reads, some layers at a time.
class Values {
public:
  Values(const std::string& file, bool of_cells, const std::string& name, std::int64_t n_values)
      : child_([&](const Pipe& pipe) { put_values(pipe, file, of_cells, name, n_values); }) {}
  std::string read(std::span<char> to) {
    while (!to.empty()) {
      std::string fault;
      if (left_ == 0 && !child_.pipe.take_text(fault))
        return too_much;
      if (!fault.empty())
        return fault;
      if (left_ == 0 && !child_.pipe.take(&left_, sizeof left_))
        return too_much;
      const std::size_t count = std::min(left_, to.size());
      if (!child_.pipe.take(to.data(), count))
        return too_much;
      left_ -= count;
      to = to.subspan(count);
    }
    return {};
  }

private:
  static void put_values(const Pipe& pipe, const std::string& file, bool of_cells, const std::string& name,
                         std::int64_t n_values) {
    bound_memory_and_time(file, memory);
    Watched<ImageReader> of(file);
    of.reader->section = of_cells ? "CellData" : "PointData";
    of.reader->name = name;
    (of_cells ? of.reader->GetCellDataArraySelection() : of.reader->GetPointDataArraySelection())
        ->EnableArray(name.c_str());
    std::array<int, 6> extent{};
    of.reader->GetOutputInformation(0)->Get(vtkStreamingDemandDrivenPipeline::WHOLE_EXTENT(), extent.data());
    const int last = extent[5], shared = of_cells && extent[4] < last ? 1 : 0; // layers of cells share points
    constexpr std::int64_t most_points = 1 << 21;
    const std::int64_t layer =
        (std::int64_t{1} + extent[1] - extent[0]) * (std::int64_t{1} + extent[3] - extent[2]);
    const int layers = static_cast<int>(std::max<std::int64_t>(1, most_points / layer));
    const int first_layer = extent[4];
    const bool is_text = of.reader->header.find("\"ascii\"") != std::string::npos;
    for (int first = extent[4]; first <= last - shared; first = extent[5] + 1 - shared) {
      extent[4] = first;
      extent[5] = first + std::min(last - first, layers - 1 + shared);
      of.reader->n_values = extent[5] == last ? n_values : 0;
      static_cast<vtkAlgorithm&>(*of.reader).UpdateExtent(extent.data());
      vtkImageData* const image = of.reader->GetOutput();
      vtkDataSetAttributes* const data =
          of_cells ? static_cast<vtkDataSetAttributes*>(image->GetCellData()) : image->GetPointData();
      vtkDataArray* const array = data->GetArray(name.c_str());
      if (of.fault.empty() && array == nullptr)
        of.fault = "no such array";
      if (of.fault.empty() && extent[4] == first_layer && is_text)
        if (const std::string word = wrong_word(file, of.reader->section, name, *array); !word.empty())
          of.fault = "\"" + word + "\" in an array of " + array->GetDataTypeAsString();
      pipe.put_text(of.fault);
      if (!of.fault.empty())
        return;
      const std::size_t bytes = array->GetDataSize() * array->GetDataTypeSize();
      pipe.put(&bytes, sizeof bytes);
      pipe.put(array->GetVoidPointer(0), bytes);
    }
  }
  Apart child_;
  std::size_t left_ = 0; ///< remaining bytes of the current layers
};

std::function<std::string(std::span<char>)> values(const std::string& file, bool of_cells,
                                                   const std::string& name, std::int64_t n_values) {
  return [all = std::make_shared<Values>(file, of_cells, name, n_values)](std::span<char> to) {
    return all->read(to);
  };
}

std::string text_of(vtkDataArray* array) {
  std::vector<double> numbers;
  for (vtkIdType i = 0; array != nullptr && i < array->GetNumberOfValues(); ++i)
    numbers.push_back(array->GetVariantValue(i).ToDouble());
  return {reinterpret_cast<const char*>(numbers.data()), numbers.size() * sizeof(double)};
}

template<class Reader>
void put_arrays(const Pipe& pipe, const std::string& file, const std::vector<std::string>& names) {
  Watched<Reader> of(file);
  for (const std::string& name : names)
    if (of.reader->GetPointDataArraySelection()->ArrayExists(name.c_str()) != 0)
      of.reader->GetPointDataArraySelection()->EnableArray(name.c_str());
  if (of.fault.empty())
    of.reader->Update();
  pipe.put_text(of.fault);
  const vtkIdType points = of.reader->GetOutput()->GetNumberOfPoints();
  pipe.put(&points, sizeof points);
  for (const std::string& name : names)
    pipe.put_text(text_of(of.reader->GetOutput()->GetPointData()->GetArray(name.c_str())));
  pipe.put_text(text_of(of.reader->GetOutput()->GetFieldData()->GetArray("Layers")));
  pipe.put_text(units_of(of.reader->GetOutput()));
}

std::string arrays(const std::string& file, const std::vector<std::string>& names, std::int64_t nodes,
                   VtkArrays& all) {
  constexpr std::uint64_t a_node = 600; // arrays, points, cells
  const Apart child([&](const Pipe& pipe) {
    bound_memory_and_time(file, memory + a_node * static_cast<std::uint64_t>(nodes));
    vtkNew<vtkXMLImageDataReader> image;
    image->CanReadFile(file.c_str()) != 0 ? put_arrays<vtkXMLImageDataReader>(pipe, file, names)
                                          : put_arrays<vtkXMLUnstructuredGridReader>(pipe, file, names);
  });
  std::string fault;
  bool is_there = child.pipe.take_text(fault) && child.pipe.take(&all.points, sizeof all.points);
  const auto numbers = [&] {
    std::string bytes;
    is_there = is_there && child.pipe.take_text(bytes);
    std::vector<double> found(bytes.size() / sizeof(double));
    std::copy_n(bytes.data(), bytes.size(), reinterpret_cast<char*>(found.data()));
    return found;
  };
  for (const std::string& name : names)
    all.at_nodes[name] = numbers();
  all.layers = numbers();
  is_there = is_there && child.pipe.take_text(all.units);
  return is_there ? fault : too_much;
}

constexpr VtkReaders functions{.header = header, .values = values, .arrays = arrays};

} // namespace

extern "C" const void* maille_plugin(std::size_t layout, const void* host);

extern "C" const void* maille_plugin(std::size_t layout, const void* /*host*/) {
  return layout == vtk_readers_layout ? &functions : nullptr;
}
