#include "core/plugin_host/registry.h"

#include <algorithm>
#include <set>

#include "core/base/plugin_kind.h"
#include "core/base/system/installation.h"
#include "core/base/system/plugin_call_trace.h"
#include "core/plugin_host/descriptor.h"
#include "core/plugin_host/elf_check.h"
#include "core/plugin_host/trust.h"

namespace skybody {
namespace {

namespace fs = std::filesystem;

/// "controller `lane_controller`"
std::string described(const PluginEntry& entry) {
  return std::string(kind_name(entry.kind)) + " `" + entry.name + "`";
}

std::string two_files(const PluginEntry& a, const PluginEntry& b) {
  return "two plugins of kind " + std::string(kind_name(a.kind)) + " are called `" + a.name +
         "`: " + a.file.string() + " and " + b.file.string() + "; remove or rename one";
}

/// Makes plugins of the same kind and name unusable. Only writes `failure` where it is not yet set:
/// entries that find() has returned were compared with all that promise their name, and do not
/// change.
void refuse_twins(const std::vector<PluginEntry*>& entries) {
  for (auto first = entries.begin(); first != entries.end(); ++first) {
    for (auto second = first + 1; second != entries.end(); ++second) {
      PluginEntry& a = **first;
      PluginEntry& b = **second;
      if (a.kind != b.kind || a.name != b.name || a.descriptor == nullptr) continue;
      if (a.failure.empty()) a.failure = two_files(a, b);
      if (b.failure.empty()) b.failure = a.failure;
    }
  }
}

std::vector<PluginEntry> entries_of(const std::shared_ptr<PluginLibrary>& library) {
  const PluginPhase phase(library->file(), "while its description is read");
  std::vector<PluginEntry> entries;
  for (const SkybodyPlugin* plugin : library->plugins()) {
    PluginEntry& entry = entries.emplace_back();
    entry.kind = static_cast<SkybodyKind>(plugin->kind);
    entry.name = plugin->name;
    entry.version = plugin->version;
    entry.doc = plugin->doc;
    entry.file = library->file();
    entry.vectorized = plugin->vectorized != 0;
    entry.parameters = parameter_specs(*plugin);
    entry.descriptor = plugin;
    entry.library = library;
  }
  return entries;
}

PluginEntry unusable(const fs::path& file, const std::string& name, const std::string& failure) {
  PluginEntry entry;
  entry.name = name;
  entry.file = file;
  entry.failure = failure;
  return entry;
}

/// Remedy: how to make a library promise its plugins.
std::string remedy(const PluginManifest& found) {
  if (!found.sidecar.empty()) return "mend " + found.sidecar.string();
  return "write the names of its plugins into " +
         fs::path(found.file).replace_extension(".plugins").string() + ", one a line";
}

/// Message for a library that does not contain the plugin `name` that `found` promises.
std::string broken_promise(const PluginManifest& found, const std::string& name,
                           const std::vector<PluginEntry>& held) {
  std::string list;
  for (const PluginEntry& entry : held) list += (list.empty() ? "" : ", ") + described(entry);
  return PluginLoadError(
             LoadFailure::kOtherPlugin, found.file,
             "promises a plugin `" + name + "`, but holds " + list + ": " + remedy(found))
      .what();
}

std::string no_promise(const PluginManifest& found, const PluginEntry& entry) {
  return PluginLoadError(
             LoadFailure::kOtherPlugin, found.file,
             "holds " + described(entry) + ", which it does not promise: " + remedy(found))
      .what();
}

/// Whether other users may write libskybody. If so, they control the code that runs here, whatever
/// the plugins' permissions.
bool is_skybody_writable() {
  static const bool writable = !trust_problem(library_file()).empty();
  return writable;
}

}  // namespace

bool PluginRegistry::File::promises(std::string_view name) const {
  return std::any_of(found.begin(), found.end(),
                     [name](const PluginManifest& file) { return file.promises(name); });
}

/// Compares a library's plugins with the names that it promises.
std::vector<PluginEntry> PluginRegistry::compare(const File& file, std::vector<PluginEntry> held) {
  std::vector<PluginEntry> entries;
  for (const PluginManifest& found : file.found) {
    for (const std::string& name : found.names) {
      const bool holds = std::any_of(held.begin(), held.end(),
                                     [&name](const PluginEntry& e) { return e.name == name; });
      if (!holds) entries.push_back(unusable(file.path, name, broken_promise(found, name, held)));
    }
  }
  const bool kept = entries.empty();
  for (PluginEntry& entry : held) {
    if (file.promises(entry.name)) {
      entries.push_back(std::move(entry));
    } else if (kept) {  // otherwise the message about the broken promise contains it
      entries.push_back(unusable(file.path, entry.name, no_promise(file.found.front(), entry)));
    }
  }
  return entries;
}

PluginRegistry::PluginRegistry(const std::vector<fs::path>& search_path, RefusedFiles refused)
    : search_path_(search_path), refused_(std::move(refused)) {
  for (const fs::path& folder : search_path_) add_folder(folder);
}

void PluginRegistry::add_unreadable(const fs::path& folder, const std::string& problem) {
  File& file = files_.emplace_back();
  file.path = folder;
  file.open = true;
  file.entries.push_back(unusable(folder, folder.filename().string(), problem));
}

void PluginRegistry::add_folder(const fs::path& folder) {
  if (const std::string problem = folder_problem(folder); !problem.empty()) {
    add_unreadable(folder, problem);
    return;
  }
  std::error_code ignored;
  const bool shipped = fs::equivalent(folder, shipped_plugin_folder(), ignored);
  for (const PluginManifest& found : plugin_manifests(folder)) {
    std::error_code failed;
    const fs::path path = fs::canonical(found.file, failed);
    if (failed) continue;
    auto file = std::find_if(files_.begin(), files_.end(),
                             [&path](const File& other) { return other.path == path; });
    if (file == files_.end()) {
      file = files_.insert(files_.end(), File{});
      file->path = path;
    }
    file->shipped = file->shipped || shipped;
    const bool is_known =
        std::any_of(file->found.begin(), file->found.end(), [&found](const PluginManifest& other) {
          return other.names == found.names && other.problem == found.problem;
        });
    if (!is_known) file->found.push_back(found);
  }
}

/// Checks the library itself, and the links under which it was found: other users could redirect a
/// link.
/// @throws PluginLoadError
void PluginRegistry::check_trust(const File& file) const {
  std::string problem = trust_problem(file.path);
  for (const PluginManifest& found : file.found) {
    if (!problem.empty()) break;
    std::error_code failed;  // yields an empty folder, which is not trusted
    const fs::path folder = fs::canonical(found.file.parent_path(), failed);
    problem = trust_problem(folder / found.file.filename());
  }
  if (!problem.empty()) throw PluginLoadError(LoadFailure::kNotTrusted, file.path, problem);
}

/// @throws PluginLoadError
std::shared_ptr<PluginLibrary> PluginRegistry::load(const File& file) const {
  if (const auto refused = refused_.find(file.path); refused != refused_.end()) {
    throw PluginLoadError(LoadFailure::kEndsProcess, file.path, refused->second);
  }
  std::error_code
      ignored;  // for such files the remedy for a file that others may write would be wrong
  if (!fs::is_regular_file(file.path, ignored)) {
    throw PluginLoadError(LoadFailure::kNotLoadable, file.path, kNoRegularFile);
  }
  if (!file.shipped || !is_skybody_writable()) check_trust(file);
  for (const PluginManifest& found : file.found) {
    if (!found.problem.empty()) {
      throw PluginLoadError(LoadFailure::kOtherPlugin, found.file, found.problem);
    }
  }
  return std::make_shared<PluginLibrary>(file.path);
}

void PluginRegistry::open(File& file) const {
  if (file.open) return;
  file.open = true;
  try {
    file.entries = compare(file, entries_of(load(file)));
  } catch (const PluginLoadError& e) {
    for (const PluginManifest& found : file.found) {
      for (const std::string& name : found.names) {
        file.entries.push_back(unusable(file.path, name, e.what()));
      }
    }
    if (file.entries.empty()) {
      file.entries.push_back(unusable(file.path, file.path.stem().string(), e.what()));
    }
    for (PluginEntry& entry : file.entries) {
      entry.is_not_trusted = e.reason() == LoadFailure::kNotTrusted;
    }
  }
}

const PluginEntry* PluginRegistry::find(SkybodyKind kind, std::string_view name) const {
  const std::lock_guard lock(mutex_);
  std::vector<PluginEntry*> entries;
  for (File& file : files_) {
    if (!file.promises(name)) continue;
    open(file);
    for (PluginEntry& entry : file.entries) {
      if (entry.name == name) entries.push_back(&entry);
    }
  }
  refuse_twins(entries);
  const PluginEntry* unusable = nullptr;
  const PluginEntry* usable = nullptr;
  for (const PluginEntry* entry : entries) {
    if (entry->kind == kind && usable == nullptr) usable = entry;
    if (entry->kind == SKYBODY_KIND_COUNT && unusable == nullptr) unusable = entry;
  }
  // A library that does not load is not replaced by another of the same name: its author would fly
  // the other plugin without noticing.
  const bool counts = unusable != nullptr && !unusable->is_not_trusted;
  return usable == nullptr || counts ? unusable : usable;
}

std::vector<std::string> PluginRegistry::names(SkybodyKind kind) const {
  std::set<std::string> names;
  for (const PluginEntry* entry : known(kind)) names.insert(entry->name);
  return {names.begin(), names.end()};
}

std::vector<std::string> PluginRegistry::promised() const {
  const std::lock_guard lock(mutex_);
  std::set<std::string> names;
  for (const File& file : files_) {
    if (file.open) continue;
    for (const PluginManifest& found : file.found) {
      names.insert(found.names.begin(), found.names.end());
    }
  }
  return {names.begin(), names.end()};
}

std::vector<const PluginEntry*> PluginRegistry::known(SkybodyKind kind) const {
  const std::lock_guard lock(mutex_);
  std::vector<const PluginEntry*> entries;
  for (File& file : files_) {
    if (file.shipped) open(file);
    for (const PluginEntry& entry : file.entries) {
      if (entry.kind == kind && entry.failure.empty()) entries.push_back(&entry);
    }
  }
  std::sort(entries.begin(), entries.end(),
            [](const PluginEntry* a, const PluginEntry* b) { return a->name < b->name; });
  return entries;
}

std::vector<const PluginEntry*> PluginRegistry::open_all() const {
  const std::lock_guard lock(mutex_);
  std::vector<PluginEntry*> entries;
  for (File& file : files_) {
    open(file);
    for (PluginEntry& entry : file.entries) entries.push_back(&entry);
  }
  refuse_twins(entries);
  return {entries.begin(), entries.end()};
}

}  // namespace skybody
