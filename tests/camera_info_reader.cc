// What ROS's own reader (libcamera-calibration-parsers-dev) finds in a calibration: size, name of
// the lens, the numbers of its matrix and its coefficients, a line each.
#include <camera_calibration_parsers/parse.h>

#include <cstdio>

int main(int argc, char** argv) {
  std::string name;
  sensor_msgs::CameraInfo info;
  if (argc != 2 || !camera_calibration_parsers::readCalibration(argv[1], name, info)) return 1;
  std::printf("%u %u\n%s\n", info.width, info.height, info.distortion_model.c_str());
  for (const double value : info.K) std::printf("%.17g ", value);
  std::printf("\n");
  for (const double value : info.D) std::printf("%.17g ", value);
  std::printf("\n");
  return 0;
}
