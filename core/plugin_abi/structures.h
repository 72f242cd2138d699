// A hash of the sizes of all structures that cross the boundary between Skybody and a plugin.
#pragma once

#include <cstddef>
#include <cstdint>

#include "core/plugin_abi/abi.h"

namespace skybody::plugin_export {

/// Hash of the sizes of all structures of abi.h, in the order of that file, in this compiler.
/// FNV-1a over words instead of bytes.
constexpr std::uint64_t structures_hash() {
  constexpr std::size_t sizes[] = {
      sizeof(SkybodyParameter),    sizeof(SkybodyValue),        sizeof(SkybodyBodyInfo),
      sizeof(SkybodyLinkInfo),     sizeof(SkybodyRotorInfo),    sizeof(SkybodyRobotInfo),
      sizeof(SkybodySensorInfo),   sizeof(SkybodyChainInfo),    sizeof(SkybodyShapeInfo),
      sizeof(SkybodyVisualInfo),   sizeof(SkybodyPicture),      sizeof(SkybodyTriangles),
      sizeof(SkybodyEnvParamInfo), sizeof(SkybodySetup),        sizeof(SkybodyChannel),
      sizeof(SkybodySite),         sizeof(SkybodyJointDrive),   sizeof(SkybodyDeclare),
      sizeof(SkybodyChecks),       sizeof(SkybodyLanes),        sizeof(SkybodyStart),
      sizeof(SkybodyHeld),         sizeof(SkybodyEvaluation),   sizeof(SkybodyKernels),
      sizeof(SkybodyPlugin),       sizeof(SkybodyPluginLibrary)};
  std::uint64_t hash = 0xcbf29ce484222325u;
  for (const std::size_t size : sizes) hash = (hash ^ size) * 0x100000001b3u;
  return hash;
}

}  // namespace skybody::plugin_export
