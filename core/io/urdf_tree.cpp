// Whether links and joints form one tree.
#include <map>
#include <set>

#include "core/io/text.h"
#include "core/io/urdf_xml.h"

namespace skybody {
namespace {

class TreeCheck {
 public:
  TreeCheck(const std::string& file, UrdfXml& xml, Diagnostics& diagnostics)
      : file_(file), xml_(xml), diagnostics_(diagnostics) {}

  void run() {
    for (const XmlNamed& link : xml_.links) names_.push_back(link.name);
    for (const XmlJoint& joint : xml_.joints) {
      check_end(joint, joint.parent, "parent");
      check_end(joint, joint.child, "child");
      check_parent_is_single(joint);
    }
    find_root();
    find_loops();
  }

 private:
  void error(int line, const std::string& message) {
    diagnostics_.error({file_, line, 0}, message);
  }

  void check_end(const XmlJoint& joint, const std::string& link, const std::string& which) {
    for (const std::string& name : names_) {
      if (name == link) return;
    }
    error(joint.line, "the " + which + " `" + link + "` of the joint `" + joint.name +
                          "` is not a link" + suggestion(link, names_, "links"));
  }

  void check_parent_is_single(const XmlJoint& joint) {
    const auto [known, is_new] = parent_joint_.emplace(joint.child, &joint);
    if (is_new) return;
    error(joint.line, "the link `" + joint.child + "` is the child of `" + joint.name +
                          "` and, in line " + std::to_string(known->second->line) + ", of `" +
                          known->second->name + "`; a link has one parent");
  }

  void find_root() {
    const XmlNamed* root = nullptr;
    for (const XmlNamed& link : xml_.links) {
      if (parent_joint_.count(link.name) != 0) continue;
      if (root == nullptr) {
        root = &link;
        continue;
      }
      error(link.line, "a second root: neither `" + root->name + "` (line " +
                           std::to_string(root->line) + ") nor `" + link.name +
                           "` is the child of a joint; connect them by a joint");
    }
    if (root != nullptr) xml_.root = root->name;
    if (root == nullptr) {
      error(xml_.links[0].line,
            "there is no root: every link is the child of a joint; remove the "
            "joint that closes the loop");
    }
  }

  /// Links that lead back to themselves. Without a root the message above says enough.
  void find_loops() {
    if (xml_.root.empty()) return;
    std::set<std::string> reported;
    for (const XmlNamed& link : xml_.links) {
      std::set<std::string> path;
      std::string at = link.name;
      while (parent_joint_.count(at) != 0 && path.insert(at).second) {
        at = parent_joint_.at(at)->parent;
      }
      if (parent_joint_.count(at) == 0 || reported.count(at) != 0) continue;
      reported.insert(path.begin(), path.end());
      error(parent_joint_.at(at)->line, "the joint `" + parent_joint_.at(at)->name +
                                            "` closes a loop through the link `" + at +
                                            "`; a URDF is a tree");
    }
  }

  const std::string& file_;
  UrdfXml& xml_;
  Diagnostics& diagnostics_;
  std::vector<std::string> names_;
  std::map<std::string, const XmlJoint*> parent_joint_;
};

}  // namespace

bool check_urdf_tree(const std::string& file, UrdfXml& xml, Diagnostics& diagnostics) {
  const int errors_before = diagnostics.error_count();
  TreeCheck(file, xml, diagnostics).run();
  return diagnostics.error_count() == errors_before;
}

}  // namespace skybody
