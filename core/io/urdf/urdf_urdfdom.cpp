// urdfdom has its own XML reader, which decodes some texts differently from tinyxml2. The two would
// then have different names for one link. urdfdom therefore gets a new text, written from
// tinyxml2's elements and attributes, and its model is compared with the list of links and joints.
// Capsules, which urdfdom does not support, are passed as cylinders: they have the same attributes.
#include "core/io/urdf/urdf_urdfdom.h"

#include <console_bridge/console.h>
#include <urdf_model/link.h>
#include <urdf_model/model.h>
#include <urdf_parser/urdf_parser.h>

#include <mutex>
#include <string_view>
#include <vector>

#include "core/io/files/text.h"

namespace skybody {
namespace {

using tinyxml2::XMLElement;

/// Stores urdfdom's console output.
class Chatter : public console_bridge::OutputHandler {
 public:
  void log(const std::string& text, console_bridge::LogLevel level, const char*, int) override {
    if (level >= console_bridge::CONSOLE_BRIDGE_LOG_ERROR) errors.push_back(text);
  }
  std::vector<std::string> errors;
};

/// Separates numbers by single spaces: urdfdom accepts no other white space.
std::string with_single_blanks(const std::string& value) {
  if (value.find_first_not_of("0123456789+-.eE \t\r\n") != std::string::npos) {
    return value;
  }
  return join(split_words(value), " ");
}

/// Whether the attribute's value is a name; names may look like numbers.
bool is_name(std::string_view attribute) {
  return attribute == "name" || attribute == "link" || attribute == "filename" ||
         attribute == "joint";
}

/// Writes an element: its attributes, then its `children`.
template <class Children>
void write_element(const XMLElement& element, tinyxml2::XMLPrinter& out, Children&& children) {
  const std::string_view name = element.Name();
  out.OpenElement(name == "capsule" ? "cylinder" : element.Name(), true);
  for (const auto* a = element.FirstAttribute(); a != nullptr; a = a->Next()) {
    const std::string value = a->Value();
    out.PushAttribute(a->Name(), (is_name(a->Name()) ? value : with_single_blanks(value)).c_str());
  }
  if (name == "limit") {  // attributes that urdfdom requires and Skybody ignores
    for (const char* unread : {"effort", "velocity"}) {
      if (element.Attribute(unread) == nullptr) out.PushAttribute(unread, "0");
    }
  }
  for (const XMLElement* e = element.FirstChildElement(); e != nullptr;
       e = e->NextSiblingElement()) {
    children(*e);
  }
  out.CloseElement(true);
}

void write_all(const XMLElement& element, tinyxml2::XMLPrinter& out) {
  write_element(element, out, [&](const XMLElement& child) { write_all(child, out); });
}

/// Writes the parts of the robot that Skybody reads.
std::string written_anew(const XMLElement& robot) {
  tinyxml2::XMLPrinter out(nullptr, true);
  write_element(robot, out, [&](const XMLElement& child) {
    const std::string name = child.Name();
    if (name == "link" || name == "joint" || name == "material") write_all(child, out);
  });
  return out.CStr();
}

/// urdfdom's console is global to the process, hence the lock.
urdf::ModelInterfaceSharedPtr parse(const std::string& text, Chatter& chatter) {
  static std::mutex mutex;
  const std::lock_guard<std::mutex> lock(mutex);
  console_bridge::OutputHandler* before = console_bridge::getOutputHandler();
  console_bridge::useOutputHandler(&chatter);
  urdf::ModelInterfaceSharedPtr model;
  try {
    model = urdf::parseURDF(text);
  } catch (const std::exception& error) {
    chatter.errors.push_back(error.what());
  }
  console_bridge::useOutputHandler(before);
  return model;
}

/// Whether the model has one shape for each element of that name.
template <class Shapes>
bool has_shapes(const Shapes& shapes, const XMLElement& link, const char* name) {
  const XMLElement* e = link.FirstChildElement(name);
  for (const auto& shape : shapes) {
    if (e == nullptr || !shape || !shape->geometry) return false;
    e = e->NextSiblingElement(name);
  }
  return e == nullptr;
}

/// Whether urdfdom's model contains the link with all of its parts.
bool has_link(const urdf::ModelInterface& model, const XmlNamed& named) {
  const auto link = model.getLink(named.name);
  if (!link) return false;
  const XMLElement& e = *named.element;
  const bool has_inertial = e.FirstChildElement("inertial") != nullptr;
  return has_inertial == (link->inertial != nullptr) &&
         has_shapes(link->visual_array, e, "visual") &&
         has_shapes(link->collision_array, e, "collision");
}

/// The first element missing from urdfdom's model, or null.
const XmlNamed* lost(const UrdfXml& xml, const urdf::ModelInterface& model) {
  for (const XmlNamed& link : xml.links) {
    if (!has_link(model, link)) return &link;
  }
  for (const XmlJoint& joint : xml.joints) {
    if (!model.getJoint(joint.name)) return &joint;
  }
  return nullptr;
}

}  // namespace

urdf::ModelInterfaceSharedPtr read_by_urdfdom(const UrdfXml& xml, const std::string& file,
                                              Diagnostics& diagnostics) {
  Chatter chatter;
  auto model = parse(written_anew(*xml.document.RootElement()), chatter);
  if (!model) {
    const std::string reasons =
        chatter.errors.empty() ? "no reason given" : join(chatter.errors, " ");
    diagnostics.error({file, 0, 0}, "urdfdom refuses the file: " + reasons);
    return nullptr;
  }
  if (const XmlNamed* named = lost(xml, *model)) {
    diagnostics.error(named->mark, "urdfdom reads <" + std::string(named->element->Name()) + "> `" +
                                       named->name +
                                       "` otherwise than it is written; write it more simply");
    return nullptr;
  }
  return model;
}

}  // namespace skybody
