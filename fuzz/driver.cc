// What stands in for libFuzzer in ordinary builds, so that every `./test.sh` fuzzes without clang:
// it gives a fuzz target all inputs of its corpus, then mutations of them for some seconds. It
// knows nothing of coverage (scripts/fuzz.sh does); in return it checks two bounds that a crash
// would not show: time and memory for one input.
//
// Usage: fuzz_NAME [--seconds S] [--seed N] FILE_OR_FOLDER...
#include <fcntl.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "sim_core/base/random.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size);

namespace {

constexpr unsigned kSecondsAnInput = 10;
constexpr rlim_t kMemoryBytes = rlim_t{1} << 30;
constexpr size_t kMaxInputBytes = 200'000;

// The input at hand, for the handler of a finding.
std::string current;
std::string finding_path;

void keep_finding(int signal) {
  const int file = ::open(finding_path.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0644);
  if (file >= 0) {
    for (size_t done = 0; done < current.size();) {
      const ssize_t n = ::write(file, current.data() + done, current.size() - done);
      if (n <= 0) break;
      done += static_cast<size_t>(n);
    }
    ::close(file);
  }
  const char* what = signal == SIGALRM ? "fuzz: an input took too long; it is kept in "
                                       : "fuzz: an input ended the program; it is kept in ";
  for (const char* text : {what, finding_path.c_str(), "\n"}) {
    if (::write(STDERR_FILENO, text, std::strlen(text)) < 0) break;
  }
  std::signal(signal, SIG_DFL);
  if (signal == SIGALRM) _exit(1);
  std::raise(signal);
}

void run(std::string input) {
  current = std::move(input);
  alarm(kSecondsAnInput);
  LLVMFuzzerTestOneInput(reinterpret_cast<const uint8_t*>(current.data()), current.size());
  alarm(0);
}

// Numbers and words at which readers stumble.
constexpr const char* kWords[] = {"nan",
                                  ".inf",
                                  "-.inf",
                                  "1e309",
                                  "-1e308",
                                  "1e-320",
                                  "-0",
                                  "0",
                                  "-1",
                                  "2147483648",
                                  "9223372036854775807",
                                  "-9223372036854775808",
                                  "18446744073709551616",
                                  "true",
                                  "null",
                                  "~",
                                  "\"",
                                  "'",
                                  "[",
                                  "]",
                                  "{",
                                  "}",
                                  "- ",
                                  ": ",
                                  "? ",
                                  "&a ",
                                  "*a",
                                  "!!binary ",
                                  "|\n",
                                  "\n",
                                  "\n  ",
                                  "\t",
                                  "#",
                                  ",",
                                  ",,",
                                  "---\n",
                                  "\xEF\xBB\xBF",
                                  "\xFF"};
constexpr uint64_t kNumbers[] = {0,
                                 1,
                                 0x7F,
                                 0x80,
                                 0xFF,
                                 0xFFFF,
                                 0x7FFFFFFF,
                                 0x80000000,
                                 0xFFFFFFFF,
                                 0x7FFFFFFFFFFFFFFF,
                                 0x8000000000000000,
                                 0xFFFFFFFFFFFFFFFF};

// One mutated input is a pure function of (seed, number).
class Mutator {
 public:
  Mutator(const std::vector<std::string>& corpus, uint64_t seed)
      : corpus_(corpus), root_{seed, 0} {}

  std::string make(uint64_t number) {
    stream_ = root_.child(number);
    draws_ = 0;
    std::string input = corpus_[below(corpus_.size())];
    for (uint64_t rounds = uint64_t{1} << below(5); rounds > 0; --rounds) mutate(input);
    if (input.size() > kMaxInputBytes) input.resize(kMaxInputBytes);
    return input;
  }

 private:
  uint64_t below(uint64_t bound) {
    const auto bits = seam::random_bits(stream_, draws_++);
    return ((uint64_t{bits[0]} << 32) | bits[1]) % bound;
  }
  // A stretch of a text, mostly short.
  std::string piece(const std::string& text) {
    const size_t start = below(text.size() + 1);
    return text.substr(start, below(uint64_t{1} << (1 + below(10))));
  }

  void mutate(std::string& input) {
    const size_t at = below(input.size() + 1);
    switch (below(9)) {
      case 0:
        if (at < input.size()) input[at] = static_cast<char>(input[at] ^ (1 << below(8)));
        break;
      case 1:
        if (at < input.size()) input[at] = static_cast<char>(below(256));
        break;
      case 2: {  // A little-endian number.
        const uint64_t number = kNumbers[below(std::size(kNumbers))] + below(3) - 1;
        const size_t size = std::min<size_t>(size_t{1} << below(4), input.size() - at);
        for (size_t i = 0; i < size; ++i) input[at + i] = static_cast<char>(number >> (8 * i));
        break;
      }
      case 3:
        input.erase(at, below(uint64_t{1} << (1 + below(12))));
        break;
      case 4:
        input.insert(at, piece(input));
        break;
      case 5:
        input.insert(at, piece(corpus_[below(corpus_.size())]));
        break;
      case 6:
        input.insert(at, kWords[below(std::size(kWords))]);
        break;
      case 7:
        replace_number(input, at);
        break;
      case 8:
        if (below(8) == 0) input.resize(at);
        break;
    }
  }

  // The decimal number at or behind this place becomes an awkward one.
  void replace_number(std::string& input, size_t at) {
    const size_t start = input.find_first_of("0123456789", at);
    if (start == std::string::npos) return;
    const size_t end = std::min(input.find_first_not_of("0123456789.eE+-", start), input.size());
    input.replace(start, end - start, kWords[below(std::size(kWords))]);
  }

  const std::vector<std::string>& corpus_;
  seam::RandomStream root_;
  seam::RandomStream stream_;
  uint64_t draws_ = 0;
};

void read_inputs(const std::filesystem::path& path, std::vector<std::string>& corpus) {
  std::vector<std::filesystem::path> files = {path};
  if (std::filesystem::is_directory(path)) {
    files.clear();
    for (const auto& entry : std::filesystem::directory_iterator(path)) {
      if (entry.is_regular_file()) files.push_back(entry.path());
    }
    std::sort(files.begin(), files.end());  // The same order everywhere.
  }
  for (const auto& file : files) {
    std::ifstream stream(file, std::ios::binary);
    corpus.emplace_back(std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>());
  }
}

// A reader that takes more fails with bad_alloc, which is a finding.
void limit_memory() {
#ifndef __SANITIZE_ADDRESS__  // Whose shadow alone is larger.
  const rlimit limit{kMemoryBytes, kMemoryBytes};
  setrlimit(RLIMIT_DATA, &limit);
#endif
}

}  // namespace

int main(int argc, char** argv) {
  double seconds = 0;
  uint64_t seed = 1;
  std::vector<std::string> corpus;
  for (int i = 1; i < argc; ++i) {
    const std::string argument = argv[i];
    if (argument == "--seconds" && i + 1 < argc) {
      seconds = std::atof(argv[++i]);
    } else if (argument == "--seed" && i + 1 < argc) {
      seed = std::strtoull(argv[++i], nullptr, 10);
    } else {
      read_inputs(argument, corpus);
    }
  }
  if (corpus.empty()) {
    std::fprintf(stderr, "usage: %s [--seconds S] [--seed N] FILE_OR_FOLDER...\n", argv[0]);
    return 2;
  }
  finding_path = std::string(argv[0]) + ".finding";
  current.reserve(kMaxInputBytes);
  for (const int signal : {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT, SIGALRM})
    std::signal(signal, keep_finding);
  limit_memory();

  for (const std::string& input : corpus) run(input);
  Mutator mutator(corpus, seed);
  uint64_t made = 0;
  const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(seconds);
  while (std::chrono::steady_clock::now() < end) run(mutator.make(made++));
  std::printf("%zu inputs of the corpus, %llu mutated ones, no finding\n", corpus.size(),
              static_cast<unsigned long long>(made));
  return 0;
}
