// Checks that links and joints form one tree.
#include <unordered_map>

#include "core/io/files/text.h"
#include "core/io/urdf/urdf_xml.h"

namespace skybody {
namespace {

class TreeCheck {
 public:
  TreeCheck(UrdfXml& xml, Diagnostics& diagnostics) : xml_(xml), diagnostics_(diagnostics) {}

  void run() {
    for (std::size_t i = 0; i < xml_.links.size(); ++i) {
      names_.push_back(xml_.links[i].name);
      index_.emplace(names_.back(), i);
    }
    parent_joint_.assign(xml_.links.size(), nullptr);
    for (const XmlJoint& joint : xml_.joints) {
      check_end(joint, joint.parent, "parent");
      check_end(joint, joint.child, "child");
      check_parent_is_single(joint);
    }
    find_root();
    find_loops();
  }

 private:
  static constexpr std::size_t kNone = static_cast<std::size_t>(-1);

  void error(const XmlNamed& element, const std::string& message) {
    diagnostics_.error(element.mark, message);
  }

  std::size_t index_of(const std::string& link) const {
    const auto found = index_.find(link);
    return found == index_.end() ? kNone : found->second;
  }

  void check_end(const XmlJoint& joint, const std::string& link, const std::string& which) {
    if (index_of(link) != kNone) return;
    error(joint, "the " + which + " `" + link + "` of the joint `" + joint.name +
                     "` is not a link" + suggestion(link, names_, "links"));
  }

  void check_parent_is_single(const XmlJoint& joint) {
    const std::size_t child = index_of(joint.child);
    if (child == kNone) return;
    const XmlJoint*& known = parent_joint_[child];
    if (known == nullptr) {
      known = &joint;
      return;
    }
    error(joint, "the link `" + joint.child + "` is the child of `" + joint.name +
                     "` and, in line " + std::to_string(known->mark.line) + ", of `" + known->name +
                     "`; a link has one parent");
  }

  void find_root() {
    const XmlNamed* root = nullptr;
    for (std::size_t i = 0; i < xml_.links.size(); ++i) {
      const XmlNamed& link = xml_.links[i];
      if (parent_joint_[i] != nullptr) continue;
      if (root == nullptr) {
        root = &link;
        continue;
      }
      error(link, "a second root: neither `" + root->name + "` (line " +
                      std::to_string(root->mark.line) + ") nor `" + link.name +
                      "` is the child of a joint; connect them by a joint");
    }
    if (root != nullptr) xml_.root = root->name;
    if (root == nullptr) {
      error(xml_.links[0],
            "there is no root: every link is the child of a joint; remove the "
            "joint that closes the loop");
    }
  }

  /// Reports loops of links. Without a root the earlier message suffices.
  void find_loops() {
    if (xml_.root.empty()) return;
    std::vector<std::size_t> seen_from(xml_.links.size(), kNone);
    for (std::size_t start = 0; start < xml_.links.size(); ++start) {
      std::size_t at = start;
      while (at != kNone && seen_from[at] == kNone) {
        seen_from[at] = start;
        at = parent_joint_[at] == nullptr ? kNone : index_of(parent_joint_[at]->parent);
      }
      if (at == kNone || seen_from[at] != start) continue;  // a root, or a path visited before
      const XmlJoint& joint = *parent_joint_[at];
      error(joint, "the joint `" + joint.name + "` closes a loop through the link `" +
                       xml_.links[at].name + "`; a URDF is a tree");
    }
  }

  UrdfXml& xml_;
  Diagnostics& diagnostics_;
  std::vector<std::string> names_;                      ///< of links
  std::unordered_map<std::string, std::size_t> index_;  ///< of links
  std::vector<const XmlJoint*> parent_joint_;           ///< by link
};

}  // namespace

bool check_urdf_tree(UrdfXml& xml, Diagnostics& diagnostics) {
  const int errors_before = diagnostics.error_count();
  TreeCheck(xml, diagnostics).run();
  return diagnostics.error_count() == errors_before;
}

}  // namespace skybody
