// A zip archive, not packed; equal files give equal bytes: no times, no owners.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

namespace seam::app {

class ZipWriter {
 public:
  using Sink = std::function<void(std::string_view bytes)>;
  // Throws InputError with the sentence `too_long` where the archive would be longer than 4 GiB,
  // which the format cannot hold without its extension.
  ZipWriter(Sink sink, std::string too_long)
      : sink_(std::move(sink)), too_long_(std::move(too_long)) {}

  // A file whose content is both parts.
  void add(const std::string& name, std::string_view first, std::string_view rest = {});
  // The archive is whole.
  void finish();

 private:
  struct Entry {
    std::string name;
    uint32_t crc = 0, size = 0, place = 0;
  };
  void write(std::string_view bytes);

  const Sink sink_;
  const std::string too_long_;
  std::vector<Entry> entries_;
  uint64_t written_ = 0;
};

}  // namespace seam::app
