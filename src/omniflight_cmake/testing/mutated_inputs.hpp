// Programs that feed a reader with damaged inputs, test/fuzz_*.cpp: each defines
//   std::vector<std::string> seeds();                         sound inputs, of our own making
//   void feed(std::string_view input);                        one run; must neither crash, hang nor swallow
//   memory
// Under clang with -fsanitize=fuzzer (launch_scripts/fuzz.sh) libFuzzer mutates by coverage; otherwise the
// main program below mutates blindly, the same inputs in every run of it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

std::vector<std::string> seeds();
void feed(std::string_view input);

#ifdef OMNIFLIGHT_LIBFUZZER

#include <filesystem>
#include <fstream>

/// Writes the seeds as the first corpus into the folder that is the first argument.
extern "C" int LLVMFuzzerInitialize(int* argc, char*** argv) {
  for (int k = 1; k < *argc; ++k) {
    const std::filesystem::path folder((*argv)[k]);
    if ((*argv)[k][0] == '-' || !std::filesystem::is_directory(folder)) continue;
    std::size_t number = 0;
    for (const std::string& seed : seeds())
      std::ofstream(folder / ("seed" + std::to_string(number++)), std::ios::binary) << seed;
    break;
  }
  return 0;
}
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  feed({reinterpret_cast<const char*>(data), size});
  return 0;
}

#else

#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <random>

namespace mutated {

inline constexpr double kLongest_s = 1.0, kMost_MB = 64.0;
inline std::string input;  // of the run that goes on, for the signal handler

inline void keep_input(int signal) {
  const int file = ::open("crash_input", O_WRONLY | O_CREAT | O_TRUNC, 0600);
  if (file >= 0) [[maybe_unused]]
    const ssize_t written = ::write(file, input.data(), input.size());
  static const char said[] = "crashed; the input is in crash_input\n";
  [[maybe_unused]] const ssize_t told = ::write(STDERR_FILENO, said, sizeof said - 1);
  ::signal(signal, SIG_DFL);
  ::raise(signal);
}

using Random = std::mt19937_64;

/// One damage: bits, bytes, sizes that lie, cuts, copies, and pieces of another seed.
inline void damage(std::string& text, const std::string& other, Random& random) {
  const auto at = [&](std::size_t size) { return size == 0 ? 0 : static_cast<std::size_t>(random() % size); };
  static constexpr char kTelling[] = {0, 1, 0x7f, -128, -1, '\n', ' ', '-', '0', '9', '<', '{', '['};
  const std::size_t i = at(text.size()), length = 1 + at(std::min<std::size_t>(64, text.size() + 1));
  switch (random() % 8) {
    case 0:
      if (!text.empty()) text[i] = static_cast<char>(text[i] ^ (1 << random() % 8));
      break;
    case 1:
      if (!text.empty()) text[i] = kTelling[at(sizeof kTelling)];
      break;
    case 2:
      for (std::size_t k = i; k < std::min(text.size(), i + 8); ++k) text[k] = static_cast<char>(random());
      break;
    case 3:  // a size or a count, little endian
      for (std::size_t k = i, huge = random() >> random() % 64; k < std::min(text.size(), i + 4);
           ++k, huge >>= 8)
        text[k] = static_cast<char>(huge);
      break;
    case 4:
      text.resize(i);
      break;
    case 5:
      text.erase(i, length);
      break;
    case 6:
      text.insert(i, text.substr(at(text.size()), length));
      break;
    default:
      text.insert(i, other.substr(at(other.size()), length));
  }
}

inline double peak_MB() {
  rusage used{};
  ::getrusage(RUSAGE_SELF, &used);
  return 1e-3 * static_cast<double>(used.ru_maxrss);
}

}  // namespace mutated

/// OMNIFLIGHT_RUNS: how many; 2000 without. An argument is a file to feed instead, crash_input for instance.
int main(int argc, char** argv) {
  using Clock = std::chrono::steady_clock;
  if (argc > 1) {
    std::FILE* file = std::fopen(argv[1], "rb");
    for (int c; file && (c = std::fgetc(file)) != EOF;) mutated::input.push_back(static_cast<char>(c));
    feed(mutated::input);
    return 0;
  }
  const char* told = std::getenv("OMNIFLIGHT_RUNS");
  const long runs = told ? std::atol(told) : 2000;
  const std::vector<std::string> from = seeds();
  for (const int signal : {SIGSEGV, SIGABRT, SIGBUS, SIGFPE}) ::signal(signal, mutated::keep_input);
  for (const std::string& seed : from) feed(seed);
  const double before_MB = mutated::peak_MB();
  mutated::Random random(1);
  double longest_s = 0;
  for (long k = 0; k < runs; ++k) {
    mutated::input = from[random() % from.size()];
    const std::string& other = from[random() % from.size()];
    for (std::uint64_t n = 1 + random() % 6; n > 0; --n) mutated::damage(mutated::input, other, random);
    const auto begin = Clock::now();
    feed(mutated::input);
    longest_s = std::max(longest_s, std::chrono::duration<double>(Clock::now() - begin).count());
  }
  const double grown_MB = mutated::peak_MB() - before_MB;
  std::printf("%s: %ld mutated inputs: none crashed, the longest took %.1f ms, memory grew by %.1f MB\n",
              program_invocation_short_name, runs, 1e3 * longest_s, grown_MB);
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
  if (longest_s > mutated::kLongest_s || grown_MB > mutated::kMost_MB) return 1;
#endif
  return 0;
}

#endif
