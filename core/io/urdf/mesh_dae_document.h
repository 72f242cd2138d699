// The elements of a COLLADA document, for mesh_dae.cpp. Internal to core/io.
#pragma once

#include <tinyxml2.h>

#include <cstdint>
#include <initializer_list>
#include <string>
#include <unordered_map>
#include <vector>

#include "core/io/urdf/mesh_tokenizer.h"

namespace skybody {

/// A document with an index of its ids.
class DaeDocument {
 public:
  /// @throws MeshError
  explicit DaeDocument(const std::string& text);

  const tinyxml2::XMLElement& root() const { return *document_.RootElement(); }

  /// The element referenced by an attribute of `user`, "#ID".
  /// @param kinds  allowed names of the element
  /// @throws MeshError if there is none or several, or the attribute names another file
  const tinyxml2::XMLElement& find(const tinyxml2::XMLElement& user, const char* attribute,
                                   std::initializer_list<const char*> kinds) const;

 private:
  void note_ids(const tinyxml2::XMLElement& parent);

  tinyxml2::XMLDocument document_;
  std::unordered_map<std::string, const tinyxml2::XMLElement*>
      ids_;  ///< by "KIND#ID"; null: several
};

[[noreturn]] void refuse_element(const tinyxml2::XMLElement& element, const std::string& reason);

/// The child element of this name. @throws MeshError if there is none
const tinyxml2::XMLElement& dae_child(const tinyxml2::XMLElement& element, const char* name);

/// An attribute as a whole number >= 0. @throws MeshError if it is invalid or too large
std::uint32_t dae_count(const tinyxml2::XMLElement& element, const char* attribute);

/// The same, with a value for a missing attribute.
std::uint32_t dae_count(const tinyxml2::XMLElement& element, const char* attribute,
                        std::uint32_t absent);

bool attribute_is(const tinyxml2::XMLElement& element, const char* attribute, const char* value);

/// Calls visit(word, words) for each word of an element's text.
template <class Visit>
void for_each_word(const tinyxml2::XMLElement& element, const Visit& visit) {
  for (const auto* child = element.FirstChild(); child; child = child->NextSibling()) {
    if (child->ToText() == nullptr) continue;
    MeshTokenizer words(child->Value(), child->GetLineNum());
    for (auto word = words.next(); !word.empty(); word = words.next()) visit(word, words);
  }
}

/// An element's text as finite numbers. @throws MeshError
std::vector<double> dae_numbers(const tinyxml2::XMLElement& element);

/// The same for exactly `count` numbers. @throws MeshError
std::vector<double> dae_numbers(const tinyxml2::XMLElement& element, std::size_t count);

}  // namespace skybody
