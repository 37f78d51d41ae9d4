// The formats: POSIX.1-2017, pax, "ustar Interchange Format"; RFC 1952 (gzip), by zlib.
#include "app/bundle/archive.h"

#include <zlib.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstring>

#include "sim_core/base/error.h"
#include "sim_core/input/file_names.h"
#include "sim_core/input/shown_text.h"

namespace seam::app {
namespace {

constexpr int kGzip = 15 + 16;  // The widest window, with gzip's head and checksum.
constexpr size_t kPieceBytes = 64 << 10;
// Two at the least, and as many as tar fills its last record of 20 with.
constexpr size_t kMostEndBlocks = 21;

// Places and lengths of ustar's fields.
struct Field {
  size_t at, bytes;
};
constexpr Field kName{0, 100}, kMode{100, 8}, kUser{108, 8}, kGroup{116, 8}, kSize{124, 12},
    kTime{136, 12}, kSum{148, 8}, kKind{156, 1}, kLink{157, 100}, kMagic{257, 8}, kPrefix{345, 155};
constexpr std::string_view kUstar("ustar\00000", 8);
using Block = std::array<char, kTarBlock>;

void put(Block& block, Field field, std::string_view text) {
  std::copy(text.begin(), text.end(), block.begin() + static_cast<long>(field.at));
}
void put_octal(Block& block, Field field, uint64_t number) {
  put(block, field, fmt::format("{:0{}o}", number, field.bytes - 1));
}
std::string_view text_in(const Block& block, Field field) {
  const std::string_view whole(block.data() + field.at, field.bytes);
  return whole.substr(0, whole.find('\0'));
}
std::optional<uint64_t> octal_in(const Block& block, Field field) {
  std::string_view text = text_in(block, field);
  while (text.ends_with(' ')) text.remove_suffix(1);
  if (text.empty()) return std::nullopt;
  uint64_t number = 0;
  for (const char digit : text) {
    if (digit < '0' || digit > '7') return std::nullopt;
    number = number * 8 + static_cast<uint64_t>(digit - '0');
  }
  return number;
}
uint64_t sum_of(Block block) {
  put(block, kSum, std::string(kSum.bytes, ' '));
  uint64_t sum = 0;
  for (const char byte : block) sum += static_cast<unsigned char>(byte);
  return sum;
}

// Where a name is cut in two for ustar's fields; nothing where it fits neither way.
std::optional<size_t> cut_of(const std::string& name) {
  if (name.size() <= kName.bytes) return 0;
  for (size_t at = name.find('/'); at != std::string::npos; at = name.find('/', at + 1))
    if (at > 0 && at <= kPrefix.bytes && name.size() - at - 1 <= kName.bytes) return at;
  return std::nullopt;
}

uint64_t padding_of(uint64_t bytes) {
  return (kTarBlock - bytes % kTarBlock) % kTarBlock;
}

}  // namespace

std::string why_no_archive_name(const std::string& name) {
  if (const std::string why = why_not_inside("/", name); !why.empty()) return why;
  if (name.ends_with('/') || name != std::filesystem::path(name).lexically_normal().string() ||
      name == ".")
    return fmt::format("found '{}', expected a plain name such as work/bot.py", name);
  if (!cut_of(name)) return fmt::format("'{}' is too long for an archive", name);
  return "";
}

struct ArchiveWriter::Stream {
  z_stream z{};
  std::string out = std::string(kPieceBytes, '\0');
};

ArchiveWriter::ArchiveWriter(OutputFile& out) : out_(out), stream_(std::make_unique<Stream>()) {
  const int status =
      deflateInit2(&stream_->z, Z_DEFAULT_COMPRESSION, Z_DEFLATED, kGzip, 8, Z_DEFAULT_STRATEGY);
  SEAM_CHECK(status == Z_OK, "zlib: {}", status);
}

ArchiveWriter::~ArchiveWriter() {
  deflateEnd(&stream_->z);
}

void ArchiveWriter::deflate_more(std::string_view bytes, bool last) {
  z_stream& z = stream_->z;
  z.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data()));
  z.avail_in = static_cast<uInt>(bytes.size());
  do {
    z.next_out = reinterpret_cast<Bytef*>(stream_->out.data());
    z.avail_out = static_cast<uInt>(stream_->out.size());
    deflate(&z, last ? Z_FINISH : Z_NO_FLUSH);
    out_.write(std::string_view(stream_->out).substr(0, stream_->out.size() - z.avail_out));
  } while (z.avail_out == 0);
}

void ArchiveWriter::begin(const std::string& name, uint64_t bytes, bool program) {
  if (const std::string why = why_no_archive_name(name); !why.empty()) throw InputError(why);
  const size_t cut = *cut_of(name);
  Block block{};
  put(block, kName, cut == 0 ? name : name.substr(cut + 1));
  put(block, kPrefix, name.substr(0, cut));
  put_octal(block, kMode, program ? 0755 : 0644);
  for (const Field field : {kUser, kGroup, kTime}) put_octal(block, field, 0);
  put_octal(block, kSize, bytes);
  put(block, kKind, "0");
  put(block, kMagic, kUstar);
  put(block, kSum, fmt::format("{:06o}", sum_of(block)) + std::string("\0 ", 2));
  deflate_more({block.data(), block.size()}, false);
  name_ = name, declared_ = bytes, written_ = 0;
}

void ArchiveWriter::write(std::string_view piece) {
  written_ += piece.size();
  if (written_ <= declared_) deflate_more(piece, false);
}

void ArchiveWriter::end() {
  if (written_ != declared_)
    throw InputError(fmt::format("{}: it changed while it was read: run this again", name_));
  deflate_more(std::string(padding_of(written_), '\0'), false);
}

void ArchiveWriter::finish() {
  deflate_more(std::string(2 * kTarBlock, '\0'), true);
}

struct ArchiveReader::Stream {
  std::unique_ptr<std::FILE, int (*)(std::FILE*)> file{nullptr, &std::fclose};
  z_stream z{};
  std::string in = std::string(kPieceBytes, '\0');
  bool ended = false;  // The compressed bytes did.
};

ArchiveReader::ArchiveReader(const std::filesystem::path& file)
    : file_(file), stream_(std::make_unique<Stream>()) {
  if (std::error_code unknown; std::filesystem::is_regular_file(file, unknown))
    stream_->file.reset(std::fopen(file.c_str(), "rb"));
  if (!stream_->file) throw InputError(fmt::format("{}: cannot be read", file.string()));
  const int status = inflateInit2(&stream_->z, kGzip);
  SEAM_CHECK(status == Z_OK, "zlib: {}", status);
}

ArchiveReader::~ArchiveReader() {
  inflateEnd(&stream_->z);
}

void ArchiveReader::refuse(const std::string& why) const {
  throw InputError(fmt::format("{}: {}; expected a whole bundle, as `seam sweep bundle` writes it",
                               file_.string(), why));
}

bool ArchiveReader::read(char* to, size_t bytes) {
  z_stream& z = stream_->z;
  z.next_out = reinterpret_cast<Bytef*>(to);
  z.avail_out = static_cast<uInt>(bytes);
  while (z.avail_out > 0 && !stream_->ended) {
    if (z.avail_in == 0) {
      std::string& in = stream_->in;
      z.avail_in = static_cast<uInt>(std::fread(in.data(), 1, in.size(), stream_->file.get()));
      z.next_in = reinterpret_cast<Bytef*>(in.data());
      if (z.avail_in == 0) refuse("it is cut off");
    }
    const int status = inflate(&z, Z_NO_FLUSH);
    stream_->ended = status == Z_STREAM_END;
    if (status != Z_OK && status != Z_STREAM_END) refuse("its compressed bytes are damaged");
  }
  if (z.avail_out > 0 && z.avail_out < bytes) refuse("it is cut off");
  return z.avail_out == 0;
}

// After a block of zeros only such blocks follow, and then the end of the file.
void ArchiveReader::read_end(std::string_view first) {
  Block block{};
  std::copy(first.begin(), first.end(), block.begin());
  size_t blocks = 0;
  do {
    const bool zeros = std::all_of(block.begin(), block.end(), [](char byte) { return byte == 0; });
    if (!zeros || ++blocks > kMostEndBlocks) refuse("something follows its end");
  } while (read(block.data(), block.size()));
  if (blocks < 2) refuse("it is cut off");
  if (stream_->z.avail_in > 0 || std::fgetc(stream_->file.get()) != EOF)
    refuse("something follows its end");
}

std::optional<ArchiveReader::Entry> ArchiveReader::next() {
  SEAM_CHECK(left_ == 0, "{} bytes were not read", left_);
  Block block;
  if (!read(block.data(), block.size())) refuse("it is cut off");
  if (block[0] == 0) {
    read_end({block.data(), block.size()});
    return std::nullopt;
  }
  if (octal_in(block, kSum) != sum_of(block) ||
      std::string_view(block.data() + kMagic.at, kMagic.bytes) != kUstar)
    refuse("it holds no ustar entry where one is due");
  Entry entry;
  entry.name = text_in(block, kName);
  if (const std::string_view prefix = text_in(block, kPrefix); !prefix.empty())
    entry.name = std::string(prefix) + "/" + entry.name;
  if (const std::string why = why_no_archive_name(entry.name); !why.empty())
    refuse("a name in it: " + why);
  if (block[kKind.at] != '0' || block[kLink.at] != 0)
    refuse(fmt::format("'{}' in it is no regular file", shown(entry.name)));
  const auto bytes = octal_in(block, kSize), mode = octal_in(block, kMode);
  if (!bytes || !mode) refuse(fmt::format("'{}' in it has no size", shown(entry.name)));
  entry.bytes = left_ = *bytes;
  entry.program = (*mode & 0100) != 0;
  return entry;
}

void ArchiveReader::content(const std::function<void(std::string_view)>& take) {
  std::string piece(kPieceBytes, '\0');
  const uint64_t padding = padding_of(left_);
  while (left_ > 0) {
    const size_t size = static_cast<size_t>(std::min<uint64_t>(left_, piece.size()));
    if (!read(piece.data(), size)) refuse("it is cut off");
    left_ -= size;
    take(std::string_view(piece).substr(0, size));
  }
  Block rest;
  if (padding > 0 && !read(rest.data(), padding)) refuse("it is cut off");
}

}  // namespace seam::app
