#include "core/plugin_host/new_project.h"

#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <fstream>
#include <sstream>
#include <string_view>
#include <utility>
#include <vector>

#include "core/base/plugin_kind.h"
#include "core/base/system/error.h"
#include "core/base/system/installation.h"
#include "core/plugin_host/search_path.h"

namespace skybody {
namespace fs = std::filesystem;

namespace {

constexpr std::size_t kLongestName = 64;
/// Text for the README: a file of the template without the ending .in.
constexpr const char* kAboutFile = "about.md";

/// Names of CMake targets, and names whose class would clash with one in <skybody/plugin.h>.
bool is_reserved(std::string_view name) {
  for (const std::string_view word :
       {"all",           "clean",      "edit_cache", "help",      "install", "package",
        "rebuild_cache", "test",       "skybody",    "plugin",    "block",   "const_values",
        "error",         "evaluation", "hash_chain", "idle",      "isa",     "lanes",
        "mask",          "mat3",       "pack",       "parameter", "quat",    "random",
        "random_key",    "setup",      "signal",     "sin_cos",   "start",   "state",
        "sym_mat3",      "values",     "vec3",       "view",      "word",    "word_pack"}) {
    if (name == word) return true;
  }
  return kind_from_name(name).has_value();
}

void check_name(const std::string& name) {
  const bool letters =
      name.find_first_not_of("abcdefghijklmnopqrstuvwxyz0123456789_") == std::string::npos;
  const bool words = letters && !name.empty() && name.front() >= 'a' && name.front() <= 'z' &&
                     name.back() != '_' && name.find("__") == std::string::npos;
  if (!words || name.size() > kLongestName) {
    throw Error("`" + name + "` cannot name a plugin; allowed: at most " +
                std::to_string(kLongestName) +
                " lower-case letters, digits and single underscores, a letter first, such as "
                "wind_gust");
  }
  if (is_reserved(name)) {
    throw Error("`" + name + "` is a word of Skybody or CMake; choose another, such as my_" + name);
  }
  std::error_code ignored;
  if (fs::exists(shipped_plugin_folder() / (name + ".so"), ignored)) {
    throw Error("Skybody ships a plugin `" + name + "`; choose another name, such as my_" + name);
  }
}

/// wind_gust -> WindGust
std::string class_name(const std::string& name) {
  std::string result;
  bool upper = true;
  for (const char c : name) {
    if (c == '_') {
      upper = true;
    } else {
      result += upper && c >= 'a' && c <= 'z' ? static_cast<char>(c - 'a' + 'A') : c;
      upper = false;
    }
  }
  return result;
}

std::string replaced(std::string text, std::string_view what, const std::string& by) {
  for (std::size_t at = text.find(what); at != std::string::npos;
       at = text.find(what, at + by.size())) {
    text.replace(at, what.size(), by);
  }
  return text;
}

std::string read(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  std::ostringstream text;
  text << in.rdbuf();
  if (!in || !text) throw Error("cannot read the template " + file.string());
  return text.str();
}

void write(const fs::path& file, const std::string& text) {
  std::ofstream out(file, std::ios::binary);
  out << text;
  out.close();
  if (!out) throw Error("cannot write " + file.string() + ": " + std::strerror(errno));
}

fs::path template_folder() {
  const fs::path templates = shipped_data("template", "plugins/template");
  if (templates.empty()) {
    throw Error("the templates are missing: share/skybody/template of this installation");
  }
  return templates;
}

/// A new folder beside the final one, so that one rename completes it; removed unless kept.
class TemporaryFolder {
 public:
  explicit TemporaryFolder(const fs::path& beside) {
    std::string pattern = (beside / ".skybody-new-XXXXXX").string();
    if (mkdtemp(pattern.data()) == nullptr) {
      throw Error("cannot write into " + beside.string() + ": " + std::strerror(errno));
    }
    path_ = pattern;
    fs::permissions(path_,
                    fs::perms::group_read | fs::perms::group_exec | fs::perms::others_read |
                        fs::perms::others_exec,
                    fs::perm_options::add);
  }
  ~TemporaryFolder() {
    std::error_code ignored;
    if (!path_.empty()) fs::remove_all(path_, ignored);
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;

  const fs::path& path() const { return path_; }
  void keep() { path_.clear(); }

 private:
  fs::path path_;
};

void write_part(const ProjectPart& part, const fs::path& folder) {
  for (const std::string& sort : part.templates) {
    const fs::path source = template_folder() / sort;
    for (const auto& item : fs::recursive_directory_iterator(source)) {
      if (!item.is_regular_file() || item.path().extension() != ".in") continue;
      // tests/NAME_test.cpp.in -> tests/wind_gust_test.cpp
      const std::string file =
          replaced(fs::relative(item.path(), source).string(), "NAME", part.name);
      fs::path target = folder / file;
      target.replace_extension();
      fs::create_directories(target.parent_path());
      std::string text = replaced(read(item.path()), "@NAME@", part.name);
      for (const auto& [word, meaning] : part.words)
        text = replaced(std::move(text), word, meaning);
      write(target, text);
      if (!text.starts_with("#!")) continue;
      fs::permissions(target,
                      fs::perms::owner_exec | fs::perms::group_exec | fs::perms::others_exec,
                      fs::perm_options::add);
    }
  }
}

}  // namespace

fs::path write_new_project(const std::vector<ProjectPart>& parts, const std::string& name,
                           const fs::path& target_dir) {
  const fs::path place = target_dir.empty() ? fs::path(".") : target_dir;
  fs::path folder = place / name;
  std::error_code ignored;
  if (fs::exists(fs::symlink_status(folder, ignored))) {
    throw Error(folder.string() + " exists; nothing was written. Remove it or choose another name");
  }
  if (!fs::is_directory(place, ignored)) throw Error("there is no folder " + place.string());
  TemporaryFolder fresh(place);
  for (const ProjectPart& part : parts) write_part(part, fresh.path() / part.folder);
  // rename() only replaces an empty folder, so that it never overwrites files that appeared in the
  // meantime.
  if (::rename(fresh.path().c_str(), folder.c_str()) != 0) {
    throw Error("cannot make " + folder.string() + ": " + std::strerror(errno));
  }
  fresh.keep();
  return folder;
}

ProjectPart plugin_part(SkybodyKind kind, const std::string& name) {
  check_name(name);
  const std::string word = kind_name(kind);
  return {name,
          {"common", word},
          {{"@ABOUT@", read(template_folder() / word / kAboutFile)},
           {"@CLASS@", class_name(name)},
           {"@KIND@", word},
           {"@A_KIND@", (kind == SKYBODY_EFFECT ? "An " : "A ") + word}}};
}

fs::path write_new_plugin_project(SkybodyKind kind, const std::string& name,
                                  const fs::path& target_dir) {
  return write_new_project({plugin_part(kind, name)}, name, target_dir);
}

}  // namespace skybody
