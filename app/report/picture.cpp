#include "app/report/picture.h"

namespace skybody {
namespace {

constexpr const char* kPackages = "matplotlib and h5py";
constexpr PythonTool kPlot{"skybody.plot", "picture ", kPackages};
constexpr PythonTool kView{"skybody.view", "page ", kPackages};

}  // namespace

MadeFiles draw_pictures(const std::filesystem::path& log) { return make_files(kPlot, {log}); }

MadeFiles write_view(const std::filesystem::path& log) { return make_files(kView, {log}); }

}  // namespace skybody
