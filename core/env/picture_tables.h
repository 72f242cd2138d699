// Pictures that plugins have asked for.
#pragma once

#include <map>
#include <string>

#include "core/model/picture.h"
#include "core/plugin_abi/abi.h"

namespace skybody {

/// Reads each file once. The results are valid as long as this object.
class PictureTables {
 public:
  /// @param read  null: no picture can be read
  explicit PictureTables(ReadPicture read) : read_(read) {}
  const SkybodyPicture* of_file(const std::string& file);

 private:
  struct Table {
    Picture picture;
    std::string problem;
    SkybodyPicture view{};
  };

  ReadPicture read_;
  std::map<std::string, Table> files_;
};

}  // namespace skybody
