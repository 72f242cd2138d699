#include "app/report/output_folder.h"

#include <system_error>
#include <vector>

#include "core/base/system/error.h"
#include "core/io/files/atomic_file.h"

namespace skybody {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void fail(const fs::path& folder, const std::error_code& error) {
  throw Error("cannot write into the folder " + folder.string() + ": " + error.message() +
              "; choose another with --out DIR");
}

/// Creates a folder if it is missing. @returns whether it was created
bool make_folder(const fs::path& folder) {
  std::error_code error;
  const bool made = fs::create_directories(folder, error);
  if (error) fail(folder, error);
  if (!fs::is_directory(folder)) fail(folder, std::make_error_code(std::errc::not_a_directory));
  return made;
}

/// The first free name; creating the folder claims it.
fs::path make_new_folder(const std::string& name) {
  const fs::path parent = "flights";
  make_folder(parent);
  for (int number = 1;; ++number) {
    const fs::path folder = parent / (number == 1 ? name : name + "-" + std::to_string(number));
    std::error_code error;
    if (fs::create_directory(folder, error)) return folder;
    if (error && error != std::errc::file_exists) fail(folder, error);
  }
}

bool is_picture(const std::string& name) {
  return name.rfind("flight-", 0) == 0 && name.size() >= 15 &&
         name.compare(name.size() - 4, 4, ".png") == 0 &&
         name.find_first_not_of("0123456789", 7) == name.size() - 4;
}

}  // namespace

OutputFolder::OutputFolder(const fs::path& out, const std::string& scenario, std::uint64_t seed) {
  if (out.empty()) {
    path_ = make_new_folder(scenario + "-" + std::to_string(seed));
    created_ = true;
  } else {
    path_ = out;
    created_ = make_folder(out);
  }
  partial_log_ = partial_name(log());
}

OutputFolder::~OutputFolder() {
  std::error_code ignored;
  fs::remove(partial_log(), ignored);
  if (created_) fs::remove(path_, ignored);  // only if it is empty
}

void OutputFolder::commit() {
  std::error_code error;
  fs::rename(partial_log(), log(), error);
  if (error) fail(path_, error);
  remove_old_pictures();
}

void OutputFolder::remove_old_pictures() const {
  std::vector<fs::path> old;
  for (const fs::directory_entry& entry : fs::directory_iterator(path_)) {
    if (is_picture(entry.path().filename().string())) old.push_back(entry.path());
  }
  std::error_code ignored;
  for (const fs::path& picture : old) fs::remove(picture, ignored);
}

}  // namespace skybody
