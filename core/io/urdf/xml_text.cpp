#include "core/io/urdf/xml_text.h"

#include <algorithm>
#include <cstdint>
#include <string_view>
#include <vector>

#include "core/base/system/printable.h"

namespace skybody {
namespace {

using tinyxml2::XMLElement;

constexpr int kMostAttributes = 100;           // of one element; URDF has up to six
constexpr long kMostParts = 1'000'000;         // tags and attributes of a text
constexpr std::size_t kLongestReference = 12;  // &#x0010FFFF;
constexpr std::size_t kLongestShown = 60;      // [bytes] of a text in a message
constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";
constexpr std::string_view kSpace = " \t\r\n";

enum class TagKind { kElement, kEnd, kDeclaration };

bool is_digit(char c) { return c >= '0' && c <= '9'; }
bool is_hex_digit(char c) {
  return is_digit(c) || (c >= 'a' && c <= 'f') || (c >= 'A' && c <= 'F');
}

bool is_letter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); }

/// Whether `name`, the text between & and ;, is one of XML's references.
bool is_reference(std::string_view name) {
  for (const char* known : {"amp", "lt", "gt", "quot", "apos"}) {
    if (name == known) return true;
  }
  if (name.size() < 2 || name[0] != '#') return false;
  const bool hex = name[1] == 'x';
  const std::string_view digits = name.substr(hex ? 2 : 1);
  const bool is_nul = digits.find_first_not_of('0') == digits.npos;  // not an XML character
  return !is_nul && std::all_of(digits.begin(), digits.end(), hex ? is_hex_digit : is_digit);
}

/// Scans a text once, without comments and similar parts.
class Scan {
 public:
  Scan(std::string_view text, const std::string& file, XmlReferences references,
       Diagnostics& diagnostics)
      : text_(text), file_(file), references_(references), diagnostics_(diagnostics) {}

  /// @param columns  gets the column of every element, in the order of the text
  bool run(std::vector<int>& columns) {
    columns_ = &columns;
    if (text_.substr(0, kByteOrderMark.size()) == kByteOrderMark) at_ = kByteOrderMark.size();
    line_start_ = at_;
    while (good_ && at_ < text_.size()) {
      if (!skip("<!--", "-->") && !skip("<![CDATA[", "]]>") && !skip("<?", "?>")) step();
    }
    return good_;
  }

 private:
  void fail(const std::string& message) {
    diagnostics_.error({file_, line_, column()}, message);
    good_ = false;
  }

  int column() const { return static_cast<int>(at_ - line_start_) + 1; }

  /// Skips a part that starts here with `begin`, up to `end`.
  bool skip(std::string_view begin, std::string_view end) {
    if (text_.substr(at_, begin.size()) != begin) return false;
    const std::size_t found = text_.find(end, at_ + begin.size());
    const std::size_t next = found == text_.npos ? text_.size() : found + end.size();
    count_part();
    if (begin == "<![CDATA[") check_place_of_text();
    for (; at_ < next && good_; ++at_) take(text_[at_]);
    return true;
  }

  void step() {
    const char c = text_[at_];
    take(c);
    if (c == '&' && references_ == XmlReferences::kChecked) check_reference();
    if (quote_ != 0) {
      if (c == quote_) quote_ = 0;
    } else if (c == '<' || c == '>') {
      if (c == '<') begin_tag();
      if (c == '>') end_tag();
    } else if (is_in_tag_) {
      step_in_tag(c);
    } else if (kSpace.find(c) == kSpace.npos) {
      check_place_of_text();
    }
    ++at_;
  }

  void begin_tag() {
    const char next = at_ + 1 < text_.size() ? text_[at_ + 1] : ' ';
    is_in_tag_ = true;
    attributes_ = 0;
    kind_ = next == '/' ? TagKind::kEnd : next == '!' ? TagKind::kDeclaration : TagKind::kElement;
    count_part();
    if (kind_ == TagKind::kElement) columns_->push_back(column());
    if (kind_ != TagKind::kElement || depth_ > 0) return;
    if (has_root_) fail("a second element at the top; XML allows one: remove it");
    has_root_ = true;
  }

  void end_tag() {
    if (!is_in_tag_) return check_place_of_text();
    is_in_tag_ = false;
    const bool is_empty = text_[at_ - 1] == '/';
    if (kind_ == TagKind::kElement && !is_empty) ++depth_;
    if (kind_ == TagKind::kEnd && depth_ > 0) --depth_;
  }

  /// Text is allowed only within the top element.
  void check_place_of_text() {
    if (!good_ || depth_ > 0) return;
    const std::string_view rest = text_.substr(at_, text_.find_first_of("\r\n<", at_ + 1) - at_);
    const std::string_view shown = rest.substr(0, rest.find_last_not_of(kSpace) + 1);
    fail("the text `" + shortened(std::string(shown), kLongestShown) + "` stands " +
         (has_root_ ? "after" : "before") +
         " the element at the top, where XML allows none; remove it");
  }

  void step_in_tag(char c) {
    if (c == '"' || c == '\'') quote_ = c;
    if (c != '=') return;
    count_part();
    if (++attributes_ == kMostAttributes + 1) {
      fail("an element with more than " + std::to_string(kMostAttributes) +
           " attributes, which is the most that is allowed; remove those that are not needed");
    }
  }

  void count_part() {
    if (++parts_ != kMostParts + 1) return;
    fail("more than " + std::to_string(kMostParts) +
         " tags and attributes, which is the most that is allowed; split the file");
  }

  void take(char c) {
    if (c == '\n') {
      ++line_;
      line_start_ = at_ + 1;
    }
    const auto code = static_cast<unsigned char>(c);
    if (code < 0x20 && c != '\n' && c != '\t' && c != '\r') {
      fail("the control character `" + std::string(1, c) + "`, which XML forbids; remove it");
    }
  }

  void check_reference() {
    const std::string_view rest = text_.substr(at_ + 1, kLongestReference);
    const std::size_t end = rest.find(';');
    const std::string_view name = rest.substr(0, end == rest.npos ? 0 : end);
    if (is_reference(name)) return;
    const bool is_word = !name.empty() && std::all_of(name.begin(), name.end(), is_letter);
    fail(is_word ? "the reference `&" + std::string(name) +
                       ";`, which XML does not know; write `&amp;` for the character &"
                 : "a bare `&`, which XML forbids; write `&amp;`");
  }

  std::string_view text_;
  const std::string& file_;
  XmlReferences references_;
  Diagnostics& diagnostics_;
  std::size_t at_ = 0;
  std::size_t line_start_ = 0;
  int line_ = 1;
  bool is_in_tag_ = false;
  TagKind kind_ = TagKind::kElement;  ///< of the current tag
  int depth_ = 0;                     ///< number of open elements
  bool has_root_ = false;
  char quote_ = 0;  ///< opening quote of the current attribute value; 0: outside of values
  int attributes_ = 0;
  long parts_ = 0;
  std::vector<int>* columns_ = nullptr;
  bool good_ = true;
};

/// The element after `element` in the order of the text, or null.
XMLElement* next_element(XMLElement* element) {
  if (XMLElement* child = element->FirstChildElement()) return child;
  while (element != nullptr) {
    if (XMLElement* next = element->NextSiblingElement()) return next;
    tinyxml2::XMLNode* parent = element->Parent();
    element = parent == nullptr ? nullptr : parent->ToElement();
  }
  return nullptr;
}

/// Gives every element its column. tinyxml2 knows lines only.
void note_columns(const std::vector<int>& columns, tinyxml2::XMLDocument& document) {
  auto column = columns.begin();
  for (XMLElement* e = document.RootElement(); e != nullptr && column != columns.end();
       e = next_element(e)) {
    e->SetUserData(reinterpret_cast<void*>(static_cast<std::intptr_t>(*column++)));
  }
}

/// "mismatched element" from tinyxml2's XML_ERROR_MISMATCHED_ELEMENT.
std::string error_words(std::string name) {
  for (const std::string prefix : {"XML_ERROR_", "XML_"}) {
    if (name.rfind(prefix, 0) == 0) name = name.substr(prefix.size());
  }
  for (char& c : name) {
    if (c == '_') c = ' ';
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  }
  return name;
}

}  // namespace

bool parse_xml(const std::string& text, const std::string& file, tinyxml2::XMLDocument& document,
               XmlReferences references, Diagnostics& diagnostics) {
  std::vector<int> columns;
  if (!Scan(text, file, references, diagnostics).run(columns)) return false;
  if (document.Parse(text.data(), text.size()) != tinyxml2::XML_SUCCESS) {
    diagnostics.error({file, document.ErrorLineNum(), 0},
                      "not well-formed XML: " + error_words(document.ErrorName()));
    return false;
  }
  note_columns(columns, document);
  return true;
}

SourceLocation xml_mark(const std::string& file, const XMLElement& element) {
  const auto column = reinterpret_cast<std::intptr_t>(element.GetUserData());
  return {file, element.GetLineNum(), static_cast<int>(column)};
}

}  // namespace skybody
