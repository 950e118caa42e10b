// SPDX-License-Identifier: GPL-3.0-or-later
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <string>

#include "data/ammonite.h"
#include "data/simulate.h"
#include "io/write.h"

namespace {

int fail(const nacre::Error& error) {
  std::fprintf(stderr, "nacre_generate_scan: %s\n", error.message.c_str());
  return 1;
}

int run(const std::string& file, std::uint64_t seed) {
  nacre::data::SimulationOptions options;
  options.seed = seed;
  const nacre::data::Target target{nacre::data::ammonite, nacre::data::kLipschitz,
                                   nacre::data::kBoundingRadius};
  const auto scan = nacre::data::simulate_scan(target, options);
  if (!scan) return fail(scan.error());
  const auto bytes = nacre::io::serialize_mesh(*scan, nacre::io::MeshFormat::kPly);
  if (!bytes) return fail(bytes.error());
  if (const auto ok = nacre::io::write_file(file, *bytes, true); !ok) return fail(ok.error());
  std::printf("%s: %zu vertices, %zu faces, %zu bytes\n", file.c_str(), scan->positions.size(),
              scan->triangles.size(), bytes->size());
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 2 || argc > 3) {
    std::fprintf(stderr, "usage: nacre_generate_scan OUT.ply [SEED]\n");
    return 2;
  }
  try {
    const std::uint64_t default_seed = nacre::data::SimulationOptions().seed;
    return run(argv[1], argc == 3 ? std::strtoull(argv[2], nullptr, 10) : default_seed);
  } catch (const std::exception& e) {
    return fail({nacre::ErrorCode::kCannotWrite, e.what()});
  }
}
