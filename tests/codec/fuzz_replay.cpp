// SPDX-License-Identifier: Apache-2.0
//
// Runs the fuzz target without libFuzzer: the examples of docs/FORMAT.md and the files named on the
// command line, and seeded mutations of both. Usage: fuzz_replay ROUNDS [FILE...]
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iterator>

#include "format_examples.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

namespace {

using Bytes = std::vector<std::uint8_t>;

class Random {
 public:
  std::uint32_t below(std::size_t n) {
    state_ = state_ * 6364136223846793005ull + 1442695040888963407ull;
    return static_cast<std::uint32_t>((state_ >> 33) % (n == 0 ? 1 : n));
  }

 private:
  std::uint64_t state_ = 42;
};

void mutate(Bytes& bytes, const std::vector<Bytes>& seeds, Random& random) {
  const std::size_t at = random.below(bytes.size());
  switch (random.below(6)) {
    case 0:
      if (!bytes.empty()) bytes[at] ^= static_cast<std::uint8_t>(1u << random.below(8));
      break;
    case 1:
      if (!bytes.empty()) bytes[at] = static_cast<std::uint8_t>(random.below(256));
      break;
    case 2:
      bytes.resize(at);
      break;
    case 3:
      bytes.insert(bytes.begin() + static_cast<std::ptrdiff_t>(at), random.below(4) + 1,
                   static_cast<std::uint8_t>(random.below(256)));
      break;
    case 4:
      if (!bytes.empty()) bytes.erase(bytes.begin() + static_cast<std::ptrdiff_t>(at));
      break;
    default: {
      const Bytes& other = seeds[random.below(seeds.size())];
      const std::size_t from = random.below(other.size());
      bytes.resize(at);
      bytes.insert(bytes.end(), other.begin() + static_cast<std::ptrdiff_t>(from), other.end());
    }
  }
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 2) {
    std::fprintf(stderr, "usage: fuzz_replay ROUNDS [FILE...]\n");
    return 2;
  }
  std::vector<Bytes> seeds = nacre::format_examples::streams();
  for (int i = 2; i < argc; ++i) {
    std::ifstream file(argv[i], std::ios::binary);
    seeds.emplace_back(std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>());
  }
  if (seeds.empty()) {
    std::fprintf(stderr, "no seeds: docs/FORMAT.md has no example\n");
    return 1;
  }
  for (const Bytes& seed : seeds) LLVMFuzzerTestOneInput(seed.data(), seed.size());
  Random random;
  const int rounds = std::atoi(argv[1]);
  for (int round = 0; round < rounds; ++round) {
    Bytes bytes = seeds[random.below(seeds.size())];
    for (std::uint32_t k = random.below(4) + 1; k > 0; --k) mutate(bytes, seeds, random);
    LLVMFuzzerTestOneInput(bytes.data(), bytes.size());
  }
  std::printf("%d mutations of %zu seeds\n", rounds, seeds.size());
  return 0;
}
