#include "core/io/urdf/mesh_dae_document.h"

#include <algorithm>
#include <array>

#include "core/base/system/printable.h"
#include "core/io/files/text.h"
#include "core/io/urdf/xml_text.h"

namespace skybody {
namespace {

using tinyxml2::XMLElement;

/// Elements that other elements reference by their ids.
constexpr std::array<const char*, 7> kNamed = {"float_array", "source", "vertices",    "geometry",
                                               "controller",  "node",   "visual_scene"};

std::string tag_of(const XMLElement& element) { return '<' + std::string(element.Name()) + '>'; }

std::string quoted_id(const char* id) { return '`' + shortened(id, 100) + '`'; }

}  // namespace

DaeDocument::DaeDocument(const std::string& text) {
  Diagnostics diagnostics;
  if (!parse_xml(text, "", document_, XmlReferences::kPassed, diagnostics)) {
    const Diagnostic& first = diagnostics.all().front();
    throw MeshError(first.mark.line, first.message);
  }
  if (document_.RootElement() == nullptr || std::string(root().Name()) != "COLLADA") {
    throw MeshError("its first element is not <COLLADA>");
  }
  note_ids(root());
}

void DaeDocument::note_ids(const XMLElement& parent) {
  for (const XMLElement* e = parent.FirstChildElement(); e; e = e->NextSiblingElement()) {
    const char* const id = e->Attribute("id");
    const std::string kind = e->Name();
    const bool is_named = std::find(kNamed.begin(), kNamed.end(), kind) != kNamed.end();
    if (id != nullptr && is_named) {
      const auto [known, is_new] = ids_.emplace(kind + '#' + id, e);
      if (!is_new) known->second = nullptr;
    }
    note_ids(*e);
  }
}

const XMLElement& DaeDocument::find(const XMLElement& user, const char* attribute,
                                    std::initializer_list<const char*> kinds) const {
  const char* const id = user.Attribute(attribute);
  if (id == nullptr) refuse_element(user, tag_of(user) + " has no `" + attribute + "`");
  if (id[0] != '#') {
    refuse_element(user, tag_of(user) + " names " + quoted_id(id) +
                             "; allowed: # and an id of this file, as no other is opened");
  }
  for (const char* kind : kinds) {
    const auto found = ids_.find(std::string(kind) + id);
    if (found == ids_.end()) continue;
    if (found->second != nullptr) return *found->second;
    refuse_element(user, tag_of(user) + " names " + quoted_id(id) + ", and several <" + kind +
                             "> have this id; give them different ones");
  }
  refuse_element(user, tag_of(user) + " names " + quoted_id(id) + ", and no <" + *kinds.begin() +
                           "> has this id");
}

void refuse_element(const XMLElement& element, const std::string& reason) {
  throw MeshError(element.GetLineNum(), reason);
}

const XMLElement& dae_child(const XMLElement& element, const char* name) {
  const XMLElement* const child = element.FirstChildElement(name);
  if (child == nullptr) refuse_element(element, tag_of(element) + " has no <" + name + '>');
  return *child;
}

std::uint32_t dae_count(const XMLElement& element, const char* attribute) {
  const char* const text = element.Attribute(attribute);
  const auto count = parse_integer<std::uint32_t>(text == nullptr ? "" : text);
  if (count) return *count;
  refuse_element(element, "`" + std::string(attribute) + "` of " + tag_of(element) +
                              " is no whole number from 0 on");
}

std::uint32_t dae_count(const XMLElement& element, const char* attribute, std::uint32_t absent) {
  return element.Attribute(attribute) == nullptr ? absent : dae_count(element, attribute);
}

bool attribute_is(const XMLElement& element, const char* attribute, const char* value) {
  return element.Attribute(attribute, value) != nullptr;
}

std::vector<double> dae_numbers(const XMLElement& element) {
  std::vector<double> numbers;
  for_each_word(element, [&](std::string_view word, const MeshTokenizer& words) {
    numbers.push_back(words.coordinate(word));
  });
  return numbers;
}

std::vector<double> dae_numbers(const XMLElement& element, std::size_t count) {
  std::vector<double> numbers = dae_numbers(element);
  if (numbers.size() == count) return numbers;
  refuse_element(element, tag_of(element) + " has " + std::to_string(numbers.size()) +
                              " numbers; needed: " + std::to_string(count));
}

}  // namespace skybody
