// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <string>

#include "base/result.h"
#include "base/scan.h"
#include "base/semi_regular_mesh.h"
#include "metric/metric.h"
#include "remesh/remesh.h"

/// Scans with their normal meshes, remeshed once and kept on disk: codecs are compared on one mesh,
/// many times.
namespace nacre::bench {

struct CacheOptions {
  std::filesystem::path folder;  ///< empty: nothing is kept
  /// Take a kept mesh even if the remesher's sources have changed since.
  bool keep_old_remesh = false;
  int base_vertices = 0, levels = 0;  ///< of remesh::Options; 0: as it chooses
};

/// A scan, its normal mesh, and what measuring against the scan needs.
struct PreparedScan {
  std::string name;
  std::uint64_t content = 0;  ///< hash of the scan's file
  Scan scan;
  std::size_t input_vertices = 0;
  metric::Surface surface;
  SemiRegularMesh mesh;
};

/// Reads a scan and remeshes it, or finds its mesh in the cache.
[[nodiscard]] Result<PreparedScan> prepare_scan(const std::string& file,
                                                const CacheOptions& options);

/// The mesh that `encode` makes of a scan for a file of so many bytes, also from the cache.
[[nodiscard]] Result<SemiRegularMesh> mesh_for_size(const PreparedScan& scan,
                                                    const CacheOptions& options, std::size_t bytes);

/// 64-bit FNV-1a.
[[nodiscard]] std::uint64_t hash_bytes(const void* data, std::size_t size,
                                       std::uint64_t state = 0xCBF29CE484222325ull);

/// Distances between the raw scan and a mesh, `samples` area samples each way.
[[nodiscard]] Result<metric::Comparison> distance_to_scan(const PreparedScan& scan,
                                                          const SemiRegularMesh& mesh,
                                                          std::size_t samples);

}  // namespace nacre::bench
