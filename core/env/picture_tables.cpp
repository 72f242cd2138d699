#include "core/env/picture_tables.h"

namespace skybody {

const SkybodyPicture* PictureTables::of_file(const std::string& file) {
  const auto [found, is_new] = files_.try_emplace(file);
  Table& table = found->second;
  if (is_new) {
    table.problem = read_ != nullptr ? read_(file, table.picture) : "cannot be read here";
    const Picture& picture = table.picture;
    table.view = {picture.rgb.data(), picture.width, picture.height, table.problem.c_str()};
  }
  return &table.view;
}

}  // namespace skybody
