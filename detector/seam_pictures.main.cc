// `seam-pictures PATTERN COLUMNS ROWS [MARKER_RATIO DICTIONARY]`: finds a target in pictures. A
// process of its own, which `seam import images` starts, because it decodes what strangers made.
//
// Reads one file name a line and answers each: `size W H`, `time NS` where the picture says it,
// `edge PX`, `corner POINT U V` for each corner or `without WHY`, and `end`.
#include <fcntl.h>
#include <libexif/exif-data.h>
#include <sys/resource.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iostream>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "detector/found.h"

namespace seam::detector {
namespace {

constexpr rlim_t kMostMemory = rlim_t{2} << 30;
// Detectors of circles and tags work at full size, and take up to 60 bytes a pixel.
constexpr size_t kMostPixels = size_t{16} << 20;
constexpr rlim_t kMostSeconds = 60;
constexpr std::streamoff kMostFileBytes = std::streamoff{256} << 20;

void limit_seconds() {
  rusage used{};
  getrusage(RUSAGE_SELF, &used);
  const rlimit seconds{
      static_cast<rlim_t>(used.ru_utime.tv_sec + used.ru_stime.tv_sec) + kMostSeconds,
      RLIM_INFINITY};
  setrlimit(RLIMIT_CPU, &seconds);
}

// The formats that pictures of targets come in, by how they begin; what else the library reads
// stays closed.
bool is_picture(const std::vector<uint8_t>& bytes) {
  static const std::string kBegins[] = {"\x89PNG", "\xff\xd8\xff", "II*", std::string("MM\0*", 4),
                                        "BM",      "P2",           "P3",  "P5",
                                        "P6",      "RIFF"};
  for (const std::string& begin : kBegins) {
    if (bytes.size() > 16 && std::memcmp(bytes.data(), begin.data(), begin.size()) == 0)
      return true;
  }
  return false;
}

std::string exif_text(ExifData* data, ExifTag tag) {
  ExifEntry* entry = exif_content_get_entry(data->ifd[EXIF_IFD_EXIF], tag);
  char text[64] = "";
  return entry ? exif_entry_get_value(entry, text, sizeof text) : "";
}

// DateTimeOriginal with its parts of a second, as nanoseconds since 1970 by the camera's own clock.
void tell_time(const std::vector<uint8_t>& bytes) {
  ExifData* data = exif_data_new_from_data(bytes.data(), static_cast<unsigned>(bytes.size()));
  if (!data) return;
  const std::string stamp = exif_text(data, EXIF_TAG_DATE_TIME_ORIGINAL);
  std::string part = exif_text(data, EXIF_TAG_SUB_SEC_TIME_ORIGINAL);
  exif_data_unref(data);
  tm time{};
  if (std::sscanf(stamp.c_str(), "%4d:%2d:%2d %2d:%2d:%2d", &time.tm_year, &time.tm_mon,
                  &time.tm_mday, &time.tm_hour, &time.tm_min, &time.tm_sec) != 6)
    return;
  time.tm_year -= 1900, time.tm_mon -= 1;
  part = part.substr(0, part.find_first_not_of("0123456789"));
  part.resize(9, '0');
  std::printf("time %lld\n",
              static_cast<long long>(timegm(&time)) * 1'000'000'000LL + std::atoll(part.c_str()));
}

// What a PGM's first comment says of a mosaic of colours (`seam import` writes it so), as the code
// of the conversion to grey; nothing where it is none.
std::optional<int> mosaic_of(const std::vector<uint8_t>& bytes) {
  static const std::pair<const char*, int> kOrders[] = {{"rggb", cv::COLOR_BayerRGGB2GRAY},
                                                        {"bggr", cv::COLOR_BayerBGGR2GRAY},
                                                        {"gbrg", cv::COLOR_BayerGBRG2GRAY},
                                                        {"grbg", cv::COLOR_BayerGRBG2GRAY}};
  for (const auto& [order, code] : kOrders) {
    const std::string begin = std::string("P5\n# bayer ") + order + "\n";
    if (bytes.size() > begin.size() && std::memcmp(bytes.data(), begin.data(), begin.size()) == 0)
      return code;
  }
  return std::nullopt;
}

// As 8 bits of grey: the detectors' form. Brighter than a quarter of full scale, deep pictures are
// stretched, since 12 bits in 16 are dark.
cv::Mat grey(const std::vector<uint8_t>& bytes) {
  cv::Mat picture = cv::imdecode(
      bytes, cv::IMREAD_GRAYSCALE | cv::IMREAD_ANYDEPTH | cv::IMREAD_IGNORE_ORIENTATION);
  if (const auto code = mosaic_of(bytes); code && !picture.empty()) {
    cv::Mat whole;
    cv::cvtColor(picture, whole, *code);
    picture = whole;
  }
  if (picture.empty() || picture.depth() == CV_8U) return picture;
  double most = 0;
  cv::minMaxLoc(picture, nullptr, &most);
  cv::Mat shallow;
  picture.convertTo(shallow, CV_8U, most > 0 ? 255.0 / most : 1.0);
  return shallow;
}

Found find_in(const cv::Mat& picture, const Target& target) {
  if (target.pattern != Pattern::chessboard && picture.total() > kMostPixels)
    return {.corners = {},
            .why =
                "too large: more than 16 million pixels, expected a smaller copy (only "
                "chessboards are searched in larger pictures)"};
  switch (target.pattern) {
    case Pattern::chessboard:
      return find_chessboard(picture, target);
    case Pattern::aprilgrid:
      return find_aprilgrid(picture, target);
    case Pattern::charuco:
      return find_charuco(picture, target);
    default:
      return find_circles(picture, target);
  }
}

void answer(const std::string& name, const Target& target) {
  std::ifstream file(name, std::ios::binary | std::ios::ate);
  const std::streamoff size = file ? std::streamoff(file.tellg()) : -1;
  if (size < 0 || size > kMostFileBytes) {
    std::printf("without cannot be read\n");
    return;
  }
  std::vector<uint8_t> bytes(static_cast<size_t>(size));
  file.seekg(0);
  file.read(reinterpret_cast<char*>(bytes.data()), size);
  const cv::Mat picture = is_picture(bytes) ? grey(bytes) : cv::Mat();
  if (picture.empty() || picture.cols < 16 || picture.rows < 16) {
    std::printf("without no picture that can be read\n");
    return;
  }
  std::printf("size %d %d\n", picture.cols, picture.rows);
  tell_time(bytes);
  const Found found = find_in(picture, target);
  if (found.corners.empty()) std::printf("without %s\n", found.why.c_str());
  if (found.edge_px > 0) std::printf("edge %.4f\n", found.edge_px);
  for (const Corner& corner : found.corners)
    std::printf("corner %d %.6f %.6f\n", corner.point, corner.place.x, corner.place.y);
}

bool take_target(int argc, char** argv, Target& target) {
  static const char* const kNames[] = {"chessboard", "circles", "asymmetric_circles", "aprilgrid",
                                       "charuco"};
  if (argc < 4) return false;
  for (int i = 0; i < 5; ++i) {
    if (std::strcmp(argv[1], kNames[i]) != 0) continue;
    target.pattern = static_cast<Pattern>(i);
    target.columns = std::atoi(argv[2]), target.rows = std::atoi(argv[3]);
    if (target.pattern == Pattern::charuco) {
      if (argc < 6) return false;
      target.marker_ratio = std::atof(argv[4]), target.dictionary = std::atoi(argv[5]);
    }
    return target.columns > 1 && target.rows > 1;
  }
  return false;
}

}  // namespace
}  // namespace seam::detector

int main(int argc, char** argv) {
  using namespace seam::detector;
  Target target;
  if (!take_target(argc, argv, target)) {
    std::fprintf(stderr, "seam-pictures: started by `seam import images`\n");
    return 2;
  }
  // The libraries' words are for nobody.
  const int nowhere = open("/dev/null", O_WRONLY);
  if (nowhere >= 0) dup2(nowhere, STDERR_FILENO);
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
  const rlimit memory{kMostMemory, kMostMemory};
  setrlimit(RLIMIT_AS, &memory);
#endif
  const rlimit core{0, 0};
  setrlimit(RLIMIT_CORE, &core);
  setenv("OPENCV_IO_MAX_IMAGE_PIXELS", "67108864", 1);
  cv::setNumThreads(1);  // A process a core; and the same sums each time.
  for (std::string name; std::getline(std::cin, name);) {
    limit_seconds();
    // The same picture gives the same answer, whatever came before it.
    cv::theRNG().state = 0x5ea3;
    srandom(1);
    try {
      answer(name, target);
    } catch (const std::bad_alloc&) {
      std::printf("without too large: it takes more than 2 GB of memory\n");
    } catch (const cv::Exception& error) {
      const bool memory = error.code == cv::Error::StsNoMem;
      const bool pixels = error.func == "validateInputImageSize";
      std::printf("without %s\n", memory   ? "too large: it takes more than 2 GB of memory"
                                  : pixels ? "too large: more than 64 million pixels"
                                           : "no picture that can be read");
    } catch (const std::exception&) {
      std::printf("without no picture that can be read\n");
    }
    std::printf("end\n");
    std::fflush(stdout);
  }
  return 0;
}
