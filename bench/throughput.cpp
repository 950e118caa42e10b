// SPDX-License-Identifier: GPL-3.0-or-later
//
// Time of the stages in process, on the normal mesh of one scan: decoding on one thread (it has no
// other), encoding on all.
#include <benchmark/benchmark.h>
#include <fmt/format.h>

#include <cstdlib>
#include <filesystem>

#include "app/files.h"
#include "bench/draco_peer.h"
#include "bench/support.h"
#include "codec/codec.h"
#include "io/io.h"
#include "remesh/remesh.h"
#include "tests/support/corpus.h"
#include "wavelet/wavelet.h"

namespace nacre::bench {
namespace {

/// Everything the benchmarks share, made once.
struct Input {
  Scan scan;
  SemiRegularMesh mesh;
  Topology topology;
  Pyramid pyramid;
};

template <class T>
T expect(Result<T> result) {
  if (result) return std::move(*result);
  fmt::print(stderr, "throughput: {}\n", result.error().message);
  std::exit(1);
}

Input make_input(const std::string& file) {
  Scan scan = expect(io::read_scan(file)).scan;
  remesh::Options options;
  options.predict = wavelet::predict_at_need;
  SemiRegularMesh mesh = expect(remesh::remesh(scan, options)).mesh;
  Topology topology =
      expect(Topology::build(mesh.base_triangles, mesh.base_vertex_count, mesh.level_count));
  Pyramid pyramid = expect(wavelet::analyze(topology, mesh.positions));
  return {std::move(scan), std::move(mesh), std::move(topology), std::move(pyramid)};
}

using codec::Profile;

const char* name_of(Profile profile) { return profile == Profile::kPaper ? "paper" : "best"; }

std::vector<std::uint8_t> encode(const Input& input, Profile profile,
                                 double bits_per_input_vertex) {
  codec::EncodeOptions options;
  options.profile = profile;
  options.target_bytes = static_cast<std::size_t>(
      bits_per_input_vertex * static_cast<double>(input.scan.positions.size()) / 8);
  return expect(codec::encode(input.mesh, options)).bytes;
}

/// Reports the median of some runs, and semi-regular vertices per second: of this thread's own time
/// where it is alone, which a busy machine changes least, else of wall time.
template <class Body>
void add(const std::string& name, std::size_t items, bool is_parallel, const Body& body) {
  auto* const added =
      benchmark::RegisterBenchmark(name.c_str(), [items, body](benchmark::State& state) {
        for (auto _ : state) benchmark::DoNotOptimize(body());
        state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(items));
      });
  added->Unit(benchmark::kMillisecond)->Repetitions(5)->ReportAggregatesOnly();
  if (is_parallel) added->UseRealTime()->MeasureProcessCPUTime();
}

template <class Body>
void add(const std::string& name, const Input& input, bool is_parallel, const Body& body) {
  add(name, input.mesh.positions.size(), is_parallel, body);
}

/// What a user has today; items are the scan's vertices, which is what it decodes to.
void add_draco(const Input& input) {
  for (const int level : {7, 10}) {
    for (const int bits : {9, 11}) {
      const auto bytes = draco_encode(input.scan, bits, level);
      if (!bytes) {
        fmt::print("Draco is not there: install libdraco-dev and configure again\n\n");
        return;
      }
      add(fmt::format("decode/draco/level_{}/{}_bits_a_coordinate", level, bits),
          input.scan.positions.size(), false, [b = *bytes] { return draco_decode(b); });
    }
  }
}

void add_decoding(const Input& input) {
  for (const Profile profile : {Profile::kPaper, Profile::kBest}) {
    for (const double bits : {1.0, 4.0, 8.0}) {
      const std::vector<std::uint8_t> bytes = encode(input, profile, bits);
      add(fmt::format("decode/{}/{}_bits_per_input_vertex", name_of(profile), bits), input, false,
          [bytes] { return codec::decode(bytes); });
    }
  }
  add("decode/topology_alone", input, false, [&input] {
    return Topology::build(input.mesh.base_triangles, input.mesh.base_vertex_count,
                           input.mesh.level_count);
  });
  // Not the decoder's usual load: quantised details are mostly zero, and zeros are quick.
  add("decode/synthesis_of_exact_details", input, false,
      [&input] { return wavelet::synthesize(input.topology, input.pyramid); });
}

void add_encoding(const Input& input) {
  add("encode/analysis", input, false,
      [&input] { return wavelet::analyze(input.topology, input.mesh.positions); });
  add("encode/clean", input, false, [&input] { return remesh::clean(input.scan); });
  add("encode/remesh", input, true, [&input] {
    remesh::Options options;
    options.predict = wavelet::predict_at_need;
    return remesh::remesh(input.scan, options);
  });
  for (const Profile profile : {Profile::kPaper, Profile::kBest})
    for (const double bits : {1.0, 4.0})
      add(fmt::format("encode/codec/{}/{}_bits_per_input_vertex", name_of(profile), bits), input,
          true, [&input, profile, bits] { return encode(input, profile, bits); });
}

int main_of(int argc, char** argv) {
  print_head(argc, argv);
  benchmark::Initialize(&argc, argv);
  const std::string file = argc > 1 ? argv[1] : corpus::mesh("horse.ply").string();
  const Input input = make_input(file);
  fmt::print(
      "{}: {} input vertices, {} semi-regular vertices, {} levels; items are semi-regular "
      "vertices\n\n",
      std::filesystem::path(file).filename().string(), input.scan.positions.size(),
      input.mesh.positions.size(), input.mesh.level_count);
  std::fflush(stdout);
  add_decoding(input);
  add_draco(input);
  add_encoding(input);
  benchmark::RunSpecifiedBenchmarks();
  return 0;
}

}  // namespace
}  // namespace nacre::bench

int main(int argc, char** argv) { return nacre::bench::main_of(argc, argv); }
