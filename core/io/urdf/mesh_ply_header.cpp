#include "core/io/urdf/mesh_ply_header.h"

#include <array>
#include <utility>

#include "core/base/system/printable.h"
#include "core/io/urdf/mesh_tokenizer.h"

namespace skybody {
namespace {

constexpr std::array<PlyType, 8> kTypes = {{{"char", "int8", 1, PlyType::kSigned},
                                            {"uchar", "uint8", 1, PlyType::kUnsigned},
                                            {"short", "int16", 2, PlyType::kSigned},
                                            {"ushort", "uint16", 2, PlyType::kUnsigned},
                                            {"int", "int32", 4, PlyType::kSigned},
                                            {"uint", "uint32", 4, PlyType::kUnsigned},
                                            {"float", "float32", 4, PlyType::kReal},
                                            {"double", "float64", 8, PlyType::kReal}}};

class HeaderReader {
 public:
  explicit HeaderReader(const std::string& bytes) : bytes_(bytes), words_(bytes) {}

  PlyHeader read() {
    if (words_.next_in_line() != "ply") words_.refuse("`ply` is missing");
    expect_line();
    read_format();
    for (std::string_view keyword;;) {
      expect_line();
      keyword = words_.next_in_line();
      if (keyword == "end_header") break;
      take(keyword);
    }
    words_.next_line();
    header_.size = words_.place();
    header_.lines = words_.line() - 1;
    for (const PlyElement& element : header_.elements) check_size(element);
    return std::move(header_);
  }

 private:
  void expect_line() {
    if (!words_.next_line()) words_.refuse("`end_header` is missing");
  }

  void read_format() {
    std::string_view keyword = words_.next_in_line();
    for (; keyword == "comment" || keyword == "obj_info"; keyword = words_.next_in_line()) {
      expect_line();
    }
    const std::string_view order = words_.next_in_line();
    if (keyword == "format" && order == "ascii") {
      header_.order = PlyOrder::kText;
    } else if (keyword == "format" && order == "binary_little_endian") {
      header_.order = PlyOrder::kLittleEndian;
    } else if (keyword == "format" && order == "binary_big_endian") {
      header_.order = PlyOrder::kBigEndian;
    } else {
      words_.refuse(
          "`format` is missing, or is none of ascii, binary_little_endian and "
          "binary_big_endian");
    }
  }

  void take(std::string_view keyword) {
    if (keyword == "element") {
      add_element();
    } else if (keyword == "property") {
      add_property();
    } else if (!keyword.empty() && keyword != "comment" && keyword != "obj_info") {
      words_.refuse("the keyword is none of element, property, comment, obj_info and end_header");
    }
  }

  void add_element() {
    PlyElement element;
    element.name = words_.next_in_line();
    const auto count = parse_integer<std::uint64_t>(words_.next_in_line());
    if (!count) words_.refuse("the count of an element is no whole number from 0 on");
    element.count = *count;
    for (const PlyElement& other : header_.elements) {
      if (other.name == element.name) words_.refuse("a second element of one name; remove it");
    }
    header_.elements.push_back(std::move(element));
    if (header_.elements.size() > kMostElements) {
      words_.refuse("more than " + std::to_string(kMostElements) +
                    " elements, which is the most that is allowed");
    }
  }

  void add_property() {
    if (header_.elements.empty()) words_.refuse("a property before any element");
    PlyProperty property;
    std::string_view type = words_.next_in_line();
    if (type == "list") {
      property.count_type = &type_of(words_.next_in_line());
      if (property.count_type->kind == PlyType::kReal) {
        words_.refuse("the count of a list is of a type of no whole numbers");
      }
      type = words_.next_in_line();
    }
    property.type = &type_of(type);
    property.name = words_.next_in_line();
    header_.elements.back().properties.push_back(std::move(property));
  }

  const PlyType& type_of(std::string_view name) const {
    for (const PlyType& type : kTypes) {
      if (name == type.name || name == type.sized_name) return type;
    }
    words_.refuse(
        "a type that is none of char, uchar, short, ushort, int, uint, float, double, "
        "int8, uint8, int16, uint16, int32, uint32, float32 and float64");
  }

  /// Rejects elements that declare more rows than the file can hold.
  void check_size(const PlyElement& element) const {
    if (element.count == 0) return;
    const std::string what = "the element `" + shortened(element.name, 40) + "` ";
    if (element.properties.empty()) throw MeshError(what + "has no properties");
    std::size_t least = 0;  // bytes of a row
    for (const PlyProperty& property : element.properties) {
      const PlyType& first = property.count_type ? *property.count_type : *property.type;
      least += header_.order == PlyOrder::kText ? 2 : first.size;  // a digit and a space
    }
    const std::size_t rest = bytes_.size() - header_.size + 1;  // the last space may be missing
    if (element.count <= rest / least) return;
    throw MeshError(what + "says " + std::to_string(element.count) + " rows of at least " +
                    std::to_string(least) + " bytes, and " + std::to_string(rest - 1) +
                    " bytes follow the header");
  }

  static constexpr std::size_t kMostElements = 100;

  const std::string& bytes_;
  MeshTokenizer words_;
  PlyHeader header_;
};

}  // namespace

int PlyElement::find(const std::string& property) const {
  for (std::size_t k = 0; k < properties.size(); ++k) {
    if (properties[k].name == property && properties[k].count_type == nullptr) {
      return static_cast<int>(k);
    }
  }
  return -1;
}

PlyHeader read_ply_header(const std::string& bytes) { return HeaderReader(bytes).read(); }

}  // namespace skybody
