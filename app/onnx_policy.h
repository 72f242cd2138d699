// Policies in ONNX, which Python converts to policy.h5 (docs/export_policy.md).
#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "core/assemble/compile_scenario.h"
#include "core/policy/policy.h"

namespace skybody {

/// Whether a policy's name is that of a file in ONNX.
bool is_onnx(const std::string& policy);

/// Converts `file` for the scenario of `options` and opens it.
/// @param map  YAML file that maps its inputs to observations; empty: none
/// @throws Error with the converter's message
std::unique_ptr<Policy> open_onnx_policy(const std::string& file, const LoadOptions& options,
                                         const std::filesystem::path& map);

}  // namespace skybody
